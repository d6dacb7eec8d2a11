// SPDX-License-Identifier: Apache-2.0
// The scatter of samples that LayerSpread measures against that of the samples themselves, and the numbers of samples
// that follow from it.
#include "lucarium/services/layer_spread/layer_spread.h"

#include <limits>

#include "lucarium/scene/load/load_scene.h"
#include "lucarium/services/eye_light/eye_light.h"
#include "lucarium/services/path_integrator/path_integrator.h"
#include "test_render.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

constexpr uint32_t kSpreadSide = 37;  // no multiple of a run of pixels

/// Emission and direct light of the Cornell box, sample by sample.
struct EyeSamples {
  explicit EyeSamples(const Scene& scene)
      : context(scene, scene.cameras.front(), PathIntegratorOptions(), kSpreadSide),
        eye(*test_device(), context.scheduler, context.buffers, context.bvh, context.frame, "test"),
        indirect(*test_device(), "test", "indirect", kSpreadSide * kSpreadSide) {}

  void add(uint32_t sample) {
    REQUIRE(eye.see(sample));
    REQUIRE(eye.sample(sample));
    eye.commit();
  }
  /// What the layers show, per pixel.
  std::vector<glm::dvec3> shown() {
    context.scheduler.finish();
    const std::vector<float4> emission = eye.sums()["emission"].download(), direct = eye.sums()["direct"].download();
    std::vector<glm::dvec3> means;
    for (size_t i = 0; i < emission.size(); ++i)
      means.push_back(glm::dvec3(emission[i].xyz()) / std::max(1.0, double{emission[i].w}) +
                      glm::dvec3(direct[i].xyz()) / std::max(1.0, double{direct[i].w}));
    return means;
  }

  TestRender context;
  EyeLight eye;
  TypedBuffer<float4> indirect;
};

double luminance_of(const glm::dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

}  // namespace

TEST_CASE("the spread of samples is their variance over the square of what is shown, as in relMSE") {
  constexpr uint32_t samples = 12;
  const Scene scene = load_scene("builtin:cornell");
  EyeSamples rig(scene);
  const std::vector<float4> reflected(rig.indirect.count(), float4(0.2f, 0.4f, 0.6f, 2));  // of two samples
  const glm::dvec3 reflected_mean(0.1, 0.2, 0.3);
  rig.indirect.upload(reflected);

  std::vector<std::vector<glm::dvec3>> alone;
  for (uint32_t s = 0; s < samples; ++s) {
    rig.eye.clear();
    rig.add(s);
    alone.push_back(rig.shown());
  }

  rig.eye.clear();
  LayerSpread spread(*test_device(), rig.context.scheduler,
                     {rig.eye.sums()["emission"], rig.eye.sums()["direct"], rig.indirect}, rig.eye.deviations(),
                     "test");
  CHECK(spread.variance() == 0);
  double expected = 0, luminance = 0, share = 0;
  std::vector<glm::dvec3> before;
  for (uint32_t s = 0; s < samples; ++s) {
    rig.add(s);
    spread.measure();
    const std::vector<glm::dvec3> after = rig.shown();
    CHECK(spread.samples() == s);
    double sum = 0, bright = 0;
    share = 0;
    for (size_t i = 0; i < after.size(); ++i) {
      const glm::dvec3 shown = after[i] + reflected_mean;
      const double square = glm::dot(shown, shown) / 3 + 0.01 * luminance * luminance;
      if (s > 0) {
        const glm::dvec3 off = alone[s][i] - before[i];
        sum += glm::dot(off, off) / 3 * s / (s + 1) / square;
      }
      share += glm::dot(reflected_mean, reflected_mean) / 3 / square;
      bright += luminance_of(shown);
    }
    expected += sum / static_cast<double>(after.size());
    luminance = bright / static_cast<double>(after.size());
    before = after;
  }
  CHECK(spread.variance() == relative(expected / (samples - 1), 1e-4));
  CHECK(spread.indirect_share() == relative(share / static_cast<double>(before.size()), 1e-4));

  // The same from samples that know nothing of one another: their variance about their mean.
  double scatter = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    double squares = 0;
    for (uint32_t s = 0; s < samples; ++s) {
      const glm::dvec3 off = alone[s][i] - before[i];
      squares += glm::dot(off, off) / 3 / (samples - 1);
    }
    const glm::dvec3 shown = before[i] + reflected_mean;
    scatter += squares / (glm::dot(shown, shown) / 3 + 0.01 * luminance * luminance);
  }
  MESSAGE("spread ", spread.variance(), ", variance of samples ", scatter / static_cast<double>(before.size()));
  CHECK(spread.variance() == relative(scatter / static_cast<double>(before.size()), 0.2));

  // Pixels that are not finite are left out.
  std::vector<float4> broken(reflected.size(), float4(0.4f, 0.8f, 1.2f, 2));  // twice as much
  broken[5].x = std::numeric_limits<float>::infinity();
  broken[700].y = std::numeric_limits<float>::quiet_NaN();
  rig.indirect.upload(broken);
  spread.measure();
  CHECK(spread.samples() == samples);
  CHECK(spread.variance() > 0);
  CHECK(spread.indirect_share() > 1.02 * share / static_cast<double>(before.size()));
  // Where all are, the sample has come all the same: who waits for one waits no longer.
  const double variance = spread.variance();
  rig.indirect.upload(std::vector<float4>(reflected.size(), float4(1e38f, 1e38f, 1e38f, 1)));
  spread.measure();
  CHECK(spread.samples() == samples + 1);
  CHECK(spread.variance() == variance);

  spread.clear();
  CHECK(spread.samples() == 0);
  CHECK(spread.variance() == 0);
}

TEST_CASE("numbers of samples that follow from variances have the least error for all work") {
  const auto error = [](double each, double v, double c, double w, double d) {
    const double dear = 1 / (d + each * c);  // samples for one unit of work
    return v / (each * dear) + w / dear;
  };
  for (const double v : {0.01, 1.0, 30.0})
    for (const double c : {0.02, 0.5})
      for (const double d : {0.3, 4.0}) {
        const double best = samples_for_each(v, c, 0.2, d, 1e9);
        for (const double other : {0.5, 0.9, 1.1, 2.0})
          CHECK(error(best, v, c, 0.2, d) < error(other * best, v, c, 0.2, d));
      }
  // As a share of all work: half each where parts scatter and cost alike, twice the other where it scatters fourfold.
  CHECK(share_of_work(0.3, 2, 0.3, 2) == relative(0.5, 1e-9));
  CHECK(share_of_work(4, 2, 1, 2) == relative(2.0 / 3, 1e-9));
  CHECK(share_of_work(1, 8, 1, 2) == relative(2.0 / 3, 1e-9));
  CHECK(share_of_work(0, 1, 1, 1) == 0);
  CHECK(share_of_work(1, 1, 0, 1) == 1);
  CHECK(share_of_work(0, 1, 0, 1) == 0);
  CHECK(share_of_work(1, 1, std::numeric_limits<double>::quiet_NaN(), 1) == 0);
  CHECK(samples_for_each(0, 1, 1, 1, 64) == 0);
  CHECK(samples_for_each(1, 1, 0, 1, 64) == 64);
  CHECK(samples_for_each(1, 1e-9, 1, 1, 64) == 64);
}
