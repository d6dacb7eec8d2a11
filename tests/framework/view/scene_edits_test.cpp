// SPDX-License-Identifier: Apache-2.0
// What a page changes of a scene, in the words of the command line.
#include "lucarium/view/edits/scene_edits.h"

#include <doctest/doctest.h>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/scene/load/scene_overrides.h"
#include "tolerance.h"

using namespace lucarium;
using nlohmann::json;

TEST_CASE("a light's text gives the same light") {
  for (const char* text : {"point:1,2.5,-3:4,5,6", "directional:0,-1,0:1,2,3", "spot:0,3,0:0,-1,0:10,20,30:40:20",
                           "spot:0.1,3,0.7:0.6,-0.8,0:1,1,1:45:0"}) {
    const SceneLight light = *parse_light(text), again = *parse_light(light_text(light));
    CHECK(again.type == light.type);
    CHECK(again.intensity == light.intensity);
    CHECK(again.outer_angle == test::relative(light.outer_angle, 1e-6));
    CHECK(again.inner_angle == test::within(light.inner_angle, 1e-6));
    const glm::mat4 &a = again.world_from_light, &b = light.world_from_light;
    CHECK(a[3] == b[3]);
    CHECK(glm::length(a[2] - b[2]) < 1e-6f);
  }
}

TEST_CASE("edits name no file, and malformed ones are refused") {
  const auto is_good = [](const SceneEdits& edits) {
    try {
      check_scene_edits(edits);
      return true;
    } catch (const Error& error) {
      CHECK(error.error_class() == ErrorClass::usage);
      return false;
    }
  };
  CHECK(is_good({}));
  CHECK(is_good({{{"point:0,1,0:1,1,1"}}, {"wall:roughness=0.5"}, "0.5,1,2", 1.0}));
  CHECK(is_good({{}, {}, "none", {}}));
  CHECK_FALSE(is_good({{}, {}, "sky.hdr", {}}));
  CHECK_FALSE(is_good({{{"bulb"}}, {}, "", {}}));
  CHECK_FALSE(is_good({{}, {"wall:roughness=7"}, "", {}}));
}

TEST_CASE("a sidecar of edits is read as the same edits") {
  const SceneEdits edits{{{"point:0,1,0:1,2,3"}}, {"wall:roughness=0.5,base_color=0.1,0.2,0.3"}, "0.5,0.5,0.5", 2.0};
  const json sidecar = json::parse(sidecar_text(edits, "0,1,5:0,1,0:40"));
  CHECK(sidecar["camera"] == "0,1,5:0,1,0:40");
  CHECK(sidecar["lights"] == json{"none", "point:0,1,0:1,2,3"});
  CHECK(sidecar["materials"]["wall"]["base_color"] == "0.1,0.2,0.3");
  CHECK(sidecar["environment"] == "0.5,0.5,0.5");
  CHECK(sidecar["at_seconds"] == 2.0);
}

TEST_CASE("the description of a scene has its lights, materials and animation") {
  const json cornell = json::parse(describe_scene(load_scene("builtin:cornell"), {}))["scene"];
  CHECK(cornell["environment"] == "none");
  CHECK(cornell["materials"].size() > 2);
  const json statue = json::parse(describe_scene(load_scene("builtin:statue"), {}))["scene"];
  CHECK(statue["lights"].size() == 1);
  CHECK(statue["duration"] > 0);
}
