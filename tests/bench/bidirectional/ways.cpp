// SPDX-License-Identifier: Apache-2.0
// Products of error and time, which do not depend on how long pictures take: both fall as one over the other. Errors
// are measured against two independent pictures, whose own noise cancels: <(x - a)(x - b)> is that of x alone.
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/statistics/statistics.h"
#include "measures.h"
#include "rendering.h"

namespace lucarium::bench {
namespace {

using Picture = std::vector<float>;

Picture indirect_of(RenderSession& session) { return session.resolve().find("indirect")->pixels; }

/// relMSE of x (docs/metrics.md).
double error_of(const Picture& x, const Picture& a, const Picture& b) {
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

/// Errors of pictures by seed, and the time that each takes.
struct Measured {
  std::vector<double> errors, costs;
};

class Subject {
 public:
  Subject(Scene scene, int max_bounces, const Effort& effort, const Parameters& truth)
      : scene_(std::move(scene)), max_bounces_(max_bounces), effort_(effort) {
    for (const uint64_t seed : {901u, 902u}) {
      const auto session = begin(truth, seed);
      session->run({.samples = uint64_t{effort.samples} * effort.reference});
      truth_.push_back(indirect_of(*session));
    }
  }

  Measured measure(const Parameters& parameters) const {
    Measured result;
    for (uint32_t seed = 1; seed <= effort_.seeds; ++seed) {
      const auto session = begin(parameters, seed);
      session->run({.samples = effort_.samples});
      result.errors.push_back(error_of(indirect_of(*session), truth_[0], truth_[1]));
      result.costs.push_back(result.errors.back() * session->clocks().iterate);
    }
    return result;
  }

 private:
  std::unique_ptr<RenderSession> begin(Parameters parameters, uint64_t seed) const {
    parameters.emplace_back("adapt", "off");
    return make_session("bidirectional_vpl", scene_, effort_.width, parameters, max_bounces_, seed);
  }

  Scene scene_;
  int max_bounces_;
  Effort effort_;
  std::vector<Picture> truth_;
};

/// A bar, and the interval over seeds.
void add(Bars& bars, const std::string& what, double floor, double goal, const std::vector<double>& over,
         const std::vector<double>& under) {
  const ConfidenceInterval ratio = paired_ratio(over, under);
  bars.add(what, floor, goal, ratio.mean);
  bars.note(what + ", 95 % interval from", ratio.low, "");
  bars.note(what + ", 95 % interval to", ratio.high, "");
}

}  // namespace

void measure_ways(Bars& bars, const Effort& effort) {
  const Subject room(load_scene("builtin:room"), 4, effort, {});
  add(bars, "room, error times time: vpl_choice=all over resample", 1.3, 2, room.measure({{"vpl_choice", "all"}}).costs,
      room.measure({}).costs);
  const Subject fixture(load_scene("builtin:fixture"), 4, effort, {});
  add(bars, "fixture, error times time: light_vertices=1 over 4", 10, 25,
      fixture.measure({{"light_vertices", "1"}}).costs, fixture.measure({}).costs);

  // Light of two scatterings in a corner, by directions of bundles and by one connection.
  Scene corner = load_scene("builtin:room");
  const glm::vec3 low = corner.bounds().min;
  SceneCamera& camera = corner.cameras.front();
  camera.world_from_camera = glm::inverse(glm::lookAt(low + glm::vec3(0.2f), low, {0, 1, 0}));
  const auto with = [](const char* strategy) {
    return Parameters{{"strategy", strategy},   {"light_vertices", "1"}, {"splat", "on"},
                      {"directions", "bundle"}, {"candidates", "1"},     {"bundles", "4096"}};
  };
  const Subject seen(corner, 1, effort, {{"light_vertices", "1"}});
  const Measured both = seen.measure(with("all")), vpl = seen.measure(with("vpl")), nee = seen.measure(with("nee"));
  const auto error = [](const Measured& m) { return seed_mean(m.errors).mean; };
  bars.note("corner, relMSE by virtual lights", error(vpl), "");
  bars.note("corner, relMSE by bundles", error(nee), "");
  bars.note("corner, relMSE by both", error(both), "");
  add(bars, "corner, error: the better strategy alone over both", 3, 6, (error(vpl) < error(nee) ? vpl : nee).errors,
      both.errors);
}

}  // namespace lucarium::bench
