// SPDX-License-Identifier: Apache-2.0
// Vertices of light paths at plain surfaces, of eight paths at once, are to the last bit those of one path at a time,
// as surfaces with a texture have them.
#include "bidirectional_rig.h"
#include "made_scene.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

/// A room with bodies, a part of whose walls can be seen from one side only, with lights of every kind. `textured`: of
/// its materials, bit by bit, those with a white texture, which changes nothing else.
Scene mixed_room(uint32_t textured) {
  Scene scene;
  scene.images.push_back({"white", 1, 1, {255, 255, 255, 255}});
  scene.textures.push_back({0, Wrap::clamp, Wrap::clamp, true, false});
  const auto material = [&](SceneMaterial m, uint32_t bit) {
    if (textured >> bit & 1u) m.metallic_roughness_texture.texture = 0;
    return add_material(scene, m);
  };
  SceneMaterial both_sides = lambert(0.4f);
  both_sides.double_sided = true;
  both_sides.roughness = 0.7f;
  add_box(scene, glm::vec3(-1), {1, 1, 1.5f}, true, material(lambert(0.7f), 0));
  add_triangles(scene, sphere_triangles({0.3f, -0.4f, 0.2f}, 0.4f, 2, false), material(both_sides, 1));
  add_triangles(scene, {{-0.8f, -0.9f, 0}, {-0.2f, -0.9f, 0.1f}, {-0.5f, 0.5f, 0}}, material(lambert(0.9f), 2));
  add_horizontal(scene, 0, 0.95f, 0, 0.5f, 0.5f, false, add_material(scene, emitter(4)));
  add_light(scene, LightType::point, 1, {-0.6f, 0.5f, 0.6f}, {0, -1, 0});
  add_light(scene, LightType::spot, 3, {0.6f, 0.7f, 0.6f}, {0, -1, 0});
  scene.lights.back().inner_angle = 0.3f;
  scene.lights.back().outer_angle = 0.6f;
  scene.cameras = {look_perspective({-0.6f, 0.3f, 1.4f}, {0.2f, -0.3f, 0}, 1.2f)};
  return scene;
}

}  // namespace

TEST_CASE("light paths: eight at once at plain surfaces have the bits of one at a time") {
  Picture picture;
  picture.max_bounces = 6;
  picture.iterations = 4;
  // Not a multiple of eight: the last paths have no seven beside them. Of many paths each meets other surfaces.
  for (const char* const beta : {"1", "2"}) {
    const Parameters parameters = {{"light_paths", "3003"}, {"light_vertices", "6"}, {"beta", beta}, {"adapt", "off"}};
    const std::vector<float> plain = image_of(render(mixed_room(0), "bidirectional_vpl", picture, parameters));
    CHECK(mean_of(plain) > 0.01);
    for (const uint32_t textured : {7u, 2u, 5u}) {
      CAPTURE(beta);
      CAPTURE(textured);
      CHECK(image_of(render(mixed_room(textured), "bidirectional_vpl", picture, parameters)) == plain);
    }
  }
  // Of so many paths vertices are stored past the caches.
  picture.iterations = 1;
  const Parameters many = {{"light_paths", "24003"}, {"light_vertices", "6"}, {"adapt", "off"}};
  CHECK(image_of(render(mixed_room(7), "bidirectional_vpl", picture, many)) ==
        image_of(render(mixed_room(0), "bidirectional_vpl", picture, many)));
}
