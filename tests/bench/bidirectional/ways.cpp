// SPDX-License-Identifier: Apache-2.0
// What ways of connecting, longer light paths and weights are worth, without what `adapt` would choose.
#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/statistics/statistics.h"
#include "subject.h"

namespace lucarium::bench {

namespace {

// Pictures by `all` take a ray for each of its 84 virtual lights.
constexpr uint64_t kLessByAll = 8;

void measure_choice(Bars& bars, const Effort& effort) {
  const Subject room("room", load_scene("builtin:room"), 4, effort, {{"adapt", "off"}}, "indirect");
  const std::vector<Measured> of =
      room.measure({{{{"vpl_choice", "all"}, {"adapt", "off"}}, std::max<uint64_t>(effort.samples / kLessByAll, 1)},
                    {{{"adapt", "off"}}, effort.samples}});
  add_ratio(bars, "room, error times time: vpl_choice=all over resample", 1.3, 2, of[0].costs, of[1].costs);
}

void measure_light_vertices(Bars& bars, const Effort& effort) {
  const Subject fixture("fixture", load_scene("builtin:fixture"), 4, effort, {{"adapt", "off"}}, "indirect");
  const std::vector<Measured> of = fixture.measure(
      {{{{"light_vertices", "1"}, {"adapt", "off"}}, effort.samples}, {{{"adapt", "off"}}, effort.samples}});
  add_ratio(bars, "fixture, error times time: light_vertices=1 over 4", 10, 25, of[0].costs, of[1].costs);
}

// Light of two scatterings in a corner, by directions of bundles and by one connection.
void measure_weights(Bars& bars, const Effort& effort) {
  Scene corner = load_scene("builtin:room");
  const glm::vec3 low = corner.bounds().min;
  SceneCamera& camera = corner.cameras.front();
  camera.world_from_camera = glm::inverse(glm::lookAt(low + glm::vec3(0.2f), low, {0, 1, 0}));
  const auto with = [](const char* strategy) {
    return Parameters{{"strategy", strategy}, {"light_vertices", "1"}, {"splat", "on"}, {"directions", "bundle"},
                      {"candidates", "1"},    {"bundles", "4096"},     {"adapt", "off"}};
  };
  const Subject seen("corner", corner, 1, effort, {{"light_vertices", "1"}, {"adapt", "off"}}, "indirect");
  const std::vector<Measured> of =
      seen.measure({{with("all"), effort.samples}, {with("vpl"), effort.samples}, {with("nee"), effort.samples}});
  const Measured &both = of[0], &vpl = of[1], &nee = of[2];
  const auto error = [](const Measured& m) { return seed_mean(m.errors).mean; };
  bars.note("corner, relMSE by virtual lights", error(vpl), "");
  bars.note("corner, relMSE by bundles", error(nee), "");
  bars.note("corner, relMSE by both", error(both), "");
  add_ratio(bars, "corner, error: the better strategy alone over both", 3, 6,
            (error(vpl) < error(nee) ? vpl : nee).errors, both.errors);
}

}  // namespace

void measure_ways(Bars& bars, const Effort& effort) {
  measure_choice(bars, effort);
  measure_light_vertices(bars, effort);
  measure_weights(bars, effort);
}

}  // namespace lucarium::bench
