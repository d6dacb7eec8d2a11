// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/surface_atlas/geometry.h"

#include "lucarium/scene/device/emission.h"
#include "lucarium/services/bvh/moving_parts.h"

namespace lucarium {

std::vector<uint8_t> two_sided_instances(const Scene& scene) {
  std::vector<uint8_t> result;
  for (const SceneInstance& instance : scene.instances)
    result.push_back(is_two_sided(scene.materials[instance.material]));
  return result;
}

AtlasGeometry read_atlas_geometry(const Scene& scene, const SceneBuffers& buffers, bool use_texcoord1) {
  WorldGeometry world;
  world.read_all(buffers);
  AtlasGeometry geometry;
  geometry.positions.reserve(world.vertices.size());
  geometry.normals.reserve(world.vertices.size());
  for (const Vertex& vertex : world.vertices) {
    geometry.positions.push_back(vertex.position.xyz());
    geometry.normals.push_back(vertex.normal.xyz());
    if (use_texcoord1) geometry.texcoord1.emplace_back(vertex.u1, vertex.v1);
  }
  geometry.triangles.reserve(world.triangles.size());
  geometry.instance.reserve(world.triangles.size());
  for (const Triangle& triangle : world.triangles) {
    geometry.triangles.emplace_back(triangle.v0, triangle.v1, triangle.v2);
    geometry.instance.push_back(triangle.instance);
  }
  geometry.two_sided = two_sided_instances(scene);
  for (const SceneInstance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[instance.mesh];
    geometry.names.push_back(mesh.name);
    if (use_texcoord1) geometry.has_texcoord1.push_back(!mesh.uv[1].empty());
  }
  return geometry;
}

}  // namespace lucarium
