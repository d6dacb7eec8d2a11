// SPDX-License-Identifier: Apache-2.0
// Reading of state files. Declared in state_file.h. Nothing that a file says is believed before its checksum is right,
// and no size before the file has room for it.
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/technique/state_file.h"
#include "lucarium/technique/state_header.h"
#include "lucarium/technique/state_layout.h"

namespace lucarium {

namespace {

using namespace state_layout;

constexpr const char* again = "; save the state again";

/// Reads a file from its beginning to its end; complaints name it.
class Input {
 public:
  /// Opens it.
  Input(const std::filesystem::path& file, std::ifstream& in) : file_(file), in_(in) {
    require_regular_file(file);
    errno = 0;
    in_.open(file, std::ios::binary);
    if (!in_) fail(fmt::format("cannot be read: {}", std::strerror(errno)), "");
    in_.seekg(0, std::ios::end);
    bytes_ = static_cast<uint64_t>(in_.tellg());
    in_.seekg(0);
  }
  uint64_t bytes() const { return bytes_; }
  uint64_t position() const { return position_; }
  uint64_t left() const { return bytes_ - position_; }
  void read(void* target, uint64_t bytes, const std::string& what) {
    if (bytes > left()) fail(fmt::format("it is cut off in {}", what));
    errno = 0;
    in_.read(static_cast<char*>(target), static_cast<std::streamsize>(bytes));
    if (!in_) fail(fmt::format("cannot be read: {}", std::strerror(errno)), "");
    position_ += bytes;
  }
  std::string text(uint64_t bytes, const std::string& what) {
    if (bytes > left()) fail(fmt::format("it is cut off in {}", what));
    std::string result(bytes, '\0');
    read(result.data(), bytes, what);
    return result;
  }
  /// Checksum of the next bytes.
  Hash128 hash(uint64_t bytes, const std::string& what) {
    if (bytes > left()) fail(fmt::format("it is cut off in {}", what));
    Hasher hasher;
    std::vector<char> block(std::min<uint64_t>(bytes, uint64_t{1} << 20));
    for (uint64_t done = 0; done < bytes;) {
      const uint64_t part = std::min<uint64_t>(block.size(), bytes - done);
      read(block.data(), part, what);
      hasher.add_bytes(block.data(), part);
      done += part;
    }
    return hasher.finish();
  }
  [[noreturn]] void fail(const std::string& what, const char* remedy = again) const {
    throw_error(ErrorClass::input, "{}: {}{}", file_.string(), what, remedy);
  }

