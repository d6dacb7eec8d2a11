// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/scene_sides.h"

#include <algorithm>

#include "lucarium/base/parallel.h"
#include "lucarium/scene/animation.h"
#include "lucarium/scene/device/degenerate_triangle.h"
#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/scene/device/texture_sampling.h"
#include "micro_rendering/points/coverage.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::micro {
namespace {

// Triangles of an instance whose coverage is looked up between two looks whether to stop.
constexpr uint32_t kTrianglesAtOnce = 1 << 14;

TreeKind kind_of(const SceneInstance& instance, bool moves) {
  if (instance.pose) return TreeKind::deforming;
  if (!moves) return TreeKind::resting;
  return is_similarity(instance.world_from_object) ? TreeKind::rigid : TreeKind::deforming;
}

double triangle_area(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  return 0.5 * static_cast<double>(glm::length(glm::cross(b - a, c - a)));
}

std::vector<float> coverage_of_triangles(const ScenePoints& points, int threads) {
  const TriangleCoverage coverage_of(points, threads);
  const auto triangles = static_cast<uint32_t>(points.instance_of_triangle.size());
  std::vector<float> coverage(triangles);
  for (uint32_t first = 0; first < triangles; first += kTrianglesAtOnce) {
    throw_if_interrupted("coverage of triangles");
    parallel_for(std::min(kTrianglesAtOnce, triangles - first), threads,
                 [&](uint32_t i) { coverage[first + i] = coverage_of(first + i); });
  }
  throw_if_interrupted("coverage of triangles");  // the last ones may have been left out
  return coverage;
}

/// One or two sides of a triangle whose corners in the placing space are a, b, c.
void add_sides(TreeSource& tree, const ScenePoints& points, uint32_t triangle, float coverage,
               const glm::vec3 corners[3]) {
  const double area = triangle_area(corners[0], corners[1], corners[2]);
  tree.plain_area += area;
  if (coverage <= 0) return;
  tree.sides.push_back({corners[0], corners[1], corners[2], triangle, coverage});
  tree.covered_area += area * static_cast<double>(coverage);
  if (!is_two_sided(points.material(triangle))) return;
  // The same corners: barycentric weights keep their meaning, and MICRO_LEAF_BACK turns the normal.
  tree.sides.push_back({corners[0], corners[1], corners[2], triangle | MICRO_LEAF_BACK, coverage});
  tree.sides.back().back = true;
  tree.covered_area += area * static_cast<double>(coverage);
}

}  // namespace

bool is_similarity(const glm::mat4& m) {
  const glm::vec3 x(m[0]), y(m[1]), z(m[2]);
  const float size = glm::dot(x, x), tolerance = 1e-4f * size;
  return size > 0 && std::abs(glm::dot(y, y) - size) < tolerance && std::abs(glm::dot(z, z) - size) < tolerance &&
         std::abs(glm::dot(x, y)) < tolerance && std::abs(glm::dot(y, z)) < tolerance &&
         std::abs(glm::dot(z, x)) < tolerance && glm::dot(glm::cross(x, y), z) > 0;
}

double instance_area(const Scene& scene, int index) {
  const SceneInstance& instance = scene.instances[static_cast<size_t>(index)];
  const Mesh& shape = instance.shape(scene);
  const glm::mat3 linear(instance.world_from_object);
  double area = 0;
  for (const glm::uvec3& t : shape.triangles)
    area += triangle_area(linear * shape.positions[t.x], linear * shape.positions[t.y], linear * shape.positions[t.z]);
  return area;
}

ScenePoints::ScenePoints(const Scene& scene_, const SceneBuffers& buffers) : scene(&scene_) {
  const SceneLayout layout(scene_);
  instance_of_triangle.resize(buffers.info().triangle_count);
  for (size_t i = 0; i < layout.instances.size(); ++i) {
    const Instance& record = layout.instances[i];
    first_triangle.push_back(record.world_triangle);
    for (uint32_t t = 0; t < record.triangle_count; ++t)
      instance_of_triangle[record.world_triangle + t] = static_cast<int>(i);
  }
}

const SceneMaterial& ScenePoints::material(uint32_t triangle) const {
  return scene
      ->materials[static_cast<size_t>(scene->instances[static_cast<size_t>(instance_of_triangle[triangle])].material)];
}

float ScenePoints::alpha(uint32_t triangle, glm::vec2 weights) const {
  const int index = instance_of_triangle[triangle];
  const SceneInstance& instance = scene->instances[static_cast<size_t>(index)];
  const Mesh& mesh = scene->meshes[static_cast<size_t>(instance.mesh)];
  const SceneMaterial& mat = material(triangle);
  glm::uvec3 corner = mesh.triangles[triangle - first_triangle[static_cast<size_t>(index)]];
  // Where the winding is turned in the world, so are the weights of the second and third vertex.
  if (instance.mirrored || glm::determinant(glm::mat3(instance.world_from_object)) < 0) std::swap(corner.y, corner.z);
  const glm::vec3 w(1 - weights.x - weights.y, weights.x, weights.y);
  float value = mat.base_color.a;
  if (!mesh.colors.empty())
    value *= w.x * mesh.colors[corner.x].a + w.y * mesh.colors[corner.y].a + w.z * mesh.colors[corner.z].a;
  const TextureUse& use = mat.base_color_texture;
  if (use.texture == none) return value;
  const auto& uv = mesh.uv[use.uv_set];
  const glm::vec2 at = uv.empty() ? glm::vec2(0) : w.x * uv[corner.x] + w.y * uv[corner.y] + w.z * uv[corner.z];
  return value *
         sample_texture(*scene, scene->textures[static_cast<size_t>(use.texture)], texture_transform(use)(at)).a;
}

