// SPDX-License-Identifier: Apache-2.0
// Products of error and time, which do not depend on how long pictures take: both fall as one over the other. Errors
// are measured against two independent pictures, whose own noise cancels: <(x - a)(x - b)> is that of x alone.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "measures.h"
#include "rendering.h"

namespace lucarium::bench {

/// Errors of pictures by seed, and their products with the time that each takes [s].
struct Measured {
  std::vector<double> errors, costs;
};

/// A scene, what is seen of it, and what is right.
class Subject {
 public:
  /// The truth is by bidirectional_vpl with parameters `truth`. `layer`: the part of pictures that is compared; empty:
  /// all.
  Subject(Scene scene, int max_bounces, const Effort& effort, const Parameters& truth, std::string layer = {});

  Measured measure(const std::string& technique, const Parameters& parameters, uint64_t samples) const;
  Measured measure(const Parameters& parameters) const {
    return measure("bidirectional_vpl", parameters, effort_.samples);
  }

 private:
  using Picture = std::vector<float>;

  std::unique_ptr<RenderSession> begin(const std::string& technique, const Parameters& parameters, uint64_t seed) const;
  Picture picture_of(RenderSession& session) const;
  double error_of(const Picture& x) const;

  Scene scene_;
  int max_bounces_;
  Effort effort_;
  std::string layer_;
  std::vector<Picture> truth_;
};

/// A bar of the ratio, and its interval over seeds.
void add_ratio(Bars& bars, const std::string& what, double floor, double goal, const std::vector<double>& over,
               const std::vector<double>& under);

}  // namespace lucarium::bench
