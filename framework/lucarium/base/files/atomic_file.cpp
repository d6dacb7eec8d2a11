// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/files/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/base/files/missing_file.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/byte_size.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

fs::path temporary_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  const std::string name =
      fmt::format(".{}.{}-{}.part{}", target.stem().string(), getpid(), counter++, target.extension().string());
  return target.parent_path() / name;
}

void flush_to_disk(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY);
  if (file < 0 || ::fsync(file) != 0) {
    const int reason = errno;
    if (file >= 0) ::close(file);
    throw_error(ErrorClass::input, "cannot write {}: {}", path.string(), std::strerror(reason));
  }
  ::close(file);
}

/// "; no space is left" if the disk is full, which image libraries do not report.
std::string space_left(const fs::path& target) {
  constexpr uintmax_t little = 1 << 16;
  std::error_code failure;
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const fs::space_info space = fs::space(folder, failure);
  return !failure && space.available < little ? "; no space is left on that device" : "";
}

/// The message with the file's own name instead of the temporary one's.
Error name_target(const Error& error, const fs::path& temporary, const fs::path& target, const std::string& space) {
  std::string text = error.what();
  for (size_t at; (at = text.find(temporary.string())) != std::string::npos;) {
    text.replace(at, temporary.string().size(), target.string());
  }
  if (text.find(std::strerror(ENOSPC)) == std::string::npos) text += space;
  return Error(error.error_class(), text).with_details(error.details());
}

}  // namespace

void write_file_atomically(const fs::path& target, const std::function<void(const fs::path&)>& write) {
  const fs::path temporary = temporary_beside(target);
  const DelayInterrupt until_renamed;  // or the temporary would stay behind
  try {
    write(temporary);
    flush_to_disk(temporary);
    const uintmax_t bytes = fs::file_size(temporary);
    fs::rename(temporary, target);
    if (bytes > 0) log_info("wrote {} ({})", target.string(), format_bytes(bytes));  // an empty one is a probe
  } catch (const fs::filesystem_error& error) {
    const std::string space = space_left(target);
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw_error(ErrorClass::input, "cannot write {}: {}{}", target.string(), error.code().message(), space);
  } catch (const Error& error) {
    const std::string space = space_left(target);
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw name_target(error, temporary, target, space);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

void write_file_atomically(const fs::path& target, std::string_view bytes) {
  write_file_atomically(target, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw_error(ErrorClass::input, "cannot write {}: {}", target.string(), std::strerror(errno));
  });
}

void require_regular_file(const fs::path& path) {
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (!fs::exists(status)) {
    const std::string advice = advice_for_missing(path);
    throw_error(ErrorClass::input, "{}: no such file{}", path.string(), advice.empty() ? "; check its name" : advice);
  }
  if (fs::is_directory(status)) throw_error(ErrorClass::input, "{}: is a folder, not a file", path.string());
  if (!fs::is_regular_file(status))
    throw_error(ErrorClass::input, "{}: is a pipe or a device, not a file", path.string());
}

std::string read_file(const fs::path& path, uintmax_t limit_bytes) {
  require_regular_file(path);
  std::error_code failure;
  const uintmax_t size = fs::file_size(path, failure);
  if (failure) throw_error(ErrorClass::input, "{}: {}", path.string(), failure.message());
  if (size > limit_bytes) {
    throw_error(ErrorClass::input, "{}: {} bytes is more than the {} this reader accepts", path.string(), size,
                limit_bytes);
  }
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) throw_error(ErrorClass::input, "{}: cannot be read: {}", path.string(), std::strerror(errno));
  return bytes;
}

}  // namespace lucarium