bool ScenePoints::alpha_corners(uint32_t triangle, std::array<glm::vec2, 3>& at) const {
  const int index = instance_of_triangle[triangle];
  const Mesh& mesh = scene->meshes[static_cast<size_t>(scene->instances[static_cast<size_t>(index)].mesh)];
  const TextureUse& use = material(triangle).base_color_texture;
  if (use.texture == none || mesh.uv[use.uv_set].empty()) return false;
  const TextureTransform transform = texture_transform(use);
  const glm::uvec3 corner = mesh.triangles[triangle - first_triangle[static_cast<size_t>(index)]];
  bool alone = true;
  for (int k = 0; k < 3; ++k) {
    at[static_cast<size_t>(k)] = transform(mesh.uv[use.uv_set][corner[k]]);
    if (!mesh.colors.empty()) alone &= mesh.colors[corner[k]].a == 1;
  }
  return alone;
}

float ScenePoints::texels(uint32_t triangle) const {
  std::array<glm::vec2, 3> at{};
  alpha_corners(triangle, at);
  const TextureUse& use = material(triangle).base_color_texture;
  if (use.texture == none) return 0;
  const Image& image = scene->images[static_cast<size_t>(scene->textures[static_cast<size_t>(use.texture)].image)];
  const glm::vec2 size(image.width, image.height);
  return std::max({glm::distance(size * at[0], size * at[1]), glm::distance(size * at[1], size * at[2]),
                   glm::distance(size * at[2], size * at[0])});
}

bool point_is_there(const void* scene_points, uint32_t source, glm::vec2 weights, float random) {
  const auto& points = *static_cast<const ScenePoints*>(scene_points);
  const uint32_t triangle = source & ~MICRO_LEAF_BACK;
  const SceneMaterial& material = points.material(triangle);
  const float alpha = points.alpha(triangle, weights);
  return material.alpha_mode == AlphaMode::mask ? alpha >= material.alpha_cutoff : random < alpha;
}

void pose_points(const SceneBuffers& buffers, std::vector<SampledPoint>& points) {
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  const std::vector<Triangle> triangles = buffers.scene_triangles.download(0, buffers.info().triangle_count);
  for (SampledPoint& p : points) {
    const Triangle& t = triangles[p.source & ~MICRO_LEAF_BACK];
    const glm::vec3 a = vertices[t.v0].position.xyz(), b = vertices[t.v1].position.xyz() - a,
                    c = vertices[t.v2].position.xyz() - a;
    p.position = a + p.weights.x * b + p.weights.y * c;
    const glm::vec3 n = p.source & MICRO_LEAF_BACK ? glm::cross(c, b) : glm::cross(b, c);
    const float length = glm::length(n);
    if (length > 0) p.normal = n / length;
  }
}

std::vector<TreeSource> find_tree_sources(const Scene& scene, const SceneBuffers& buffers,
                                          const std::vector<int>& moving, int threads) {
  const std::vector<bool> animated = animated_nodes(scene);
  const ScenePoints points(scene, buffers);
  const std::vector<float> coverage = coverage_of_triangles(points, threads);
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  const std::vector<Triangle> triangles = buffers.scene_triangles.download(0, buffers.info().triangle_count);
  const SceneLayout layout(scene);

  std::vector<TreeSource> trees(1);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const SceneInstance& instance = scene.instances[i];
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    const Instance& record = layout.instances[i];
    const bool moves = std::find(moving.begin(), moving.end(), static_cast<int>(i)) != moving.end();
    const TreeKind kind =
        kind_of(instance, moves || (instance.node != none && animated[static_cast<size_t>(instance.node)]));
    if (kind != TreeKind::resting) {
      trees.emplace_back();
      trees.back().kind = kind;
      trees.back().instance = static_cast<int>(i);
    }
    TreeSource& tree = kind == TreeKind::resting ? trees[0] : trees.back();
    for (uint32_t t = record.world_triangle; t < record.world_triangle + record.triangle_count; ++t) {
      const uint32_t index[3] = {triangles[t].v0, triangles[t].v1, triangles[t].v2};
      glm::vec3 placed[3];
      for (int k = 0; k < 3; ++k) {
        placed[k] = kind == TreeKind::resting ? vertices[index[k]].position.xyz()
                                              : mesh.positions[index[k] - record.world_vertex];
      }
      // What deforms may gain an area.
      if (kind != TreeKind::deforming && is_degenerate(placed[0], placed[1], placed[2])) continue;
      for (const glm::vec3& p : placed) tree.low = glm::min(tree.low, p), tree.high = glm::max(tree.high, p);
      add_sides(tree, points, t, coverage[t], placed);
    }
  }
  return trees;
}

}  // namespace lucarium::micro
