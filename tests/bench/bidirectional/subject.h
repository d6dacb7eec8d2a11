// SPDX-License-Identifier: Apache-2.0
// Products of error and processor time, which do not depend on how long pictures take: both fall as one over the other.
// Errors are measured against two independent pictures, whose own noise cancels: <(x - a)(x - b)> is that of x alone,
// so that these need not be much better than x.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "measures.h"
#include "rendering.h"

namespace lucarium::bench {

/// One way to render.
struct Way {
  Parameters parameters;
  uint64_t samples;
  std::string technique = "bidirectional_vpl";
};

/// Errors of pictures by seed, and their products with the processor time that each takes [s].
struct Measured {
  std::vector<double> errors, costs;
};

/// A scene, what is seen of it, and what is right. Says on stderr what it has rendered.
class Subject {
 public:
  /// The truth is by bidirectional_vpl with parameters `truth`. `layer`: the part of pictures that is compared; empty:
  /// all.
  Subject(std::string name, Scene scene, int max_bounces, const Effort& effort, const Parameters& truth,
          std::string layer = {});

  /// The ways take turns, seed by seed.
  std::vector<Measured> measure(const std::vector<Way>& ways) const;

 private:
  using Picture = std::vector<float>;

  Picture render(const Way& way, uint64_t seed, const std::string& what, double* seconds) const;
  double error_of(const Picture& x) const;

  std::string name_;
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
