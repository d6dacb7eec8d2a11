// SPDX-License-Identifier: Apache-2.0
//
// Why PoCL's own cache does not do: from source it always preprocesses a megabyte of headers, and asked for a binary it
// compiles one more variant of every kernel (pocl_files.h avoids that). Its folder cannot be trusted from one process
// to the next either: a damaged program.bc or .so there ends the process. Hence a folder per process (DriverFolder),
// filled from verified entries. What each way costs: docs/measurements/building.md.
#include "lucarium/compute/device/program_cache.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/log.h"
#include "lucarium/compute/device/cache_folder.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr char magic[8] = {'L', 'U', 'C', 'P', 'R', 'O', 'G', '1'};
constexpr uintmax_t largest_entry = uintmax_t{256} << 20;
constexpr uintmax_t largest_folder = uintmax_t{512} << 20;

struct Header {
  char magic[8];
  uint64_t payload_bytes;
  Hash128 checksum;  // of the key and the payload, so that an entry under a wrong name is not taken either
};

Hash128 checksum_of(const Hash128& key, std::string_view payload) { return Hasher().add(key).add(payload).finish(); }

class Writer {
 public:
  void number(uint64_t value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void text(std::string_view value) {
    number(value.size());
    bytes_.append(value);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Bounds are checked although the checksum is right: a later version may write other content.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  uint64_t number() {
    uint64_t value = 0;
    const std::string_view bytes = take(sizeof value);
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::string text() { return std::string(take(number())); }
  /// A count of things that take at least 8 bytes each.
  uint64_t count() {
    const uint64_t value = number();
    if (value > rest_.size() / 8) throw_error(ErrorClass::internal, "a list ends early");
    return value;
  }

 private:
  std::string_view take(uint64_t bytes) {
    if (bytes > rest_.size()) throw_error(ErrorClass::internal, "the entry ends early");
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(bytes);
    return taken;
  }
  std::string_view rest_;
};

std::string serialize(const CachedProgram& program) {
  Writer out;
  out.text(program.binary);
  out.text(program.driver_program);
  out.number(program.signatures.size());
  for (const KernelSignature& signature : program.signatures) {
    out.text(signature.name);
    for (const size_t size : signature.required_work_group_size) out.number(size);
    out.number(signature.arguments.size());
    for (const KernelArgument& argument : signature.arguments) {
      out.text(argument.name);
      out.text(argument.type);
      out.number(static_cast<uint64_t>(argument.access));
    }
  }
  out.number(program.driver_files.size());
  for (const DriverFile& file : program.driver_files) {
    out.text(file.path);
    out.text(file.bytes);
  }
  return out.take();
}

CachedProgram deserialize(std::string_view payload) {
  Reader in(payload);
  CachedProgram program;
  program.binary = in.text();
  program.driver_program = in.text();
  program.signatures.resize(in.count());
  for (KernelSignature& signature : program.signatures) {
    signature.name = in.text();
    for (size_t& size : signature.required_work_group_size) size = in.number();
    signature.arguments.resize(in.count());
    for (KernelArgument& argument : signature.arguments) {
      argument.name = in.text();
      argument.type = in.text();
      argument.access = static_cast<ArgumentAccess>(in.number());
    }
  }
  program.driver_files.resize(in.count());
  for (DriverFile& file : program.driver_files) {
    file.path = in.text();
    file.bytes = in.text();
  }
  return program;
}

/// Warns once per process and folder: what hinders one file hinders the others.
void warn_once(const fs::path& folder, const std::string& text) {
  static std::mutex mutex;
  static std::set<fs::path> said;
  const std::lock_guard lock(mutex);
  if (said.insert(folder).second) log_warning("{}", text);
}

}  // namespace

ProgramCache::ProgramCache(const DeviceOptions& options, const DeviceInfo& device)
    : folder_(resolve_cache_dir(options) / "programs"),
      device_identity_(fmt::format("{}\n{}\n{}\n{}\n{}\n{}", device.name, device.vendor, device.driver_version,
                                   device.opencl_version, device.platform, device.platform_version)),
      enabled_(options.use_cache && (!device.is_pocl || driver_folder())) {
  if (!enabled_) return;
  const std::string problem = why_not_writable(folder_);
  writable_ = problem.empty();
  if (!writable_) {
    warn_once(
        folder_,
        fmt::format("cache folder {} cannot be written ({}); compiled kernels will not be kept. Choose another with "
                    "--cache-dir or LUCARIUM_CACHE_DIR",
                    folder_.string(), problem));
  }
}

Hash128 ProgramCache::key(const std::string& source, const std::string& options) const {
  return Hasher().add(source).add(options).add(device_identity_).add(LUCARIUM_VERSION).finish();
}

fs::path ProgramCache::file_of(const Hash128& key) const { return folder_ / (key.hex() + ".program"); }

std::optional<CachedProgram> ProgramCache::load(const Hash128& key) const {
  if (!enabled_) return std::nullopt;
  const fs::path path = file_of(key);
  std::error_code failure;
  if (!fs::exists(path, failure)) return std::nullopt;
  try {
    const std::string bytes = read_file(path, largest_entry);
    Header header{};
    if (bytes.size() < sizeof header) throw_error(ErrorClass::input, "too short");
    std::memcpy(&header, bytes.data(), sizeof header);
    const std::string_view payload = std::string_view(bytes).substr(sizeof header);
    if (std::memcmp(header.magic, magic, sizeof magic) != 0) throw_error(ErrorClass::input, "not a program");
    if (header.payload_bytes != payload.size()) throw_error(ErrorClass::input, "wrong length");
    if (header.checksum != checksum_of(key, payload)) throw_error(ErrorClass::input, "wrong checksum");
    CachedProgram program = deserialize(payload);
    fs::last_write_time(path, fs::file_time_type::clock::now(), failure);  // the oldest go first
    return program;
  } catch (const std::exception& error) {
    log_debug("program cache: {} is rebuilt: {}", path.string(), error.what());
    discard(key);
    return std::nullopt;
  }
}

void ProgramCache::store(const Hash128& key, const CachedProgram& program) const noexcept {
  if (!enabled_ || !writable_) return;
  try {
    const std::string payload = serialize(program);
    Header header{};
    std::memcpy(header.magic, magic, sizeof magic);
    header.payload_bytes = payload.size();
    header.checksum = checksum_of(key, payload);
    std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
    if (payload.size() + sizeof header > largest_entry) return;
    write_file_atomically(file_of(key), bytes + payload);
    remove_oldest();
  } catch (const std::exception& error) {
    warn_once(folder_, fmt::format("compiled kernels are not kept: {}", error.what()));
  }
}

void ProgramCache::discard(const Hash128& key) const noexcept {
  std::error_code ignored;
  fs::remove(file_of(key), ignored);
}

void ProgramCache::remove_oldest() const {
  struct Entry {
    fs::file_time_type used;
    uintmax_t bytes;
    fs::path path;
  };
  std::vector<Entry> entries;
  uintmax_t total = 0;
  std::error_code failure;
  for (fs::directory_iterator entry(folder_, failure), end; !failure && entry != end; entry.increment(failure)) {
    std::error_code gone;  // another process may remove files meanwhile
    const uintmax_t bytes = entry->file_size(gone);
    const auto used = entry->last_write_time(gone);
    if (gone) continue;
    entries.push_back({used, bytes, entry->path()});
    total += bytes;
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (total <= largest_folder) return;
    std::error_code ignored;
    fs::remove(entry.path, ignored);
    total -= entry.bytes;
  }
}

}  // namespace lucarium
