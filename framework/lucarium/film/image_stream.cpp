// SPDX-License-Identifier: Apache-2.0
#include "lucarium/film/image_stream.h"

#include <OpenImageIO/filesystem.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"

namespace lucarium {
namespace fs = std::filesystem;

namespace {

constexpr size_t band_bytes = size_t{16} << 20;
constexpr size_t band_alignment = 64;  // rows; files are compressed in blocks of up to so many

/// A file that remembers the first write that failed.
class CheckedFile : public OIIO::Filesystem::IOProxy {
 public:
  explicit CheckedFile(const fs::path& file)
      : IOProxy(file.string(), Write), file_(::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (file_ < 0) error_ = errno;
  }
  ~CheckedFile() override { close(); }

  const char* proxytype() const override { return "checked file"; }
  size_t size() const override { return size_; }

  size_t write(const void* bytes, size_t count) override {
    const size_t written = pwrite(bytes, count, m_pos);
    m_pos += static_cast<int64_t>(written);
    return written;
  }

  size_t pwrite(const void* bytes, size_t count, int64_t offset) override {
    size_t written = 0;
    while (written < count && error_ == 0) {
      const ssize_t step = ::pwrite(file_, static_cast<const char*>(bytes) + written, count - written,
                                    offset + static_cast<int64_t>(written));
      if (step < 0 && errno == EINTR) continue;
      if (step <= 0) {
        error_ = step < 0 ? errno : ENOSPC;
      } else {
        written += static_cast<size_t>(step);
      }
    }
    size_ = std::max(size_, static_cast<size_t>(offset) + written);
    return written;
  }

  void close() override {
    if (file_ >= 0 && ::close(file_) != 0 && error_ == 0) error_ = errno;
    file_ = -1;
  }

  /// Number of the first error, or 0.
  int first_error() const { return error_; }

 private:
  int file_ = -1, error_ = 0;
  size_t size_ = 0;
};

/// read_scanlines() divides by the attribute and rounds up to a multiple of it, whatever a file says there.
bool has_usable_strips(const OIIO::ImageSpec& spec) {
  const int rows = spec.get_int_attribute("tiff:RowsPerStrip", 1);
  return spec.tile_width > 0 || (rows >= 1 && rows <= (1 << 20));
}

bool read_single_rows(OIIO::ImageInput& input, int first_channel, int end_channel, const OIIO::TypeDesc& type,
                      const std::function<void(size_t rows, const void* values)>& visit) {
  const OIIO::ImageSpec spec = input.spec();
  const size_t width = static_cast<size_t>(spec.width), pixel_bytes = static_cast<size_t>(spec.nchannels) * type.size();
  const size_t first = static_cast<size_t>(first_channel) * type.size();
  const size_t wanted = static_cast<size_t>(end_channel) * type.size() - first;
  std::vector<unsigned char> row(width * pixel_bytes);
  for (int y = spec.y; y < spec.y + spec.height; ++y) {
    if (!input.read_scanline(y, spec.z, type, row.data())) return false;
    for (size_t x = 0; x < width; ++x) std::memmove(&row[x * wanted], &row[x * pixel_bytes + first], wanted);
    visit(1, row.data());
  }
  return true;
}

}  // namespace

bool read_rows(OIIO::ImageInput& input, int first_channel, int end_channel, const OIIO::TypeDesc& type,
               const std::function<void(size_t rows, const void* values)>& visit) {
  const OIIO::ImageSpec spec = input.spec();
  if (!has_usable_strips(spec)) return read_single_rows(input, first_channel, end_channel, type, visit);
  const size_t height = static_cast<size_t>(spec.height);
  const size_t row_bytes =
      static_cast<size_t>(spec.width) * static_cast<size_t>(end_channel - first_channel) * type.size();
  const size_t unit = spec.tile_width > 0 ? static_cast<size_t>(spec.tile_height) : band_alignment;
  size_t rows_at_once = std::max<size_t>(1, band_bytes / row_bytes);
  if (rows_at_once >= unit || spec.tile_width > 0) rows_at_once = std::max<size_t>(1, rows_at_once / unit) * unit;
  rows_at_once = std::min(rows_at_once, height);
  std::vector<unsigned char> band(rows_at_once * row_bytes);
  for (size_t row = 0; row < height; row += rows_at_once) {
    const size_t rows = std::min(rows_at_once, height - row);
    const int begin = spec.y + static_cast<int>(row), end = begin + static_cast<int>(rows);
    const bool read = spec.tile_width > 0 ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z,
                                                             spec.z + 1, first_channel, end_channel, type, band.data())
                                          : input.read_scanlines(0, 0, begin, end, spec.z, first_channel, end_channel,
                                                                 type, band.data());
    if (!read) return false;
    visit(rows, band.data());
  }
  return true;
}

void write_image_file(const fs::path& file, const OIIO::ImageSpec& spec, const OIIO::TypeDesc& type,
                      const void* pixels) {
  write_file_atomically(file, [&](const fs::path& part) {
    CheckedFile stream(part);
    const std::unique_ptr<OIIO::ImageOutput> out = OIIO::ImageOutput::create(part.string());
    const bool encoded = out && stream.first_error() == 0 && out->set_ioproxy(&stream) &&
                         out->open(part.string(), spec) && out->write_image(type, pixels) && out->close();
    stream.close();
    if (const int error = stream.first_error()) {
      throw_error(ErrorClass::input, "cannot write {}: {}", file.string(), std::strerror(error));
    }
    if (!encoded)
      throw_error(ErrorClass::input, "cannot write {}: {}", file.string(), out ? out->geterror() : OIIO::geterror());
  });
}

}  // namespace lucarium
