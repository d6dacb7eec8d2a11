// SPDX-License-Identifier: Apache-2.0
// Checks of energy and of every kind of light. Declared in checks.h.
#include <cmath>
#include <numeric>

#include "lucarium/base/numbers.h"
#include "lucarium/conformance/check_scenes.h"
#include "lucarium/conformance/checks.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/statistics/student_t.h"

namespace lucarium::check {
namespace {

/// The middle of the picture alone, of half its width and height, pixels as large as they were: only a part of it is
/// looked at.
RenderSettings middle_of(RenderSettings settings) {
  settings.width /= 2;
  settings.height /= 2;
  settings.camera.yfov = 2 * std::atan(std::tan(settings.camera.yfov / 2) / 2);
  settings.camera.xmag /= 2;
  settings.camera.ymag /= 2;
  return settings;
}

/// Mean over the middle of the image, all channels.
double middle_mean(const std::vector<float>& image, uint32_t width, uint32_t height) {
  double sum = 0;
  size_t count = 0;
  for (uint32_t y = height / 4; y < 3 * height / 4; ++y) {
    for (uint32_t x = width / 4; x < 3 * width / 4; ++x) {
      for (uint32_t c = 0; c < 3; ++c, ++count) sum += image[3 * (size_t{y} * width + x) + c];
    }
  }
  return sum / static_cast<double>(count);
}

struct Estimate {
  double mean = 0, error = 0;  ///< standard error of the mean
  double doubt = 0;            ///< by how much noise may put a right mean off, at the checks' level
};

Estimate estimate(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double error = std::sqrt(squares / (n - 1) / n);
  return {mean, error, student_t_quantile(level, n - 1) * error};
}

/// Radiance in the middle of the image over independent seeds against `expected`: Student's t.
Outcome compare_middle(CheckContext& context, const Scene& scene, double expected) {
  RenderSession session = context.session(scene, middle_of(context.settings(scene)));
  std::vector<double> values;
  Estimate found;
  for (uint64_t seed = 1; seed <= seeds; ++seed) {
    session.restart(seed);
    context.run_long(session);
    const Film film = session.resolve();
    values.push_back(middle_mean(film.image(), film.width(), film.height()));
    if (values.size() < min_seeds) continue;
    found = estimate(values);
    if (std::abs(found.mean - expected) + found.doubt <= context.bias * expected) break;  // within it beyond doubt
  }
  const double allowed = found.doubt + (rounding + context.bias) * expected;
  const std::string measured = fmt::format("{:.5g} ± {:.2g}, expected {:.5g}", found.mean, found.error, expected);
  if (found.error > largest_noise * expected) return {Verdict::skipped, "too noisy to decide: " + measured};
  return verdict_of(std::abs(found.mean - expected) <= allowed, measured);
}

}  // namespace

Outcome check_light(CheckContext& context, LightKind light) {
  if (!context.path_set.direct) return {Verdict::not_claimed, "computes no direct light"};
  if (!context.claims(light)) return {Verdict::not_claimed, "does not claim this kind of light"};
  const LitFloor floor = make_lit_floor(light);
  return compare_middle(context, floor.scene, albedo * floor.irradiance / pi);
}

Outcome check_furnace(CheckContext& context) {
  if (!context.path_set.direct || !context.claims(LightKind::environment)) {
    return {Verdict::not_claimed, "does not claim direct light of the environment"};
  }
  return compare_middle(context, load_scene("builtin:furnace"), 0.8);
}

Outcome check_shining_box(CheckContext& context) {
  if (!context.path_set.light_transport() || !context.claims(LightKind::emissive)) {
    return {Verdict::not_claimed, "does not claim emissive surfaces"};
  }
  const Scene scene = make_shining_box();
  const RenderSettings settings = context.settings(scene);
  const std::unique_ptr<Technique> technique = context.type.create();
  technique->parameters().set_all(context.options.parameters);
  const PathSet set = technique->path_set(scene, settings);
  // The sum of albedo^n over the scatterings n that the layers of the path set hold.
  const int max_scatterings = set.max_bounces < 0 ? -1 : set.max_bounces + 1;
  const double all = 1 / (1 - static_cast<double>(albedo));
  const double later = all - 1 - albedo - (max_scatterings < 0 ? 0 : std::pow(albedo, max_scatterings + 1) * all);
  const double expected =
      (set.emission ? 1 : 0) + (set.direct ? albedo : 0) + (set.indirect && max_scatterings != 1 ? later : 0);
  return compare_middle(context, scene, expected);
}

}  // namespace lucarium::check
