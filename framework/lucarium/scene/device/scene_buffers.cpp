// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/scene_buffers.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/scene/device/environment_tables.h"
#include "lucarium/scene/device/memory_requirements.h"
#include "lucarium/scene/device/specular_albedo.h"
#include "lucarium/scene/device/texture_sampling.h"

namespace lucarium {

namespace {

constexpr const char* owner = "scene";
constexpr const char* remedy = "lower --texture-size or use a smaller scene";

/// Bounds that also hold what the device computes in single precision.
Bounds padded(const Bounds& bounds) {
  if (bounds.empty()) return {glm::vec3(0), glm::vec3(0)};
  const glm::vec3 margin = 4e-7f * (glm::abs(bounds.min) + glm::abs(bounds.max));
  return {bounds.min - margin, bounds.max + margin};
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace

SceneBuffers::SceneBuffers(Device& device, const Scene& scene, LightChoice light_choice)
    : device_(&device), light_choice_(light_choice), layout_(scene), transform_(device) {
  build(scene);
}

void SceneBuffers::build(const Scene& scene) {
  refuse_if_too_large(scene);
  upload_textures(scene);
  upload_materials(scene);
  upload_meshes(scene);
  upload_environment(scene);
  const auto& srgb = srgb_to_linear_table();
  store(scene_srgb_table, "sRGB table", std::vector<float>(srgb.begin(), srgb.end()));
  store(scene_albedo_table, "albedo table", specular_albedo_table());
  instance_bounds_.clear();
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    instance_bounds_.push_back(scene.instance_bounds(static_cast<int>(i)));
  }
  refresh_info(scene);
  refresh_lights(scene);
}

void SceneBuffers::refuse_if_too_large(const Scene& scene) const {
  // What this object alone holds is replaced, not added to; what recorded schedules hold, too, stays until they go.
  const MemoryAccount& account = device_->memory();
  const size_t others = account.used_bytes() - std::min(account.used_bytes(), replaceable_bytes());
  size_t total = 0;
  std::string largest;
  size_t largest_bytes = 0;
  for (const MemoryRequirement& need : memory_requirements(scene, layout_)) {
    total += need.bytes;
    if (need.bytes > largest_bytes) largest = need.name, largest_bytes = need.bytes;
    if (need.bytes <= account.single_bytes()) continue;
    throw_error(ErrorClass::device, "{}: its {} need {} in one piece, the device allows {}; {}", scene.source,
                need.name, format_bytes(need.bytes), format_bytes(account.single_bytes()), remedy);
  }
  if (total <= account.total_bytes() - std::min(others, account.total_bytes())) return;
  throw_error(ErrorClass::device,
              "{}: the scene needs {} of device memory (its {} alone {}), but {} of {} are in use; {}", scene.source,
              format_bytes(total), largest, format_bytes(largest_bytes), format_bytes(others),
              format_bytes(account.total_bytes()), remedy);
}

template <class T>
void SceneBuffers::store(TypedBuffer<T>& buffer, const char* name, const std::vector<T>& values, size_t capacity) {
  capacity = std::max(capacity, values.size());
  if (!buffer || buffer.count() < values.size()) {
    TypedBuffer<T> larger(*device_, owner, name, capacity, remedy);  // if this is refused, the old one stays
    larger.upload(values);
    buffer = std::move(larger);
    ++generation_;
    return;
  }
  buffer.upload(values);
}

void SceneBuffers::upload_textures(const Scene& scene) {
  scene_texels = {};
  scene_texels = TypedBuffer<uint>(*device_, owner, "texels", texel_count(scene), remedy);
  ++generation_;
  std::vector<uint> first(scene.images.size(), LUCARIUM_NONE);
  uint next = 0;
  std::vector<Texture> records;
  for (const SceneTexture& texture : scene.textures) {
    Texture record{};
    if (texture.image != none) {
      const Image& image = scene.images[texture.image];
      if (first[texture.image] == LUCARIUM_NONE) {
        first[texture.image] = next;
        // RGBA bytes are the texel's little-endian uint.
        scene_texels.write(image.rgba.data(), image.rgba.size(), size_t{next} * sizeof(uint));
        next += image.width * image.height;
      }
      record.first_texel = first[texture.image];
      record.width = image.width, record.height = image.height;
    }
    record.flags = static_cast<uint>(texture.wrap_u) | static_cast<uint>(texture.wrap_v) << 2 |
                   (texture.nearest ? LUCARIUM_TEXTURE_NEAREST : 0u) | (texture.srgb ? LUCARIUM_TEXTURE_SRGB : 0u);
    records.push_back(record);
  }
  store(scene_textures, "textures", records);
}

void SceneBuffers::upload_materials(const Scene& scene) {
  std::vector<bool> colored(scene.materials.size(), false);
  for (const SceneInstance& instance : scene.instances) {
    if (!scene.meshes[instance.mesh].colors.empty()) colored[instance.material] = true;
  }
  std::vector<Material> records;
  for (size_t i = 0; i < scene.materials.size(); ++i) records.push_back(pack_material(scene.materials[i], colored[i]));
  store(scene_materials, "materials", records);
  store(scene_alpha, "alpha bits", alpha_bits(scene, layout_));
}

void SceneBuffers::upload_vertices(const Mesh& mesh, uint32_t first) {
  std::vector<Vertex> vertices;
  vertices.reserve(mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); ++i) vertices.push_back(pack_vertex(mesh, i));
  scene_mesh_vertices.upload(vertices, first);
}

void SceneBuffers::upload_meshes(const Scene& scene) {
  const auto replace = [&](auto& buffer, const char* name, size_t count) {
    buffer = {};
    buffer = std::remove_reference_t<decltype(buffer)>(*device_, owner, name, count, remedy);
  };
  ++generation_;
  replace(scene_mesh_vertices, "mesh vertices", layout_.mesh_vertices);
  replace(scene_mesh_triangles, "mesh triangles", layout_.mesh_triangles);
  replace(scene_vertices, "vertices", layout_.world_vertices);
  replace(scene_triangles, "triangles", layout_.world_triangles);
  replace(scene_instances, "instances", layout_.instances.size());
  for (const SceneLayout::VertexSource& source : layout_.vertex_sources) {
    upload_vertices(source.mesh == none ? *scene.instances[source.instance].pose : scene.meshes[source.mesh],
                    source.first);
  }
  size_t first = 0;
  for (const int index : layout_.meshes) {
    std::vector<uint4> corners;
    for (const glm::uvec3& t : scene.meshes[index].triangles) corners.push_back({t.x, t.y, t.z, 0});
    scene_mesh_triangles.upload(corners, first);
    first += corners.size();
  }
  scene_instances.upload(layout_.instances);
  derive({{0, static_cast<uint32_t>(layout_.world_vertices)}}, true);
}

void SceneBuffers::derive(const std::vector<VertexRange>& ranges, bool triangles) {
  transform_.run(ranges, {scene_instances, scene_mesh_vertices, scene_mesh_triangles, scene_vertices, scene_triangles},
                 triangles);
}

void SceneBuffers::upload_environment(const Scene& scene) {
  EnvironmentTables tables;
  if (scene.environment) tables = make_environment_tables(*scene.environment);
  store(scene_environment, "environment", tables.texels);
  store(scene_environment_cdf, "environment distribution", tables.cdf);
}

void SceneBuffers::refresh_info(const Scene& scene) {
  Bounds all;
  for (const Bounds& bounds : instance_bounds_) all.add(bounds);
  const Bounds bounds = padded(all);
  info_.bounds_min = float4(bounds.min, 0.f);
  info_.bounds_max = float4(bounds.max, bounds.radius());
  info_.triangle_count = static_cast<uint>(layout_.world_triangles);
  info_.instance_count = static_cast<uint>(layout_.instances.size());
  info_.material_count = static_cast<uint>(scene.materials.size());
  info_.flags = 0;
  for (const SceneInstance& instance : scene.instances) {
    const SceneMaterial& material = scene.materials[instance.material];
    if (material.alpha_mode != AlphaMode::opaque) info_.flags |= LUCARIUM_SCENE_HAS_ALPHA;
    if (material.transmission > 0) info_.flags |= LUCARIUM_SCENE_TRANSMITS;
  }
  const Environment environment =
      scene.environment ? Environment{"", scene.environment->width,  scene.environment->height,
                                      {}, scene.environment->factor, scene.environment->environment_from_world}
                        : Environment{"", 0, 0, {}, glm::vec3(0), glm::mat3(1)};
  const glm::mat3 rows = glm::transpose(environment.environment_from_world);
  info_.environment_factor = float4(environment.factor, 0.f);
  info_.environment_row0 = float4(rows[0], 0.f);
  info_.environment_row1 = float4(rows[1], 0.f);
  info_.environment_row2 = float4(rows[2], 0.f);
  info_.environment_width = environment.width;
  info_.environment_height = environment.height;
}

void SceneBuffers::refresh_lights(const Scene& scene) {
  LightList list = light_builder_.build(scene, info_.bounds_max.w, light_choice_);
  const size_t capacity = light_capacity(scene);
  const bool first = !scene_lights;
  if (first || !same_bytes(list.lights, light_list_.lights)) store(scene_lights, "lights", list.lights, capacity);
  if (first || !same_bytes(list.table, light_list_.table))
    store(scene_light_table, "light table", list.table, capacity);
  if (first || !same_bytes(list.tree.header, light_list_.tree.header))
    store(scene_light_trees, "light trees", list.tree.header);
  if (first || !same_bytes(list.tree.nodes, light_list_.tree.nodes))
    store(scene_light_nodes, "light nodes", list.tree.nodes, light_tree_capacity(capacity));
  if (first || !same_bytes(list.tree.places, light_list_.tree.places))
    store(scene_light_places, "light places", list.tree.places, capacity);
  if (first || !same_bytes(list.triangle_lights, light_list_.triangle_lights)) {
    store(scene_triangle_lights, "triangle lights", list.triangle_lights);
  }
  light_list_ = std::move(list);
  info_.light_count = static_cast<uint>(light_list_.lights.size());
  info_.environment_light = light_list_.environment_light;
  info_.lamp_reach = light_list_.reach;
  store(scene_info, "info", std::vector<SceneInfo>{info_});
}

bool SceneBuffers::lights_change(const Scene& scene, const SceneChange& change, float previous_radius) const {
  if (change.lights || change.environment || !change.materials.empty()) return true;
  if (info_.bounds_max.w != previous_radius) {
    for (const Light& light : light_list_.lights) {
      if (light.kind == LUCARIUM_LIGHT_DIRECTIONAL || light.kind == LUCARIUM_LIGHT_ENVIRONMENT) return true;
    }
  }
  const auto emits = [&](int i) { return scene.materials[scene.instances[i].material].emits(); };
  return std::any_of(change.moved_instances.begin(), change.moved_instances.end(), emits) ||
         std::any_of(change.deformed_instances.begin(), change.deformed_instances.end(), emits);
}

void SceneBuffers::update_geometry(const Scene& scene, const SceneChange& change) {
  std::vector<int> touched = change.moved_instances;
  touched.insert(touched.end(), change.deformed_instances.begin(), change.deformed_instances.end());
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const int i : change.deformed_instances)
    upload_vertices(*scene.instances[i].pose, layout_.instances[i].mesh_vertex);

