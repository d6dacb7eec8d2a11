// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/truth/error_history.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/json.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr double growth = 1.41421356;
constexpr size_t max_bytes = size_t{256} << 20;  // of images
constexpr size_t max_curves = 24;

ordered_json number_or_null(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

}  // namespace

const ErrorHistory::Curve* ErrorHistory::find(const ViewTechnique& technique) const {
  const auto found =
      std::find_if(curves_.begin(), curves_.end(), [&](const Curve& curve) { return curve.technique == technique; });
  return found == curves_.end() ? nullptr : &*found;
}

bool ErrorHistory::wants(const ViewTechnique& technique, double seconds, bool last) const {
  const Curve* const curve = find(technique);
  if (!curve || curve->points.empty()) return seconds > 0;
  return seconds > (last ? 1.0 : growth) * curve->points.back().seconds;
}

void ErrorHistory::keep(const ViewTechnique& technique, const std::string& paths, double seconds, uint64_t samples,
                        const Film& film) {
  if (!find(technique)) {
    if (curves_.size() >= max_curves) curves_.erase(curves_.begin());
    curves_.push_back({technique, paths, {}});
  }
  const FilmLayer* const variance = film.find("Variance");
  Point point{seconds, samples, NAN, 0, 0, 0, 0, film.image(), variance ? variance->pixels : std::vector<float>()};
  make_room(point.bytes());
  const_cast<Curve*>(find(technique))->points.push_back(std::move(point));
}

void ErrorHistory::forget(const ViewTechnique& technique) {
  std::erase_if(curves_, [&](const Curve& curve) { return curve.technique == technique; });
}

/// Of the oldest curve first: its errors stay as they were measured last.
void ErrorHistory::make_room(size_t bytes) {
  for (const Curve& curve : curves_)
    for (const Point& point : curve.points) bytes += point.bytes();
  for (Curve& curve : curves_) {
    for (Point& point : curve.points) {
      if (bytes <= max_bytes) return;
      bytes -= point.bytes();
      point.image = point.variance = {};
    }
  }
}

bool ErrorHistory::measure_one(const std::string& paths, const GrowingReference& reference) {
  const uint64_t present = reference.measured_samples();
  if (present == 0) return false;
  for (auto curve = curves_.rbegin(); curve != curves_.rend(); ++curve) {
    if (curve->paths != paths) continue;
    for (auto point = curve->points.rbegin(); point != curve->points.rend(); ++point) {
      if (point->measured == present || point->image.empty()) continue;
      point->relmse = reference.relmse(point->image);
      if (!point->variance.empty()) point->noise = reference.noise(point->variance);
      point->flip = reference.flip(point->image);
      point->own = reference.own_relmse();
      point->measured = present;
      return true;
    }
  }
  return false;
}

ordered_json ErrorHistory::describe() const {
  ordered_json curves = ordered_json::array();
  for (const Curve& curve : curves_) {
    ordered_json points = ordered_json::array();
    for (const Point& point : curve.points) {
      if (point.measured == 0) continue;
      points.push_back({{"seconds", point.seconds},
                        {"samples", point.samples},
                        {"relmse", number_or_null(point.relmse)},
                        {"flip", number_or_null(point.flip)},
                        {"noise", number_or_null(point.noise)},
                        {"own", number_or_null(point.own)}});
    }
    curves.push_back({{"technique", curve.technique.name},
                      {"parameters", curve.technique.parameters},
                      {"paths", curve.paths},
                      {"points", std::move(points)}});
  }
  return curves;
}

}  // namespace lucarium