 private:
  std::filesystem::path file_;
  std::ifstream& in_;
  uint64_t bytes_ = 0, position_ = 0;
};

bool has_mark(const Record& record, const char (&mark)[4]) {
  return std::equal(std::begin(mark), std::end(mark), record.mark);
}

StateHeader read_header(Input& in) {
  char first[sizeof magic] = {};
  if (in.bytes() >= sizeof first) in.read(first, sizeof first, "its beginning");
  if (!std::equal(std::begin(magic), std::end(magic), first))
    in.fail("it is not a state of a technique", "; --save-state writes one");
  Start start{};
  std::copy(std::begin(first), std::end(first), start.magic);
  in.read(&start.schema, sizeof start - sizeof start.magic, "its header");
  if (start.schema > schema)
    in.fail(fmt::format("it has schema {}, and this program reads up to {}", start.schema, schema),
            "; use the newer program that wrote it, or save the state again");
  if (start.header_bytes > max_header_bytes) in.fail("its header is damaged");
  const std::string text = in.text(start.header_bytes, "its header");
  if (Hasher().add_bytes(&start, 16).add_bytes(text.data(), text.size()).finish() != start.checksum)
    in.fail("its header is damaged");
  try {
    return parse_state_header(text);
  } catch (const Error& error) {
    in.fail(error.what());
  }
}

/// The sizes are possible: those of the file, and of memory before it is asked for.
void check_sizes(const Input& in, const StateChunk& chunk) {
  const auto refuse = [&] {
    in.fail(fmt::format("chunk '{}' says that it has {} elements of {} bytes, which it cannot have", chunk.name,
                        chunk.elements, chunk.element_bytes));
  };
  if (chunk.stored_bytes > in.left()) in.fail(fmt::format("it is cut off in chunk '{}'", chunk.name));
  if (chunk.element_bytes == 0 || chunk.element_bytes > max_element_bytes) refuse();
  if (chunk.elements > std::numeric_limits<uint64_t>::max() / chunk.element_bytes) refuse();
  const uint64_t bytes = chunk.elements * chunk.element_bytes;
  if (chunk.compressed ? bytes / max_ratio > chunk.stored_bytes : bytes != chunk.stored_bytes) refuse();
}

std::string checked_name(Input& in, const Record& record, size_t index) {
  const std::string place = fmt::format("the record of chunk {}", index);
  if (record.name_bytes > max_name_bytes) in.fail(place + " is damaged");
  std::string name = in.text(record.name_bytes, place);
  if (Hasher().add_bytes(&record, 48).add_bytes(name.data(), name.size()).finish() != record.checksum)
    in.fail(place + " is damaged");
  return name;
}

/// All chunks, up to the end of the file; their data are read for their checksums.
std::vector<StateChunk> read_chunks(Input& in) {
  std::vector<StateChunk> chunks;
  Hasher records;
  for (;;) {
    Record record{};
    in.read(&record, sizeof record, chunks.empty() ? "front of its chunks" : "the middle: chunks are missing");
    const std::string name = checked_name(in, record, chunks.size());
    if (has_mark(record, end_mark)) {
      if (record.elements != chunks.size() || record.data != records.finish()) in.fail("chunks are missing");
      if (in.left() > 0) in.fail(fmt::format("{} bytes stand behind its end", in.left()));
      return chunks;
    }
    const bool known = std::any_of(chunks.begin(), chunks.end(), [&](const auto& c) { return c.name == name; });
    if (!has_mark(record, chunk_mark) || record.encoding > Encoding::zlib || known)
      in.fail(fmt::format("the record of chunk {} is damaged", chunks.size()));
    StateChunk chunk{.name = name,
                     .element_bytes = record.element_bytes,
                     .elements = record.elements,
                     .compressed = record.encoding == Encoding::zlib,
                     .stored_bytes = record.stored_bytes,
                     .offset = in.position(),
                     .checksum = record.data};
    check_sizes(in, chunk);
    if (in.hash(chunk.stored_bytes, fmt::format("chunk '{}'", name)) != chunk.checksum)
      in.fail(fmt::format("chunk '{}' is damaged", name));
    records.add(record);
    chunks.push_back(std::move(chunk));
  }
}

}  // namespace

StateFile::StateFile(std::filesystem::path file) : file_(std::move(file)) {
  Input in(file_, in_);
  file_bytes_ = in.bytes();
  header_ = read_header(in);
  chunks_ = read_chunks(in);
}

const StateChunk* StateFile::find(const std::string& name) const {
  const auto found = std::find_if(chunks_.begin(), chunks_.end(), [&](const auto& c) { return c.name == name; });
  return found == chunks_.end() ? nullptr : &*found;
}

size_t StateFile::element_bytes(const std::string& name) const { return find(name)->element_bytes; }

uint64_t StateFile::count(const std::string& name) const { return find(name)->elements; }

void StateFile::get_bytes(const std::string& name, void* target) const {
  const StateChunk& chunk = *find(name);
  const uint64_t bytes = chunk.elements * chunk.element_bytes;
  std::string compressed(chunk.compressed ? chunk.stored_bytes : 0, '\0');
  char* const stored = chunk.compressed ? compressed.data() : static_cast<char*>(target);
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(chunk.offset));
  in_.read(stored, static_cast<std::streamsize>(chunk.stored_bytes));
  if (!in_) fail(name, "it cannot be read any more");
  if (hash_bytes(stored, chunk.stored_bytes) != chunk.checksum) fail(name, "it has changed since the file was opened");
  if (!chunk.compressed) return;
  uLongf size = static_cast<uLongf>(bytes);
  const int result = uncompress(static_cast<Bytef*>(target), &size, reinterpret_cast<const Bytef*>(stored),
                                static_cast<uLong>(chunk.stored_bytes));
  if (result != Z_OK || size != bytes) fail(name, "its zlib stream is wrong");
}

}  // namespace lucarium
