// SPDX-License-Identifier: Apache-2.0
#include "lucarium/conformance/check_scenes.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "lucarium/base/error.h"
#include "lucarium/base/numbers.h"
#include "lucarium/scene/builtin/builder.h"

namespace lucarium::check {
namespace {

void add_floor(Scene& scene, float half, int material) {
  add_instance(
      scene,
      add_mesh(
          scene,
          MeshBuilder("floor").quad({-half, 0, half}, {half, 0, half}, {half, 0, -half}, {-half, 0, -half}).take()),
      material);
}

SceneLight& add_light(Scene& scene, LightType type, const glm::vec3& position, const glm::vec3& direction,
                      float intensity) {
  SceneLight light;
  light.name = "lamp";
  light.type = type;
  light.intensity = glm::vec3(intensity);
  light.world_from_light = frame_along(position, direction);
  scene.lights.push_back(light);
  return scene.lights.back();
}

void add_white_sky(Scene& scene, float radiance) {
  scene.environment = Environment{};
  scene.environment->name = "white";
  scene.environment->factor = glm::vec3(radiance);
}

/// A sky that differs from end to end along every axis, each in a colour of its own: 1 + 0.8 of one coordinate of the
/// direction. Light that comes from a wrong direction, or the wrong end of a ray, has another colour.
void add_uneven_sky(Scene& scene) {
  Environment sky;
  sky.name = "uneven";
  sky.width = 64;
  sky.height = 32;
  for (uint32_t row = 0; row < sky.height; ++row) {
    for (uint32_t column = 0; column < sky.width; ++column) {
      const double theta = pi * (row + 0.5) / sky.height, phi = 2 * pi * (column + 0.5) / sky.width;
      const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      sky.radiance.push_back(glm::vec3(1.0 + 0.8 * d));
    }
  }
  scene.environment = sky;
}

/// A square lamp at height y that shines down.
void add_lamp(Scene& scene, float y, float half, float radiance) {
  add_instance(
      scene,
      add_mesh(scene,
               MeshBuilder("lamp").quad({-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}).take()),
      add_emitter(scene, "lamp", glm::vec3(radiance)));
}

/// Form factor of a square of half side `half` from a small patch at the distance `height` below its middle, both
/// horizontal: four corner rectangles (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3).
double form_factor(double half, double height) {
  const double a = half / height, root = std::sqrt(1 + a * a);
  return 4 / (2 * pi) * 2 * (a / root) * std::atan(a / root);
}

/// A lamp of the given kind for pictures of about unit radiance.
void add_picture_light(Scene& scene, LightKind kind) {
  switch (kind) {
    case LightKind::point: add_light(scene, LightType::point, {-1.2f, 2.5f, 1.5f}, {0, -1, 0}, 20); break;
    case LightKind::spot: {
      SceneLight& light = add_light(scene, LightType::spot, {-1.2f, 2.5f, 1.5f}, {1.2f, -2.5f, -1.5f}, 40);
      light.inner_angle = 0.2f;
      light.outer_angle = 0.5f;
      break;
    }
    case LightKind::directional: add_light(scene, LightType::directional, {0, 3, 0}, {0.5f, -1, -0.4f}, 4); break;
    case LightKind::environment: add_uneven_sky(scene); break;
    case LightKind::emissive: add_lamp(scene, 2.5f, 0.6f, 12); break;
  }
}

/// An upright square about the z axis with texture coordinates and tangents; facing +z, where the camera is.
Mesh make_screen() {
  Mesh mesh = MeshBuilder("screen")
                  .quad({-0.7f, 0.1f, 0.3f}, {0.7f, 0.1f, 0.3f}, {0.7f, 1.5f, 0.3f}, {-0.7f, 1.5f, 0.3f})
                  .take();
  mesh.uv[0] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  mesh.tangents.assign(4, {1, 0, 0, 1});
  return mesh;
}

/// 4×4 texels: alternately `a` and `b`, nearest texel.
int add_checker(Scene& scene, const std::array<uint8_t, 4>& a, const std::array<uint8_t, 4>& b) {
  Image image;
  image.name = "checker";
  image.width = image.height = 4;
  for (int i = 0; i < 16; ++i) {
    const std::array<uint8_t, 4>& texel = (i + i / 4) % 2 ? a : b;
    image.rgba.insert(image.rgba.end(), texel.begin(), texel.end());
  }
  scene.images.push_back(std::move(image));
  SceneTexture texture;
  texture.image = static_cast<int>(scene.images.size()) - 1;
  texture.nearest = true;
  scene.textures.push_back(texture);
  return static_cast<int>(scene.textures.size()) - 1;
}

/// Two-sided, with what the kind of alpha or normal map asks for.
int add_textured(Scene& scene, MaterialKind kind) {
  const int index = add_lambert(scene, name_of(kind), {0.3f, 0.5f, 0.7f});
  SceneMaterial& material = scene.materials[index];
  material.double_sided = true;
  if (kind == MaterialKind::mask) {
    material.alpha_mode = AlphaMode::mask;
    material.base_color_texture.texture = add_checker(scene, {255, 255, 255, 255}, {255, 255, 255, 0});
  } else if (kind == MaterialKind::blend) {
    material.alpha_mode = AlphaMode::blend;
    material.base_color.a = 0.5f;
  } else {
    material.normal_texture.texture = add_checker(scene, {168, 128, 246, 255}, {88, 128, 246, 255});
  }
  return index;
}

int add_transparent(Scene& scene, MaterialKind kind) {
  const bool refracts = kind == MaterialKind::refraction;
  const int material = add_dielectric(scene, name_of(kind), glm::vec3(0.9f), refracts ? 0.f : 0.3f);
  scene.materials[material].transmission = 1;
  if (refracts) scene.materials[material].thickness = 1;
  return material;
}

int add_material(Scene& scene, MaterialKind kind) {
  const std::string name = name_of(kind);
  switch (kind) {
    case MaterialKind::diffuse: return add_lambert(scene, name, {0.7f, 0.4f, 0.2f});
    case MaterialKind::glossy: return add_metal(scene, name, {0.9f, 0.7f, 0.5f}, 0.4f);
    case MaterialKind::mirror: return add_metal(scene, name, {0.9f, 0.9f, 0.9f}, 0);
    case MaterialKind::refraction:
    case MaterialKind::transmission: return add_transparent(scene, kind);
    case MaterialKind::mask:
    case MaterialKind::blend:
    case MaterialKind::normal_map: return add_textured(scene, kind);
  }
  throw Error(ErrorClass::internal, "no check scene has a material of this kind");
}

/// The object in the middle of a picture: a box, or a screen where the material needs texture coordinates or is thin.
void add_object(Scene& scene, MaterialKind kind) {
  using enum MaterialKind;
  const bool solid = kind == diffuse || kind == glossy || kind == mirror || kind == refraction;
  const int material = add_material(scene, kind);
  add_instance(scene,
               add_mesh(scene, solid ? MeshBuilder("box").box({-0.5f, 0.05f, -0.5f}, {0.5f, 1.05f, 0.5f}).take()
                                     : make_screen()),
               material);
}

void look_at_middle(Scene& scene) {
  scene.cameras.push_back(look_at_camera("front", {0.9f, 1.6f, 3.4f}, {0, 0.5f, 0}, 38.f));
}

}  // namespace

LitFloor make_lit_floor(LightKind light) {
  LitFloor floor;
  Scene& scene = floor.scene;
  scene.source = "check:floor-" + name_of(light);
  add_floor(scene, 10, add_lambert(scene, "floor", glm::vec3(albedo)));
  switch (light) {
    case LightKind::point:  // E = I cos θ / d²
      add_light(scene, LightType::point, {1, 2, 0}, {0, -1, 0}, 10);
      floor.irradiance = 10 * (2 / std::sqrt(5.0)) / 5;
      break;
    case LightKind::spot: {  // the same inside the inner cone
      SceneLight& lamp = add_light(scene, LightType::spot, {1, 2, 0}, {-1, -2, 0}, 10);
      lamp.inner_angle = 0.3f;
      lamp.outer_angle = 0.6f;
      floor.irradiance = 10 * (2 / std::sqrt(5.0)) / 5;
      break;
    }
    case LightKind::directional:  // E = E⊥ cos θ
      add_light(scene, LightType::directional, {0, 3, 0}, {0.6f, -0.8f, 0}, 3);
      floor.irradiance = 3 * 0.8;
      break;
    case LightKind::emissive:  // E = π L F
      add_lamp(scene, 2, 0.5f, 5);
      floor.irradiance = pi * 5 * form_factor(0.5, 2);
      break;
    case LightKind::environment:  // E = π L
      add_white_sky(scene, 1);
      floor.irradiance = pi;
      break;
  }
  SceneCamera camera;
  camera.name = "point";
  camera.perspective = false;
  camera.xmag = camera.ymag = 5e-4f;
  camera.world_from_camera = frame_along({0, 1, 1}, {0, -1, -1});
  scene.cameras.push_back(camera);
  return floor;
}

Scene make_shining_box() {
  Scene scene;
  scene.source = "check:shining-box";
  SceneMaterial wall;
  wall.name = "wall";
  wall.base_color = glm::vec4(glm::vec3(albedo), 1);
  wall.metallic = 0;
  wall.roughness = 1;
  wall.ior = 1;
  wall.emissive_factor = glm::vec3(1);
  scene.materials.push_back(wall);
  MeshBuilder walls("walls");
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) walls.box_face({-1, -1, -1}, {1, 1, 1}, axis, side, true);
  }
  add_instance(scene, add_mesh(scene, walls.take()), 0);
  scene.cameras.push_back(look_at_camera("inside", {0.3f, 0.2f, 0.5f}, {-1, -0.4f, -1}, 60.f));
  return scene;
}

