// SPDX-License-Identifier: Apache-2.0
// The time that bundle_exchange names, and how savings lower it.
#include "bundle_exchange/cost.h"

#include <doctest/doctest.h>

#include "lucarium/scene/load/load_scene.h"
#include "lucarium/technique/budget_plan.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

TEST_CASE("fewer texels and rays take less time, and a budget gets those that it can pay") {
  const Scene scene = load_scene("builtin:cornell");
  RenderSettings settings;
  const auto planned = [&](double seconds) {
    const auto technique = test::registry().find("bundle_exchange").create();
    const BudgetPlan plan = plan_budget(*technique, {}, scene, settings, {2, 2}, {seconds});
    return std::pair(plan, technique->parameters().get("texels"));
  };
  const auto [rich, automatic] = planned(1000);
  CHECK(rich.changes.empty());
  CHECK(automatic == "0");
  const auto [poor, texels] = planned(3);
  CHECK(poor.expected_seconds < rich.expected_seconds / 3);
  CHECK(std::stoi(texels) >= 4096);
  CHECK(std::stoi(texels) < 262144);
  Parameters parameters;
  const auto seconds = [&] {
    return estimate_seconds(make_plan(parameters, scene, settings), parameters, scene, settings, ComputePower());
  };
  const double whole = seconds();
  parameters.access_rays = 128;
  const double fewer_rays = seconds();
  CHECK(fewer_rays < whole);
  parameters.access_gap = 0;  // nothing to measure
  CHECK(seconds() < fewer_rays);
}

TEST_CASE("direct light and edges starved: pixels got one sample for each step of the exchange, whatever that cost") {
  WorkUnits units{.direction = 0.01, .light_run = 0.02, .eye_sample = 0.004};
  Parameters parameters;
  EyeShare eye;
  const auto samples = [&](uint64_t directions, uint32_t light_runs, bool lit = true) {
    return earned_eye_samples(parameters, eye, units, directions, light_runs, lit);
  };
  const double work = 12 * units.direction + 6 * units.light_run;
  const auto share_of = [&](double eye_samples) {
    const double eye = eye_samples * units.eye_sample;
    return eye / (work + eye);
  };
  for (const double share : {0.25, 0.5, 0.8}) {
    eye.share = share;
    CHECK(share_of(samples(12, 6)) == test::relative(share, 1e-6));
    CHECK(samples(12, 6, false) == 1);  // no more before there is indirect light
  }
  CHECK(samples(0, 0) == 0);
  CHECK(samples(1'000'000, 0) == 256);
  eye.share = 0;
  CHECK(samples(12, 6) == 1);
  eye.share = 0.5;
  parameters.pixel_rays = PixelRays::bundle;  // which have bundles of their own
  CHECK(samples(12, 6) == 1);
  // Dear samples: directions starved beside them, and light at texels came late.
  parameters = {};
  eye = {};
  units.eye_sample = 1.2;
  CHECK(share_of(samples(12, 6)) == test::relative(0.5, 1e-6));
  CHECK(share_of(samples(12, 6, false)) == test::relative(0.25, 1e-6));
  eye.measured = true;  // as variances say, however dear
  CHECK(share_of(samples(12, 6)) == test::relative(0.25, 1e-6));
  eye.due = true;  // except where a picture lags behind
  CHECK(samples(12, 6) == 1);
  eye = {0.8};
  CHECK(share_of(samples(12, 6)) == test::relative(0.8, 1e-6));
}
