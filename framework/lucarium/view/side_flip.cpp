// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/side_flip.h"

#include <cmath>
#include <numeric>

#include "lucarium/base/json.h"
#include "lucarium/film/exposure.h"
#include "lucarium/metrics/flip.h"
#include "lucarium/view/picture_code.h"
#include "lucarium/view/view_side.h"

namespace lucarium {

namespace {

constexpr double share = 0.05;  // of the time

/// Values that are not finite become 0: FlipReference takes none.
std::vector<float> finite(std::vector<float> rgb) {
  for (float& value : rgb)
    if (!std::isfinite(value)) value = 0;
  return rgb;
}

}  // namespace

std::optional<std::string> SideFlip::between(const ViewSide& first, const ViewSide& second, float exposure,
                                             uint64_t number) {
  if (!first.film() || !second.film() || first.film_divisor() != 1 || second.film_divisor() != 1) return std::nullopt;
  if (first.film_number() == first_ && second.film_number() == second_) return std::nullopt;
  if (since_.seconds() < cost_ / share) return std::nullopt;
  const Stopwatch watch;
  const Film& film = *first.film();
  const std::vector<float> reference = finite(film.image());
  const FlipView view{std::isnan(exposure) ? automatic_exposure(reference) : exposure, false};
  const std::vector<float> map =
      FlipReference(film.width(), film.height(), reference, {view}).error_map(second.film()->image());
  std::vector<float> rgb(3 * map.size());
  for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = map[i / 3];
  const double mean = std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
  first_ = first.film_number();
  second_ = second.film_number();
  cost_ = watch.seconds();
  since_.restart();
  return encode_view_picture({{"picture", number}, {"side", view_sides}, {"flip", mean}}, film.width(), film.height(),
                             rgb);
}

}  // namespace lucarium
