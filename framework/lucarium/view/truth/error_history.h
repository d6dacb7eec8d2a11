// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "lucarium/film/film.h"
#include "lucarium/view/edits/view_technique.h"
#include "lucarium/view/truth/growing_reference.h"

namespace lucarium {

/// Errors over time of every technique that was tried at one view. Images are kept at times that grow by √2, and
/// measured again when the reference has become better.
class ErrorHistory {
 public:
  /// Whether an image of that technique at that time [s] must be kept. One that comes back adds what lies beyond its
  /// last image. `last`: there will be no later one.
  bool wants(const ViewTechnique& technique, double seconds, bool last) const;
  void keep(const ViewTechnique& technique, const std::string& paths, double seconds, uint64_t samples,
            const Film& film);
  void forget(const ViewTechnique& technique);
  /// Measures the newest image of those light paths that has not met the reference's present image. Returns whether
  /// there was one.
  bool measure_one(const std::string& paths, const GrowingReference& reference);
  /// [{"technique", "parameters", "paths", "points": [{"seconds", "samples", "relmse", "flip", "noise", "own"}]}],
  /// measured ones; "own" is the reference's relMSE then; null where a number is not known.
  nlohmann::ordered_json describe() const;

 private:
  struct Point {
    double seconds = 0;
    uint64_t samples = 0;
    double noise = 0, relmse = 0, flip = 0;
    double own = 0;               ///< relMSE of the reference then
    uint64_t measured = 0;        ///< samples of the reference then; 0: never
    std::vector<float> image;     ///< empty: let go
    std::vector<float> variance;  ///< of its pixels; empty: unknown, or let go
    size_t bytes() const { return (image.size() + variance.size()) * sizeof(float); }
  };
  struct Curve {
    ViewTechnique technique;
    std::string paths;
    std::vector<Point> points;
  };
  const Curve* find(const ViewTechnique& technique) const;
  void make_room(size_t bytes);

  std::vector<Curve> curves_;  ///< in the order in which they were first seen
};

}  // namespace lucarium
