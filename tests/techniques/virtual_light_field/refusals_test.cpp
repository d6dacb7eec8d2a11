// SPDX-License-Identifier: Apache-2.0
// Parameters that contradict each other are refused before anything is prepared, with what to do.
#include <doctest/doctest.h>

#include "lucarium/scene/load/load_scene.h"
#include "saved_state.h"
#include "technique_rig.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("parameters that contradict each other, or the scene, are refused with what to do") {
  const auto refuse = [](const Options& options, const std::string& why, int max_bounces = -1) {
    check_refusal([&] { session(load_scene("builtin:cornell-mirror"), max_bounces, options); }, ErrorClass::usage, why);
  };
  refuse({{"cells", "2048"}, {"supersample", "8"}}, "makes subfields of 16384 pixels, more than 4096; lower one");
  refuse({{"cells", "7"}}, "cells=7: give at least 16, or 0");
  refuse({{"eye_direct", "atlas"}, {"split_layers", "off"}}, "eye_direct=atlas needs the direct light of tiles; set");
  refuse({{"eye_glossy", "vlf"}, {"split_layers", "off"}}, "eye_glossy=vlf needs the direct light of tiles apart; set");
  refuse({{"dir_n", "3"}, {"inspect_line", "19"}}, "inspect_line=19 with dir_n=3: lines are 0 to 18");
  refuse({{"dir_n", "65"}}, "parameter dir_n: 65 is outside 2");
  refuse({{"eye_specular", "vlf"}}, "leave --max-bounces unlimited, or set eye_specular=trace", 3);
  // Where no surface is ideal, nothing is said.
  const Options looked_up = {{"dir_n", "2"}, {"cells", "16"}, {"texels", "512"}, {"eye_specular", "vlf"}};
  CHECK_NOTHROW(session(load_scene("builtin:cornell"), 3, looked_up));
  // A texture may make a mirror of rough metal.
  for (const uint8_t roughness : {uint8_t{0}, uint8_t{9}}) {
    CAPTURE(roughness);
    Scene textured = load_scene("builtin:cornell-mirror");
    textured.images.push_back({"roughness", 2, 1, {0, 200, 255, 255, 0, roughness, 255, 255}});
    textured.textures.push_back({.image = static_cast<int>(textured.images.size()) - 1});
    for (SceneMaterial& material : textured.materials) {
      if (material.metallic == 0) continue;
      material.roughness = 1;
      material.metallic_roughness_texture.texture = static_cast<int>(textured.textures.size()) - 1;
    }
    if (roughness == 0)
      check_refusal([&] { session(textured, 3, looked_up); }, ErrorClass::usage, "a mirror before the eye counts");
    else
      CHECK_NOTHROW(session(textured, 3, looked_up));
  }
}