Scene make_material_scene(MaterialKind material, LightKind light) {
  Scene scene;
  scene.source = "check:" + name_of(material) + "-" + name_of(light);
  add_floor(scene, 3, add_lambert(scene, "floor", glm::vec3(0.6f)));
  add_object(scene, material);
  const Mesh low = MeshBuilder("low box").box({-1.3f, 0, -0.6f}, {-0.8f, 0.4f, 0.2f}).take();
  add_instance(scene, add_mesh(scene, low), add_lambert(scene, "low box", {0.2f, 0.6f, 0.3f}));
  add_picture_light(scene, light);
  look_at_middle(scene);
  return scene;
}

Scene make_sky_scene(const std::vector<MaterialKind>& materials) {
  Scene scene;
  scene.source = "check:sky";
  add_floor(scene, 3, add_lambert(scene, "floor", glm::vec3(0.6f)));
  const Mesh box = MeshBuilder("box").box({-0.45f, 0.05f, -0.45f}, {0.45f, 1.05f, 0.45f}).take();
  float x = -0.6f;
  for (const MaterialKind kind : materials) {
    // Turned, so that none of its faces shows what another axis would.
    const glm::mat4 place = glm::rotate(glm::translate(glm::mat4(1), {x, 0, 0}), 0.5f, {0, 1, 0});
    add_instance(scene, add_mesh(scene, box), add_material(scene, kind), place);
    x += 1.2f;
  }
  add_uneven_sky(scene);
  look_at_middle(scene);
  return scene;
}

