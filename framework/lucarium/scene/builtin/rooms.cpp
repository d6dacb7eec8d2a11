// SPDX-License-Identifier: Apache-2.0
// Built-in scenes of one closed room, lit in ways that are easy or hard for path tracing. Declared in builder.h.
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/scene/builtin/builder.h"

namespace lucarium {

namespace {

constexpr float kLampRadius = 0.02f;

/// The room of 2 x 2 x 2 m, its camera, without light and furniture.
Scene empty_room() {
  Scene scene;
  const int horizontal = add_lambert(scene, "floor and ceiling", glm::vec3(0.7f));
  const int left = add_lambert(scene, "wall -x", glm::vec3(0.6f)),
            right = add_lambert(scene, "wall +x", glm::vec3(0.3f));
  const int ends = add_lambert(scene, "walls z", glm::vec3(0.5f));
  const glm::vec3 low(-1, 0, -1), high(1, 2, 1);
  const int materials[3][2] = {{left, right}, {horizontal, horizontal}, {ends, ends}};
  const char* names[3][2] = {{"wall -x", "wall +x"}, {"floor", "ceiling"}, {"wall -z", "wall +z"}};
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      Mesh face = MeshBuilder(names[axis][side]).box_face(low, high, axis, side, true).take();
      add_instance(scene, add_mesh(scene, std::move(face)), materials[axis][side]);
    }
  }
  scene.cameras.push_back(look_at_camera("inside", {0.75f, 1.5f, 0.95f}, {-0.15f, 0.6f, -0.4f}, 75.f));
  return scene;
}

void add_block(Scene& scene, const std::string& name, const glm::vec3& low, const glm::vec3& high, int material) {
  add_instance(scene, add_mesh(scene, MeshBuilder(name).box(low, high).take()), material);
}

void add_point_light(Scene& scene, const glm::vec3& position) {
  SceneLight light;
  light.name = "point";
  light.world_from_light = frame_along(position, {0, -1, 0});
  scene.lights.push_back(light);
}

/// A ball of 4 cm that shines like a point light of `intensity` cd.
void add_lamp(Scene& scene, const glm::vec3& position, float intensity) {
  const float radiance = intensity / (glm::pi<float>() * kLampRadius * kLampRadius);
  const int material = add_emitter(scene, "lamp", glm::vec3(radiance));
  MeshBuilder builder("lamp");
  for (const auto& [a, b, c] : icosphere(2)) builder.triangle(kLampRadius * a, kLampRadius * b, kLampRadius * c);
  add_instance(scene, add_mesh(scene, builder.take()), material, glm::translate(glm::mat4(1.f), position));
}

/// A spot of 10 degrees that shines upwards.
void add_ceiling_spot(Scene& scene, const glm::vec3& position) {
  SceneLight light;
  light.name = "spot";
  light.type = LightType::spot;
  light.intensity = glm::vec3(60);
  light.inner_angle = 0.5f * glm::radians(10.f);
  light.outer_angle = glm::radians(10.f);
  light.world_from_light = frame_along(position, {0, 1, 0});
  scene.lights.push_back(light);
}

}  // namespace

Scene make_room(int lamp) {
  Scene scene = empty_room();
  add_block(scene, "box", {0.1f, 0, -0.6f}, {0.6f, 0.8f, -0.1f}, add_lambert(scene, "box", glm::vec3(0.8f)));
  const glm::vec3 place(-0.6f, 1.3f, -0.7f);
  switch (lamp) {
    case 1: add_lamp(scene, place, 1); break;
    case 2: add_point_light(scene, {-0.98f, place.y, place.z}); break;
    case 3: add_ceiling_spot(scene, place); break;
    default: add_point_light(scene, place);
  }
  return scene;
}

Scene make_fixture(int lamp) {
  Scene scene = empty_room();
  add_block(scene, "box", {0.1f, 0, -0.6f}, {0.6f, 0.8f, -0.1f}, add_lambert(scene, "box", glm::vec3(0.8f)));
  // 16 x 16 x 15 cm, open at the top, walls of 1 cm: no light leaves it but upwards.
  const int white = add_lambert(scene, "fixture", glm::vec3(0.7f));
  const glm::vec3 centre(-0.6f, 1.3f, -0.7f);
  const float half = 0.08f, wall = 0.01f, bottom = -0.05f, top = bottom + 0.15f;
  const auto part = [&](const char* name, const glm::vec3& low, const glm::vec3& high) {
    add_block(scene, name, centre + low, centre + high, white);
  };
  part("bottom", {-half, bottom - wall, -half}, {half, bottom, half});
  part("side -x", {-half - wall, bottom - wall, -half}, {-half, top, half});
  part("side +x", {half, bottom - wall, -half}, {half + wall, top, half});
  part("side -z", {-half - wall, bottom - wall, -half - wall}, {half + wall, top, -half});
  part("side +z", {-half - wall, bottom - wall, half}, {half + wall, top, half + wall});
  if (lamp == 1)
    add_lamp(scene, centre, 4);
  else {
    add_point_light(scene, centre);
    scene.lights.back().intensity = glm::vec3(4);
  }
  return scene;
}

Scene make_caustic() {
  Scene scene = empty_room();
  add_block(scene, "mirror", {-0.75f, 0, -0.35f}, {-0.55f, 0.5f, 0.35f},
            add_metal(scene, "mirror", glm::vec3(0.8f), 0));
  SceneMaterial glass;
  glass.name = "glass";
  glass.base_color = glm::vec4(0.98f, 0.98f, 0.98f, 1);
  glass.metallic = 0;
  glass.roughness = 0;
  glass.transmission = 1;
  glass.ior = 1.5f;
  glass.thickness = 1;
  scene.materials.push_back(glass);
  const int material = static_cast<int>(scene.materials.size()) - 1;
  add_block(scene, "glass block", {0.1f, 0.02f, -0.35f}, {0.4f, 0.32f, -0.05f}, material);
  MeshBuilder ball("glass ball");
  for (const std::array<glm::vec3, 3>& corners : icosphere(4)) {
    uint32_t index[3];
    for (int k = 0; k < 3; ++k) index[k] = ball.vertex(0.16f * corners[k], corners[k]);
    ball.face(index[0], index[1], index[2]);
  }
  add_instance(scene, add_mesh(scene, ball.take()), material,
               glm::translate(glm::mat4(1.f), glm::vec3(-0.15f, 0.18f, -0.55f)));
  add_lamp(scene, {0.1f, 1.3f, -0.2f}, 1);
  return scene;
}

}  // namespace lucarium
