// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/film_picture.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/json.h"
#include "lucarium/film/exposure.h"
#include "lucarium/film/image_io.h"
#include "lucarium/view/picture_code.h"

namespace lucarium {

namespace fs = std::filesystem;

namespace {

/// One channel becomes gray, two get a third that is 0; of more the first three are shown.
std::vector<float> three_channels(const FilmLayer& layer, size_t pixels) {
  const size_t channels = layer.channels.size();
  std::vector<float> rgb(3 * pixels);
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const size_t from = channels == 1 ? 0 : c;
      rgb[3 * i + c] = from < channels ? layer.pixels[channels * i + from] : 0;
    }
  }
  return rgb;
}

/// A folder that is gone when the object goes.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "lucarium-view-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw_error(ErrorClass::input, "{}: cannot make a folder", name);
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

std::vector<std::string> layer_names(const Film& film) {
  std::vector<std::string> names;
  for (const FilmLayer& layer : film.layers()) names.push_back(layer.name);
  return names;
}

std::string encode_film(nlohmann::ordered_json header, const Film& film, const std::string& layer, float exposure) {
  const FilmLayer* chosen = layer.empty() ? nullptr : film.find(layer);
  if (!chosen) header["layer"] = "";
  const std::vector<float> rgb = chosen ? three_channels(*chosen, film.pixel_count()) : film.image();
  header["exposure"] = std::isnan(exposure) ? automatic_exposure(rgb) : exposure;
  return encode_view_picture(std::move(header), film.width(), film.height(), rgb);
}

std::string encode_file(const std::string& kind, float exposure, const Film& film) {
  if (kind == "png")
    return encode_view_file("picture.png", encode_png(film.width(), film.height(), film.image(), exposure));
  const ScratchFolder folder;
  const fs::path file = folder.path() / "picture.exr";
  write_exr(file, film);
  return encode_view_file("picture.exr", read_file(file));
}

}  // namespace lucarium
