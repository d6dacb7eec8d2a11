// SPDX-License-Identifier: Apache-2.0
// Writing of state files. Declared in state_file.h.
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/technique/state_file.h"
#include "lucarium/technique/state_header.h"
#include "lucarium/technique/state_layout.h"

namespace lucarium {

namespace {

using namespace state_layout;

constexpr int fast_level = 1;  // tables of numbers gain little by more

/// One zlib stream of the bytes.
std::string deflated(const std::string& name, const void* data, size_t bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes));
  std::string stored(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(stored.data()), &size, static_cast<const Bytef*>(data),
                static_cast<uLong>(bytes), fast_level) != Z_OK)
    throw_error(ErrorClass::internal, "zlib cannot compress the chunk '{}' of {} bytes", name, bytes);
  stored.resize(size);
  return stored;
}

class FileWriter : public StateWriter {
 public:
  FileWriter(const std::filesystem::path& file, const StateHeader& header, bool compress)
      : file_(file), compress_(compress), out_(file, std::ios::binary) {
    const std::string text = state_header_text(header);
    Start start{};
    std::copy(std::begin(magic), std::end(magic), start.magic);
    start.schema = schema;
    start.header_bytes = static_cast<uint32_t>(text.size());
    start.checksum = Hasher().add_bytes(&start, 16).add_bytes(text.data(), text.size()).finish();
    write(&start, sizeof start);
    write(text.data(), text.size());
  }

  /// The last record; then everything is in the file.
  void finish() {
    Record last{};
    std::copy(std::begin(end_mark), std::end(end_mark), last.mark);
    last.elements = names_.size();
    last.data = records_.finish();
    last.checksum = hash_bytes(&last, 48);
    write(&last, sizeof last);
    errno = 0;
    out_.close();
    if (!out_) fail();
  }

 protected:
  void put_bytes(const std::string& name, const void* data, size_t element_bytes, uint64_t elements) override {
    const bool good = !name.empty() && name.size() <= max_name_bytes && element_bytes <= max_element_bytes &&
                      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.") == std::string::npos;
    if (!good || !names_.insert(name).second)
      throw_error(ErrorClass::technique, "puts a chunk '{}' whose name is wrong or not new (technique_state.h)", name);
    Record record{};
    std::copy(std::begin(chunk_mark), std::end(chunk_mark), record.mark);
    record.name_bytes = static_cast<uint32_t>(name.size());
    record.element_bytes = static_cast<uint32_t>(element_bytes);
    record.elements = elements;
    record.stored_bytes = element_bytes * elements;
    std::string smaller;
    if (compress_) smaller = deflated(name, data, record.stored_bytes);
    if (compress_ && smaller.size() < record.stored_bytes) {
      record.encoding = Encoding::zlib;
      record.stored_bytes = smaller.size();
      data = smaller.data();
    }
    record.data = hash_bytes(data, record.stored_bytes);
    record.checksum = Hasher().add_bytes(&record, 48).add_bytes(name.data(), name.size()).finish();
    records_.add(record);
    write(&record, sizeof record);
    write(name.data(), name.size());
    write(data, record.stored_bytes);
  }

 private:
  void write(const void* data, uint64_t bytes) {
    errno = 0;
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
    if (!out_) fail();
  }
  [[noreturn]] void fail() const {
    throw_error(ErrorClass::input, "cannot write {}: {}", file_.string(), std::strerror(errno));
  }

  std::filesystem::path file_;
  bool compress_;
  std::ofstream out_;
  std::set<std::string> names_;
  Hasher records_;
};

}  // namespace

void write_state_file(const std::filesystem::path& file, const StateHeader& header, bool compress,
                      const std::function<void(StateWriter&)>& put_chunks) {
  write_file_atomically(file, [&](const std::filesystem::path& temporary) {
    FileWriter writer(temporary, header, compress);
    put_chunks(writer);
    writer.finish();
  });
}

}  // namespace lucarium
