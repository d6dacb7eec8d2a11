// SPDX-License-Identifier: Apache-2.0
// What ways of connecting, longer light paths and weights are worth, without what `adapt` would choose.
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/statistics/statistics.h"
#include "subject.h"

namespace lucarium::bench {

void measure_ways(Bars& bars, const Effort& effort) {
  const Subject room(load_scene("builtin:room"), 4, effort, {{"adapt", "off"}}, "indirect");
  add_ratio(bars, "room, error times time: vpl_choice=all over resample", 1.3, 2,
            room.measure({{"vpl_choice", "all"}, {"adapt", "off"}}).costs, room.measure({{"adapt", "off"}}).costs);
  const Subject fixture(load_scene("builtin:fixture"), 4, effort, {{"adapt", "off"}}, "indirect");
  add_ratio(bars, "fixture, error times time: light_vertices=1 over 4", 10, 25,
            fixture.measure({{"light_vertices", "1"}, {"adapt", "off"}}).costs,
            fixture.measure({{"adapt", "off"}}).costs);

  // Light of two scatterings in a corner, by directions of bundles and by one connection.
  Scene corner = load_scene("builtin:room");
  const glm::vec3 low = corner.bounds().min;
  SceneCamera& camera = corner.cameras.front();
  camera.world_from_camera = glm::inverse(glm::lookAt(low + glm::vec3(0.2f), low, {0, 1, 0}));
  const auto with = [](const char* strategy) {
    return Parameters{{"strategy", strategy}, {"light_vertices", "1"}, {"splat", "on"}, {"directions", "bundle"},
                      {"candidates", "1"},    {"bundles", "4096"},     {"adapt", "off"}};
  };
  const Subject seen(corner, 1, effort, {{"light_vertices", "1"}, {"adapt", "off"}}, "indirect");
  const Measured both = seen.measure(with("all")), vpl = seen.measure(with("vpl")), nee = seen.measure(with("nee"));
  const auto error = [](const Measured& m) { return seed_mean(m.errors).mean; };
  bars.note("corner, relMSE by virtual lights", error(vpl), "");
  bars.note("corner, relMSE by bundles", error(nee), "");
  bars.note("corner, relMSE by both", error(both), "");
  add_ratio(bars, "corner, error: the better strategy alone over both", 3, 6,
            (error(vpl) < error(nee) ? vpl : nee).errors, both.errors);
}

}  // namespace lucarium::bench