  bool winding = false;
  std::vector<VertexRange> ranges;
  for (const int i : touched) {
    Instance& record = layout_.instances[i];
    const uint flags_before = record.flags;
    place_instance(record, scene.instances[i]);
    winding = winding || record.flags != flags_before;
    scene_instances.write(&record, sizeof record, size_t(i) * sizeof record);
    instance_bounds_[i] = scene.instance_bounds(i);
    if (!ranges.empty() && ranges.back().first + ranges.back().count == record.world_vertex) {
      ranges.back().count += record.vertex_count;
    } else {
      ranges.push_back({record.world_vertex, record.vertex_count});
    }
  }
  // Many scattered ranges: one pass over all from the first to the last costs less than a launch for each.
  constexpr size_t max_passes = 16;
  if (ranges.size() > max_passes) {
    const VertexRange& last = ranges.back();
    ranges = {{ranges.front().first, last.first + last.count - ranges.front().first}};
  }
  derive(ranges, winding);
}

void SceneBuffers::update(const Scene& scene, const SceneChange& change) {
  if (!change.geometry() && change.materials.empty() && !change.lights && !change.environment) return;
  device_->finish();
  if (change.topology || !layout_.fits(scene)) {
    layout_ = SceneLayout(scene);
    light_builder_.drop_radiance();
    build(scene);
    return;
  }
  const float previous_radius = info_.bounds_max.w;
  if (!change.materials.empty()) {
    upload_materials(scene);
    light_builder_.drop_radiance();
  }
  if (change.environment) upload_environment(scene);
  if (change.geometry()) update_geometry(scene, change);
  refresh_info(scene);
  if (lights_change(scene, change, previous_radius)) {
    refresh_lights(scene);
  } else {
    store(scene_info, "info", std::vector<SceneInfo>{info_});
  }
}

