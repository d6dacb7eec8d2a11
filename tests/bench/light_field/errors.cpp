// SPDX-License-Identifier: Apache-2.0
// Time to an error beside path_tracing. Its error after one sample is the difference of two independent pictures, and
// falls as 1 / samples; so its time to any error is known without waiting for it. The field's error is measured against
// both pictures, whose own noise cancels: <(x - a)(x - b)> is that of x alone. That is so only where what it is divided
// by is independent of both, too: it is of a third picture.
#include <array>
#include <cmath>

#include "rendering.h"

namespace lucarium::bench {
namespace {

constexpr double kError = 1e-3;       // relMSE
constexpr uint32_t kMaxSamples = 64;  // of the field's pixels
constexpr uint32_t kWalk = 48;        // frames

using Picture = std::vector<float>;

/// Mean of (x - a)(y - b) / (r^2 + .01 mean(r)^2): metrics.h's relMSE where x = y and a = b = r.
double relative(const Picture& x, const Picture& y, const Picture& a, const Picture& b, const Picture& r) {
  double mean = 0, sum = 0;
  for (const float value : r) mean += static_cast<double>(value);
  mean /= static_cast<double>(r.size());
  for (size_t i = 0; i < r.size(); ++i) {
    const auto va = static_cast<double>(a[i]), vb = static_cast<double>(b[i]), vr = static_cast<double>(r[i]);
    sum += (static_cast<double>(x[i]) - va) * (static_cast<double>(y[i]) - vb) / (vr * vr + 0.01 * mean * mean);
  }
  return sum / static_cast<double>(r.size());
}

constexpr size_t kPictures = 3;

struct Traced {
  std::array<Picture, kPictures> pictures;
  double seconds_per_sample = 0, relmse_of_sample = 0;
  double seconds_to(double relmse) const { return relmse_of_sample / relmse * seconds_per_sample; }
};

/// Mean over which of three pictures divides, of value(a, b, r).
template <class Value>
double mean_over_roles(const std::array<Picture, kPictures>& of, Value&& value) {
  double sum = 0;
  for (size_t i = 0; i < kPictures; ++i)
    sum += value(of[i], of[(i + 1) % kPictures], of[(i + 2) % kPictures]) / kPictures;
  return sum;
}

Traced trace(const Scene& scene, const Sizes& sizes) {
  Traced result;
  for (size_t i = 0; i < kPictures; ++i) {
    const auto session = make_session("path_tracing", scene, sizes.width, {}, -1, 11 + i);
    session->run({.samples = sizes.reference});
    result.pictures[i] = session->resolve().image();
    result.seconds_per_sample += session->clocks().iterate / sizes.reference / kPictures;
  }
  result.relmse_of_sample =
      sizes.reference * mean_over_roles(result.pictures, [](const Picture& a, const Picture& b, const Picture& r) {
        return relative(a, b, b, a, r) / -2;
      });
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
    result.relmse = mean_over_roles(traced.pictures, [&x](const Picture& a, const Picture& b, const Picture& r) {
      return relative(x, x, a, b, r);
    });
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
