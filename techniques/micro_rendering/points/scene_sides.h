// SPDX-License-Identifier: Apache-2.0
// Which surfaces of a scene carry points, and which of them move together.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/scene.h"
#include "micro_rendering/points/point_sampling.h"

namespace lucarium::micro {

enum class TreeKind {
  resting,    ///< everything that no animation moves; tree space is the world
  rigid,      ///< one instance whose matrix moves it; tree space is its object space
  deforming,  ///< one instance that is skinned, morphed or stretched; tree space is the world, leaves follow
};

/// What becomes one tree.
struct TreeSource {
  TreeKind kind = TreeKind::resting;
  int instance = none;             ///< of the moving kinds
  std::vector<SurfaceSide> sides;  ///< in the space in which points are placed: the world, or the object at rest.
                                   ///< SurfaceSide::source: MicroLeaf::triangle
  double plain_area = 0;           ///< of its triangles in that space, each once
  double covered_area = 0;         ///< of its sides, both where both count, coverage included
  glm::vec3 low{INFINITY}, high{-INFINITY};  ///< box about its vertices in tree space; not of the deforming kind
};

/// Whether `world_from_object` keeps angles and handedness.
bool is_similarity(const glm::mat4& world_from_object);

/// Area of an instance's triangles in the world at present, each once [m²].
double instance_area(const Scene& scene, int instance);

/// Sources of all trees, the resting one first; without sides where nothing is covered. A moving instance's points are
/// placed on its mesh at rest, so that they do not depend on when the run began. `moving`: instances that move though
/// no animation does it. Throws Error{interrupted}.
std::vector<TreeSource> find_tree_sources(const Scene& scene, const SceneBuffers& buffers,
                                          const std::vector<int>& moving = {}, int threads = 1);

/// Moves points to where their triangles are in the world at present.
void pose_points(const SceneBuffers& buffers, std::vector<SampledPoint>& points);

/// PointTest over the scene (its context): whether a point of a MASK or BLEND triangle is there.
bool point_is_there(const void* scene_points, uint32_t source, glm::vec2 weights, float random);

/// Context of point_is_there: the triangles of a tree's source and where their texture coordinates are.
struct ScenePoints {
  const Scene* scene;
  std::vector<int> instance_of_triangle;  ///< by world triangle
  std::vector<uint32_t> first_triangle;   ///< by instance
  ScenePoints(const Scene& scene_, const SceneBuffers& buffers);
  /// Texture coordinates of a triangle's corners in its alpha's texture; whether that texture alone decides the alpha.
  bool alpha_corners(uint32_t triangle, std::array<glm::vec2, 3>& at) const;
  /// Length of a triangle's longest edge in its alpha's texture [texels]; 0 without one.
  float texels(uint32_t triangle) const;
  /// Linear alpha of a point.
  float alpha(uint32_t triangle, glm::vec2 weights) const;
  const SceneMaterial& material(uint32_t triangle) const;
};

}  // namespace lucarium::micro
