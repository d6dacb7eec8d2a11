// SPDX-License-Identifier: Apache-2.0
#include "subject.h"

#include <fmt/format.h>

#include "lucarium/statistics/statistics.h"

namespace lucarium::bench {

Subject::Subject(std::string name, Scene scene, int max_bounces, const Effort& effort, const Parameters& truth,
                 std::string layer)
    : name_(std::move(name)),
      scene_(std::move(scene)),
      max_bounces_(max_bounces),
      effort_(effort),
      layer_(std::move(layer)) {
  double seconds = 0;
  for (const uint64_t seed : {901u, 902u})
    truth_.push_back(render({truth, uint64_t{effort.samples} * effort.reference}, seed, "reference", &seconds));
}

std::vector<Measured> Subject::measure(const std::vector<Way>& ways) const {
  std::vector<Measured> results(ways.size());
  for (uint32_t seed = 1; seed <= effort_.seeds; ++seed)
    for (size_t i = 0; i < ways.size(); ++i) {
      double seconds = 0;
      const std::string what = fmt::format("way {} of {}", i + 1, ways.size());
      const double error = error_of(render(ways[i], seed, what, &seconds));
      results[i].errors.push_back(error);
      results[i].costs.push_back(error * seconds);
    }
  return results;
}

Subject::Picture Subject::render(const Way& way, uint64_t seed, const std::string& what, double* seconds) const {
  const auto session = make_session(way.technique, scene_, effort_.width, way.parameters, max_bounces_, seed);
  session->run({.samples = way.samples});
  *seconds = session->clocks().iterate_processor;
  fmt::print(stderr, "{}: {}, seed {}, {} samples, {:.1f} s\n", name_, what, seed, way.samples,
             session->clocks().iterate);
  const Film film = session->resolve();
  return layer_.empty() ? film.image() : film.find(layer_)->pixels;
}

/// relMSE of x (docs/metrics.md).
double Subject::error_of(const Picture& x) const {
  const Picture &a = truth_[0], &b = truth_[1];
  double mean = 0, sum = 0;
  for (size_t i = 0; i < a.size(); ++i) mean += 0.5 * (static_cast<double>(a[i]) + static_cast<double>(b[i]));
  mean /= static_cast<double>(a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    const auto va = static_cast<double>(a[i]), vb = static_cast<double>(b[i]), v = static_cast<double>(x[i]);
    const double r = 0.5 * (va + vb);
    sum += (v - va) * (v - vb) / (r * r + 0.01 * mean * mean);
  }
  return sum / static_cast<double>(a.size());
}

void add_ratio(Bars& bars, const std::string& what, double floor, double goal, const std::vector<double>& over,
               const std::vector<double>& under) {
  const ConfidenceInterval ratio = paired_ratio(over, under);
  bars.add(what, floor, goal, ratio.mean);
  bars.note(what + ", 95 % interval from", ratio.low, "");
  bars.note(what + ", 95 % interval to", ratio.high, "");
}

}  // namespace lucarium::bench