SceneBuffers::SceneBuffers(SceneBuffers&&) noexcept = default;
SceneBuffers& SceneBuffers::operator=(SceneBuffers&&) noexcept = default;
SceneBuffers::~SceneBuffers() = default;

size_t SceneBuffers::bytes() const {
  size_t sum = scene_mesh_vertices.bytes() + scene_mesh_triangles.bytes();
#define LUCARIUM_ADD_BYTES(type, name, meaning) sum += name.bytes();
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_ADD_BYTES)
#undef LUCARIUM_ADD_BYTES
  return sum;
}

size_t SceneBuffers::replaceable_bytes() const {
  const auto own = [](const Buffer& buffer) { return buffer && !buffer.is_shared() ? buffer.bytes() : 0; };
  size_t sum = own(scene_mesh_vertices) + own(scene_mesh_triangles);
#define LUCARIUM_ADD_BYTES(type, name, meaning) sum += own(name);
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_ADD_BYTES)
#undef LUCARIUM_ADD_BYTES
  return sum;
}

size_t SceneBuffers::estimate_bytes(const Scene& scene) {
  size_t sum = 0;
  for (const MemoryRequirement& need : memory_requirements(scene, SceneLayout(scene))) sum += need.bytes;
  return sum;
}

void SceneBuffers::bind(PassBuilder& pass) const {
#define LUCARIUM_BIND_BUFFER(type, name, meaning) pass.arg_if_present(#name, name);
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_BIND_BUFFER)
#undef LUCARIUM_BIND_BUFFER
  pass.arg_if_present("scene_mesh_vertices", scene_mesh_vertices);
  pass.arg_if_present("scene_mesh_triangles", scene_mesh_triangles);
}

}  // namespace lucarium
