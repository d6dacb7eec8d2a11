// SPDX-License-Identifier: Apache-2.0
// Time to an error beside path_tracing. Its error after one sample is the difference of two independent pictures, and
// falls as 1 / samples; so its time to any error is known without waiting for it. The field's error is measured against
// both pictures, whose own noise cancels: <(x - a)(x - b)> is that of x alone.
#include <algorithm>
#include <cmath>

#include "rendering.h"

namespace lucarium::bench {
namespace {

constexpr double kError = 1e-3;       // relMSE
constexpr uint32_t kMaxSamples = 64;  // of the field's pixels
constexpr uint32_t kWalk = 48;        // frames

using Picture = std::vector<float>;

/// Mean of (x - a)(y - b) / (r^2 + .01 mean(r)^2), r = (a + b) / 2: metrics.h's relMSE where x = y and a = b.
double relative(const Picture& x, const Picture& y, const Picture& a, const Picture& b) {
  double mean = 0, sum = 0;
  for (size_t i = 0; i < a.size(); ++i) mean += 0.5 * (static_cast<double>(a[i]) + static_cast<double>(b[i]));
  mean /= static_cast<double>(a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    const auto va = static_cast<double>(a[i]), vb = static_cast<double>(b[i]), r = 0.5 * (va + vb);
    sum += (static_cast<double>(x[i]) - va) * (static_cast<double>(y[i]) - vb) / (r * r + 0.01 * mean * mean);
  }
  return sum / static_cast<double>(a.size());
}

struct Traced {
  Picture a, b;
  double seconds_per_sample = 0, relmse_of_sample = 0;
  double seconds_to(double relmse) const { return relmse_of_sample / relmse * seconds_per_sample; }
};

Traced trace(const Scene& scene, const Sizes& sizes) {
  Traced result;
  for (Picture* picture : {&result.a, &result.b}) {
    const auto session = make_session("path_tracing", scene, sizes.width, {}, -1, picture == &result.a ? 11 : 12);
    session->run({.samples = sizes.reference});
    *picture = session->resolve().image();
    result.seconds_per_sample += session->clocks().iterate / sizes.reference / 2;
  }
  result.relmse_of_sample = sizes.reference * relative(result.a, result.b, result.b, result.a) / -2;
  return result;
}

/// The field after so many samples: the error it reaches, and how long that took.
struct Reached {
  double relmse = 0, light = 0, seconds = 0;
  uint32_t samples = 0;
};

Reached propagate(const Scene& scene, const Sizes& sizes, const Traced& traced) {
  const auto session = make_session("virtual_light_field", scene, sizes.width, {{"preview", "off"}});
  session->finish_light();
  Reached result;
  result.light = session->clocks().light;
  for (uint32_t samples = 1; samples <= kMaxSamples; samples *= 2) {
    session->run({.samples = samples});
    const Picture x = session->resolve().image();
    result.relmse = relative(x, x, traced.a, traced.b);
    result.seconds = session->clocks().iterate;
    result.samples = samples;
    if (result.relmse <= kError) break;
  }
  return result;
}

}  // namespace

void measure_errors(Bars& bars, const Sizes& sizes) {
  const Scene scene = load_scene("builtin:cornell-mirror");
  const Traced traced = trace(scene, sizes);
  const Reached field = propagate(scene, sizes, traced);
  bars.note("path_tracing, relMSE of one sample", traced.relmse_of_sample, "");
  bars.note("path_tracing, elapsed time of one sample", 1e3 * traced.seconds_per_sample, "ms");
  bars.note("path_tracing, time to relMSE 0.001", traced.seconds_to(kError), "s");
  bars.note("field, light", field.light, "s");
  bars.note("field, samples", field.samples, "");
  bars.note("field, relMSE with them", field.relmse, "");
  const double frame = field.seconds, all = field.light + frame;
  const bool reached = field.relmse <= kError;
  const auto bar = [&](const std::string& what, double floor, double goal, double value) {
    bars.add(what, floor, goal, reached ? value : NAN);
    if (!reached) bars.note(what + ", at the error that the field has", value, "");
  };
  const double error = reached ? kError : field.relmse;
  bar("path_tracing's time to relMSE 0.001 over the field's", 1.5, 4, traced.seconds_to(error) / all);
  bar("the same for a walk of 48 frames", 40, 120, kWalk * traced.seconds_to(error) / (field.light + kWalk * frame));
}

}  // namespace lucarium::bench
