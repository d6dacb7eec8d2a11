// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/library_file.h"

#include <elf.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace lucarium {
namespace fs = std::filesystem;

namespace {

/// A regular file that is open for reading.
class LibraryFile {
 public:
  explicit LibraryFile(const fs::path& file)
      : file_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)), error_(file_ < 0 ? errno : 0) {
    if (file_ < 0 || ::fstat(file_, &state_) == 0) return;
    error_ = errno;
  }
  ~LibraryFile() {
    if (file_ >= 0) ::close(file_);
  }
  LibraryFile(const LibraryFile&) = delete;
  LibraryFile& operator=(const LibraryFile&) = delete;

  int error() const { return error_; }
  bool regular() const { return S_ISREG(state_.st_mode); }

  /// Whether so many bytes are there.
  bool holds(uint64_t offset, uint64_t bytes) const {
    const uint64_t size = static_cast<uint64_t>(state_.st_size);
    return offset <= size && bytes <= size - offset;
  }

  template <class T>
  bool read(uint64_t offset, T& value) const {
    return holds(offset, sizeof value) &&
           ::pread(file_, &value, sizeof value, static_cast<off_t>(offset)) == ssize_t{sizeof value};
  }

 private:
  int file_, error_;
  struct stat state_ = {};
};

/// Whether all that the headers of a library speak of lies within its file.
bool is_whole(const LibraryFile& file, const ElfW(Ehdr) & header) {
  for (size_t i = 0; i < header.e_phnum; ++i) {
    ElfW(Phdr) part;
    if (!file.read(header.e_phoff + i * header.e_phentsize, part) || !file.holds(part.p_offset, part.p_filesz))
      return false;
  }
  for (size_t i = 0; i < header.e_shnum; ++i) {
    ElfW(Shdr) section;
    if (!file.read(header.e_shoff + i * header.e_shentsize, section)) return false;
    if (section.sh_type != SHT_NOBITS && !file.holds(section.sh_offset, section.sh_size)) return false;
  }
  return true;
}

}  // namespace

std::string library_damage(const fs::path& path) {
  // Asked before it is opened too: opening some devices does something.
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return "it is not a regular file";
  const LibraryFile file(path);
  if (file.error()) return std::strerror(file.error());
  if (!file.regular()) return "it is not a regular file";
  ElfW(Ehdr) header;
  if (!file.read(0, header) || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) return "";
  constexpr int own_class = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
  if (header.e_ident[EI_CLASS] != own_class) return "";
  return is_whole(file, header) ? "" : "the file is cut off; build or copy it again";
}

}  // namespace lucarium
