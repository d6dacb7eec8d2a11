// SPDX-License-Identifier: Apache-2.0
#include "subject.h"

#include "lucarium/statistics/statistics.h"

namespace lucarium::bench {

Subject::Subject(Scene scene, int max_bounces, const Effort& effort, const Parameters& truth, std::string layer)
    : scene_(std::move(scene)), max_bounces_(max_bounces), effort_(effort), layer_(std::move(layer)) {
  for (const uint64_t seed : {901u, 902u}) {
    const auto session = begin("bidirectional_vpl", truth, seed);
    session->run({.samples = uint64_t{effort.samples} * effort.reference});
    truth_.push_back(picture_of(*session));
  }
}

Measured Subject::measure(const std::string& technique, const Parameters& parameters, uint64_t samples) const {
  Measured result;
  for (uint32_t seed = 1; seed <= effort_.seeds; ++seed) {
    const auto session = begin(technique, parameters, seed);
    session->run({.samples = samples});
    result.errors.push_back(error_of(picture_of(*session)));
    result.costs.push_back(result.errors.back() * session->clocks().iterate);
  }
  return result;
}

std::unique_ptr<RenderSession> Subject::begin(const std::string& technique, const Parameters& parameters,
                                              uint64_t seed) const {
  return make_session(technique, scene_, effort_.width, parameters, max_bounces_, seed);
}

Subject::Picture Subject::picture_of(RenderSession& session) const {
  const Film film = session.resolve();
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
