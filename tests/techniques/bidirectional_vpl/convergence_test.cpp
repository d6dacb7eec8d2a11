// SPDX-License-Identifier: Apache-2.0
// Errors fall as one over the samples for as long as one looks, and nothing is left over.
#include <cmath>
#include <memory>

#include "bidirectional_rig.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint64_t kReferences = 8;

struct Course {
  const char* scene;
  Parameters parameters;
  uint32_t seeds;
  uint64_t first, last;  ///< samples at which errors are measured: first, 2 first, …, last
  uint64_t reference;    ///< samples of each of eight path-traced pictures
  double error;          ///< relMSE that is reached
};

std::unique_ptr<RenderSession> begin(const char* technique, const Scene& scene, const Parameters& parameters,
                                     uint64_t seed) {
  RenderSettings settings;
  settings.width = 24;
  settings.height = 20;
  settings.max_bounces = 4;
  settings.seed = seed;
  settings.camera = scene.cameras.front();
  return std::make_unique<RenderSession>(test_device(), scene, registry().find(technique), settings, parameters);
}

/// Mean of (x - a)(x - b) / (r^2 + .01 mean(r)^2), r = (a + b) / 2: relMSE of x alone, since a and b are independent.
double error_of(const std::vector<float>& x, const std::vector<float>& a, const std::vector<float>& b) {
  const double mean = 0.5 * (mean_of(a) + mean_of(b));
  double sum = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    const auto va = static_cast<double>(a[i]), vb = static_cast<double>(b[i]), v = static_cast<double>(x[i]);
    const double r = 0.5 * (va + vb);
    sum += (v - va) * (v - vb) / (r * r + 0.01 * mean * mean);
  }
  return sum / static_cast<double>(x.size());
}

/// Least squares on logarithms.
double slope_of(const std::vector<double>& samples, const std::vector<double>& errors) {
  double mx = 0, my = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) mx += std::log(samples[i]) / n, my += std::log(errors[i]) / n;
  for (size_t i = 0; i < samples.size(); ++i) {
    const double x = std::log(samples[i]) - mx;
    xx += x * x;
    xy += x * (std::log(errors[i]) - my);
  }
  return xy / xx;
}

void check_course(const Course& course) {
  INFO(std::string(course.scene));
  const Scene scene = load_scene(course.scene);
  // Two independent halves of what is right.
  std::vector<std::vector<float>> truth(2);
  std::vector<double> true_means;
  for (uint64_t seed = 0; seed < kReferences; ++seed) {
    const auto session = begin("path_tracing", scene, {}, 901 + seed);
    session->run({.samples = course.reference});
    const std::vector<float> image = image_of(session->resolve());
    std::vector<float>& half = truth[seed % 2];
    half.resize(image.size());
    for (size_t i = 0; i < image.size(); ++i) half[i] += image[i] * 2 / kReferences;
    true_means.push_back(mean_of(image));
  }
  std::vector<double> samples, errors, means;
  for (uint64_t n = course.first; n <= course.last; n *= 2) samples.push_back(static_cast<double>(n));
  errors.resize(samples.size());
  for (uint32_t seed = 1; seed <= course.seeds; ++seed) {
    const auto session = begin("bidirectional_vpl", scene, course.parameters, seed);
    std::vector<float> image;
    for (size_t i = 0; i < samples.size(); ++i) {
      session->run({.samples = static_cast<uint64_t>(samples[i])});
      image = image_of(session->resolve());
      errors[i] += error_of(image, truth[0], truth[1]) / course.seeds;
    }
    means.push_back(mean_of(image));
  }
  const double slope = slope_of(samples, errors);
  const Estimate ours = estimate_of(means), theirs = estimate_of(true_means);
  const double t = (ours.mean - theirs.mean) / std::hypot(ours.error, theirs.error);
  MESSAGE(std::string(course.scene) << ": relMSE " << errors.front() << " after " << samples.front() << " samples, "
                                    << errors.back() << " after " << samples.back() << ", slope " << slope << ", t "
                                    << t);
  CHECK(std::abs(slope + 1) < 0.1);
  CHECK(errors.back() < course.error);
  CHECK(std::abs(t) < 3.5);
}

}  // namespace

TEST_CASE("errors fall as one over the samples, and no bias is left") {
  // The first samples of a pixel are spread evenly (Sobol points): until about 64 errors fall faster, path_tracing's
  // alike. `adapt` would change the noise of a sample on the way.
  if (!full_run()) return check_course({"builtin:cornell", {{"adapt", "off"}}, 8, 64, 1024, 512, 1e-3});
  // From where `adapt` has decided.
  check_course({"builtin:cornell", {}, 10, 512, 32768, 16384, 1e-5});
  check_course({"builtin:room", {}, 10, 512, 16384, 16384, 1e-5});
  check_course({"builtin:cornell", {{"preset", "bdpt"}}, 10, 64, 4096, 4096, 1e-4});
}
