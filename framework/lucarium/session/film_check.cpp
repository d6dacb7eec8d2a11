// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/film_check.h"

#include <fmt/format.h>

#include <string>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"

namespace lucarium {

void check_film(const Film& film, const TechniqueInfo& info) {
  bool additive = false;
  for (const FilmLayer& layer : film.layers()) {
    additive |= layer.additive;
    if (layer.pixels.size() != film.pixel_count() * layer.channels.size() ||
        (layer.additive && layer.channels.size() != 3)) {
      throw_error(ErrorClass::technique, "{}: layer {} has {} values for {} pixels of {} channels", info.name,
                  layer.name, layer.pixels.size(), film.pixel_count(), layer.channels.size());
    }
  }
  if (!additive) throw_error(ErrorClass::technique, "{}: wrote no layer of the image", info.name);
  const BadPixels bad = film.count_bad_pixels();
  const std::string where =
      fmt::format("the first in layer {} at pixel ({}, {})", bad.first_layer, bad.first_x, bad.first_y);
  if (bad.nan + bad.infinite > 0) {
    throw_error(
        ErrorClass::technique,
        "{}: {} values are NaN and {} infinite, {}; lower light near the limits of float in the scene, or report "
        "it to the technique's authors",
        info.name, bad.nan, bad.infinite, where);
  }
  if (bad.negative > 0) log_warning("{}: {} values are negative, {}", info.name, bad.negative, where);
}

}  // namespace lucarium