Scene make_sides_scene(const std::vector<MaterialKind>& sheets) {
  Scene scene;
  scene.source = "check:sides";
  add_floor(scene, 3, add_lambert(scene, "floor", glm::vec3(0.6f)));
  const Mesh screen = make_screen();
  const auto add_turned = [&](int material, const glm::vec3& place, float angle, float size) {
    const glm::mat4 turned = glm::rotate(glm::translate(glm::mat4(1), place), angle, {0, 1, 0});
    add_instance(scene, add_mesh(scene, screen), material, glm::scale(turned, glm::vec3(size)));
  };
  const int lamp = add_emitter(scene, "lamp", glm::vec3(3));
  scene.materials[lamp].double_sided = true;
  const auto back = static_cast<float>(pi);
  add_turned(lamp, {0, 0, -0.4f}, back, 0.6f);
  float side = -1;
  for (const MaterialKind kind : sheets) {
    add_turned(add_textured(scene, kind), {0.75f * side, 0, 0.1f}, back - 0.5f * side, 0.6f);
    side = -side;
  }
  look_at_middle(scene);
  return scene;
}

Scene make_lobes_scene(LightKind light) {
  Scene scene;
  scene.source = "check:lobes-" + name_of(light);
  add_floor(scene, 3, add_dielectric(scene, "coated floor", glm::vec3(0.5f), 0));
  const Mesh box = MeshBuilder("box").box({-0.5f, 0.05f, -0.5f}, {0.5f, 1.05f, 0.5f}).take();
  add_instance(scene, add_mesh(scene, box), add_dielectric(scene, "coated box", {0.7f, 0.4f, 0.2f}, 0));
  add_picture_light(scene, light);
  look_at_middle(scene);
  return scene;
}

Scene make_changing_scene(LightKind light) {
  Scene scene;
  scene.source = "check:changing-" + name_of(light);
  add_floor(scene, 3, add_lambert(scene, "floor", glm::vec3(0.6f)));
  const int moving = add_lambert(scene, "moving", {0.7f, 0.3f, 0.2f}),
            soft = add_lambert(scene, "soft", {0.2f, 0.4f, 0.7f});
  add_instance(scene, add_mesh(scene, MeshBuilder("moving").box({-0.9f, 0.05f, -0.4f}, {-0.2f, 0.7f, 0.3f}).take()),
               moving);
  add_instance(scene, add_mesh(scene, MeshBuilder("soft").box({0.2f, 0.05f, -0.4f}, {0.9f, 1, 0.3f}).take()), soft);
  scene.instances.back().pose = std::make_shared<Mesh>(scene.meshes.back());
  add_picture_light(scene, light);
  look_at_middle(scene);
  return scene;
}

}  // namespace lucarium::check
