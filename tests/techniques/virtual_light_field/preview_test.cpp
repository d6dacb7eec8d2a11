// SPDX-License-Identifier: Apache-2.0
// The coarse field that is displayed until a better one is known.
#include <doctest/doctest.h>

#include "lamp_box.h"
#include "lucarium/scene/load/load_scene.h"
#include "virtual_light_field/cost.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

vlf::Parameters few_directions() {
  vlf::Parameters p;
  p.dir_n = 8;
  p.cells = 32;
  p.texels = 1536;
  return p;
}

FieldRig::Options with_preview() {
  FieldRig::Options options;
  options.preview = true;
  return options;
}

}  // namespace

TEST_CASE("before the first sweep a preview shows nearly the light of the end, and changes no bit of it") {
  const Scene scene = LampBox().scene();
  FieldRig plain(scene, few_directions()), early(scene, few_directions(), with_preview());
  plain.propagate();
  while (early.field().shown_sweeps() == 0) early.field().advance(1);
  CHECK(early.field().sweeps() == 0);
  early.scheduler().finish();
  const std::vector<double> shown = early.indirect();
  early.propagate();
  CHECK(early.field().sweeps() == plain.field().sweeps());
  CHECK(early.field().counts().subfields == plain.field().counts().subfields);
  CHECK(early.indirect() == plain.indirect());
  CHECK(early.direct() == plain.direct());
  CHECK(early.cells() == plain.cells());
  // Nine lines, and a mirror that scatters its light over all walls.
  for (const int wall : {0, LampBox::kFloor, 3, 4, LampBox::kCeiling}) {
    const double end = plain.mean(plain.indirect(), wall), first = early.mean(shown, wall);
    CAPTURE(wall);
    CHECK(first > 0.6 * end);
    CHECK(first < 1.4 * end);
  }
}

TEST_CASE("with few bounces, and with perturbed directions, a preview changes no bit, and progress never falls") {
  const Scene scene = LampBox().scene();
  for (const auto& [bounces, perturb] : {std::pair(1, 1), std::pair(2, 4), std::pair(4, 1)}) {
    CAPTURE(bounces);
    vlf::Parameters p = few_directions();
    p.texels = 512;
    p.perturb = perturb;
    FieldRig::Options options = with_preview();
    options.max_bounces = bounces;
    FieldRig early(scene, p, options);
    options.preview = false;
    FieldRig plain(scene, p, options);
    plain.propagate();
    double before = 0;
    while (!early.field().done()) {
      early.field().advance(1);
      CHECK(early.field().progress() >= before);
      before = early.field().progress();
    }
    early.scheduler().finish();
    CHECK(early.indirect() == plain.indirect());
    CHECK(early.cells() == plain.cells());
  }
}

TEST_CASE("what a short budget lowers takes less time, and so do fragments that are kept") {
  const Scene scene = LampBox().scene();
  RenderSettings settings;
  settings.width = 256;
  settings.height = 144;
  vlf::Parameters p;
  const auto seconds = [&] {
    return vlf::estimate_seconds(vlf::make_plan(p, scene, settings), p, scene, settings, ComputePower());
  };
  const double whole = seconds();
  for (const ParameterSaving& saving : vlf::savings()) {
    const vlf::Parameters before = p;
    ParameterTable table = make_parameter_table(p);
    double last = seconds();
    for (const std::string& value : saving.values) {
      table.set(saving.parameter, value);
      CAPTURE(value);
      CHECK(seconds() < last);
      last = seconds();
    }
    p = before;
  }
  p.dir_n = 6;
  p.texels = 8192;
  const double kept = seconds();
  CHECK(kept < 0.2 * whole);
  p.preview = false;
  CHECK(seconds() < kept);
  p.cache_visibility = 0;  // every sweep draws its subfields
  CHECK(seconds() > 1.5 * kept);
}

TEST_CASE("scenes of many triangles are expected to take longer, by subfields and by rays") {
  RenderSettings settings;
  settings.width = 256;
  settings.height = 144;
  const auto seconds = [&](const std::string& name, int perturb, bool rays) {
    const Scene scene = load_scene(name);
    vlf::Parameters p;
    p.cells = 64;
    p.supersample = vlf::Supersample::one;  // subfields of few pixels: what remains is triangles
    p.perturb = perturb;
    p.direct_mode = rays ? vlf::DirectMode::nee : vlf::DirectMode::exchange;
    return vlf::estimate_seconds(vlf::make_plan(p, scene, settings), p, scene, settings, ComputePower());
  };
  const std::string few = "builtin:blocks:triangles=100", many = "builtin:blocks:triangles=100000";
  const auto of_subfields = [&](const std::string& name) { return seconds(name, 2, true) - seconds(name, 1, true); };
  const auto of_rays = [&](const std::string& name) { return seconds(name, 1, true) - seconds(name, 1, false); };
  CHECK(of_subfields(many) > 5 * of_subfields(few));
  CHECK(of_rays(many) > 2 * of_rays(few));
}
