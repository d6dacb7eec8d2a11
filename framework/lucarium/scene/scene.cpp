// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

#include "lucarium/shared/scene_types.h"

namespace lucarium {

#define LUCARIUM_DEFAULT_SPECIAL_MEMBERS(Type)      \
  Type::Type() = default;                           \
  Type::Type(const Type&) = default;                \
  Type::Type(Type&&) noexcept = default;            \
  Type& Type::operator=(const Type&) = default;     \
  Type& Type::operator=(Type&&) noexcept = default; \
  Type::~Type() = default;
LUCARIUM_DEFAULT_SPECIAL_MEMBERS(Mesh)
LUCARIUM_DEFAULT_SPECIAL_MEMBERS(Scene)
#undef LUCARIUM_DEFAULT_SPECIAL_MEMBERS

namespace {

void add_texture_use(Hasher& hasher, const TextureUse& use) {
  hasher.add(use.texture);
  if (use.texture == none) return;
  hasher.add(use.uv_set).add(use.offset).add(use.scale).add(use.rotation).add(use.strength);
}

void add_material(Hasher& hasher, const SceneMaterial& m) {
  hasher.add(m.base_color).add(m.metallic).add(m.roughness).add(m.emissive_factor).add(m.emissive_strength);
  hasher.add(m.ior).add(m.transmission).add(m.thickness).add(m.attenuation_distance).add(m.attenuation_color);
  hasher.add(m.alpha_mode).add(m.alpha_cutoff).add(m.double_sided).add(m.unlit);
  for (const TextureUse* use : {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                                &m.emissive_texture, &m.transmission_texture}) {
    add_texture_use(hasher, *use);
  }
}

void add_mesh(Hasher& hasher, const Mesh& mesh) {
  hasher.add(mesh.positions).add(mesh.normals).add(mesh.tangents).add(mesh.uv[0]).add(mesh.uv[1]);
  hasher.add(mesh.colors).add(mesh.triangles);
}

void add_environment(Hasher& hasher, const Environment& environment) {
  hasher.add(environment.width).add(environment.height).add(environment.radiance);
  hasher.add(environment.factor).add(environment.environment_from_world);
}

bool is_black(const Image& image) {
  for (size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 != 3 && image.rgba[i] != 0) return false;
  }
  return true;
}

/// Whether the factors and some texel let light out.
bool shines(const Scene& scene, const SceneMaterial& material) {
  if (!material.emits()) return false;
  const int texture = (material.unlit ? material.base_color_texture : material.emissive_texture).texture;
  return texture == none || !is_black(scene.images[scene.textures[texture].image]);
}

}  // namespace

bool SceneMaterial::emits() const {
  if (unlit) return base_color.r > 0 || base_color.g > 0 || base_color.b > 0;
  const glm::vec3 emission = emissive_factor * emissive_strength;
  return emission.r > 0 || emission.g > 0 || emission.b > 0;
}

bool SceneMaterial::has_specular_lobes() const {
  return !unlit && (std::abs(ior - 1) >= 1e-3f || metallic > 0 || transmission > 0);
}

bool SceneMaterial::may_be_ideal() const {
  // A rough volume of ior 1 has nothing to bend light at.
  const bool unbent = transmission > 0 && std::abs(ior - 1) < 1e-3f;
  return has_specular_lobes() &&
         (roughness < LUCARIUM_MIRROR_ROUGHNESS || metallic_roughness_texture.texture != none || unbent);
}

Bounds Scene::instance_bounds(int index) const {
  const SceneInstance& instance = instances[index];
  Bounds result;
  for (const glm::vec3& p : instance.shape(*this).positions) {
    result.add(glm::vec3(instance.world_from_object * glm::vec4(p, 1.f)));
  }
  return result;
}

Bounds Scene::bounds() const {
  Bounds result;
  for (int i = 0; i < static_cast<int>(instances.size()); ++i) result.add(instance_bounds(i));
  return result;
}

uint64_t Scene::triangle_count() const {
  uint64_t count = 0;
  for (const SceneInstance& instance : instances) count += meshes[instance.mesh].triangles.size();
  return count;
}

bool Scene::has_light() const {
  const auto positive = [](const glm::vec3& v) { return v.r > 0 || v.g > 0 || v.b > 0; };
  for (const SceneLight& light : lights) {
    if (positive(light.intensity)) return true;
  }
  for (const SceneInstance& instance : instances) {
    if (!meshes[instance.mesh].triangles.empty() && shines(*this, materials[instance.material])) return true;
  }
  if (!environment || !positive(environment->factor)) return false;
  if (environment->width == 0) return true;
  for (const glm::vec3& radiance : environment->radiance) {
    if (positive(radiance * environment->factor)) return true;
  }
  return false;
}

Hash128 Scene::hash() const {
  Hasher hasher;
  hasher.add("lucarium scene 1");
  hasher.add(static_cast<uint64_t>(meshes.size()));
  for (const Mesh& mesh : meshes) add_mesh(hasher, mesh);
  hasher.add(static_cast<uint64_t>(instances.size()));
  for (const SceneInstance& instance : instances) {
    hasher.add(instance.mesh).add(instance.material).add(instance.world_from_object).add(instance.mirrored);
    hasher.add(instance.pose != nullptr);
    if (instance.pose) add_mesh(hasher, *instance.pose);
  }
  hasher.add(static_cast<uint64_t>(materials.size()));
  for (const SceneMaterial& material : materials) add_material(hasher, material);
  hasher.add(static_cast<uint64_t>(images.size()));
  for (const Image& image : images) hasher.add(image.width).add(image.height).add(image.rgba);
  hasher.add(static_cast<uint64_t>(textures.size()));
  for (const SceneTexture& t : textures) {
    hasher.add(t.image).add(t.wrap_u).add(t.wrap_v).add(t.nearest).add(t.srgb);
  }
  hasher.add(static_cast<uint64_t>(lights.size()));
  for (const SceneLight& light : lights) {
    hasher.add(light.type).add(light.intensity).add(light.inner_angle).add(light.outer_angle);
    hasher.add(light.world_from_light);
  }
  hasher.add(environment.has_value());
  if (environment) add_environment(hasher, *environment);
  return hasher.finish();
}

}  // namespace lucarium
