// SPDX-License-Identifier: Apache-2.0
// Light of one number of scatterings at a time beside path_tracing's of the same paths, and the field's totals beside
// those of bundle_exchange, which propagates the same light by other directions. Classes are the direct layer, and
// differences of indirect layers of which one allows a bounce more: both techniques repeat their random numbers, so
// that light of fewer bounces cancels. Bounces at mirrors count on the light's side; those before the eye are free.
#include <doctest/doctest.h>

#include <utility>

#include "field_rig.h"
#include "lucarium/technique/state_file.h"
#include "technique_rig.h"
#include "tolerance.h"

using namespace lucarium;
using test::Options;
using test::relative;

namespace {

/// Mean over image and colours of light with 1, 2, ... scatterings.
std::vector<double> classes(const std::string& technique, const std::string& scene, uint64_t samples, int most,
                            const Options& options) {
  std::vector<double> result;
  double before = 0;
  for (int bounces = 0; bounces <= most; ++bounces) {
    const auto run = test::session(load_scene(scene), bounces, options, technique);
    run->finish_light();
    run->run({.samples = samples});
    const double direct = test::mean(run->resolve().find("direct")->pixels),
                 indirect = test::mean(test::indirect(*run));
    if (bounces == 0) CHECK(indirect == 0.0);
    result.push_back(bounces == 0 ? direct : indirect - before);
    before = indirect;
  }
  return result;
}

void compare(const std::string& scene, int most, const Options& options) {
  const bool full = test::full_run();
  const std::vector<double> expected =
      classes("path_tracing", scene, full ? 16384 : 2048, most, {{"samples_per_iteration", "64"}});
  const std::vector<double> found = classes("virtual_light_field", scene, full ? 512 : 128, most, options);
  for (size_t bounces = 0; bounces < found.size(); ++bounces) {
    CAPTURE(scene);
    CAPTURE(bounces);
    MESSAGE(scene, ", ", bounces, " bounces: ", found[bounces] / expected[bounces] - 1);
    CHECK(found[bounces] == relative(expected[bounces], 0.02));
  }
}

Options field(int dir_n, int cells, int texels) {
  return {{"dir_n", std::to_string(dir_n)},
          {"cells", std::to_string(cells)},
          {"texels", std::to_string(texels)},
          {"camera_samples", "100000"}};
}

}  // namespace

TEST_CASE("each number of bounces alone brings path_tracing's light: diffuse walls") {
  compare("builtin:cornell", 3, field(8, 48, test::full_run() ? 16384 : 8192));
}

TEST_CASE("each number of bounces alone brings path_tracing's light: a mirror") {
  if (test::full_run())
    compare("builtin:cornell-mirror", 3, field(16, 128, 32768));
  else
    compare("builtin:cornell-mirror", 1, field(16, 96, 16384));
}

TEST_CASE("each number of bounces alone brings path_tracing's light: spheres of glass, metal and weak coats") {
  compare("builtin:spheres", test::full_run() ? 3 : 1, field(8, 48, 8192));
}

TEST_CASE("a scene of much more detail than texels is as bright as it should be") {
  if (!test::full_run()) return;  // a minute of preparation
  const auto light = [](const std::string& technique, uint64_t samples, const Options& options) {
    const auto run = test::session(load_scene("builtin:atrium"), -1, options, technique);
    run->finish_light();
    run->run({.samples = samples});
    return std::pair(test::mean(run->resolve().find("direct")->pixels), test::mean(test::indirect(*run)));
  };
  const auto [direct, expected] = light("path_tracing", 16384, {{"samples_per_iteration", "64"}});
  const auto [found_direct, found] = light("virtual_light_field", 256, {{"camera_samples", "100000"}});
  MESSAGE("indirect light: ", found / expected - 1);
  CHECK(found_direct == relative(direct, 0.01));
  CHECK(direct + found == relative(direct + expected, 0.03));
}

TEST_CASE("the field's totals are those of bundle_exchange, wall by wall") {
  // Both hold irradiance over pi of the same texel sides of the same atlas, w the accessibility that it is multiplied
  // by.
  const Scene scene = load_scene("builtin:cornell");
  vlf::Parameters parameters;
  parameters.dir_n = test::full_run() ? 16 : 8;
  parameters.cells = 64;
  parameters.texels = 8192;
  test::FieldRig rig(scene, parameters, {.light_samples = 1024});
  rig.propagate();
  const test::TemporaryFolder folder;
  const auto bundles = test::session(scene, -1,
                                     {{"texels", "8192"},
                                      {"directions", test::full_run() ? "8192" : "1024"},
                                      {"stop_error", "0"},
                                      {"camera_samples", "1"}},
                                     "bundle_exchange");
  bundles->finish_light();
  bundles->save_state(folder.path() / "a.state", false);
  std::vector<double> expected;
  for (const float4& v : StateFile(folder.path() / "a.state").get<float4>("shown"))
    expected.push_back(v.w > 0 ? static_cast<double>(v.x / v.w) : 0.);
  REQUIRE(expected.size() == rig.sides());
  const std::vector<double> found = rig.indirect();
  for (int instance = 0; instance < static_cast<int>(scene.instances.size()); ++instance) {
    CAPTURE(instance);
    MESSAGE("instance ", instance, ": ", rig.mean(found, instance), ", by bundles ", rig.mean(expected, instance));
    CHECK(rig.mean(found, instance) == relative(rig.mean(expected, instance), 0.01));
  }
}
