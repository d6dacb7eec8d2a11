// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium::bench {

enum class RayKind {
  primary,  ///< pinhole camera, one ray per pixel, row by row
  diffuse,  ///< cosine-distributed bounces off the first hits
  shadow,   ///< from the first hits to random points within the scene's bounds
};
const char* to_string(RayKind kind);

/// World-space triangles of a scene and rays through it.
struct RaySubject {
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  std::vector<Ray> primary, diffuse, shadow;
  std::vector<RayEnds> starts;  ///< of diffuse and shadow rays alike

  /// `scene` is a file or built-in, with "@camera" (docs/scenes.md) to look through another than its first one.
  /// One primary ray per pixel of width × height. The others stand in the order of the
  /// pixels, as a wavefront path tracer makes them, or, with `shuffled`, in random order.
  RaySubject(Device& device, KernelScheduler& scheduler, const std::string& scene, uint32_t width, uint32_t height,
             bool shuffled);
  /// The same of a scene as it stands.
  RaySubject(Device& device, KernelScheduler& scheduler, const Scene& scene, uint32_t width, uint32_t height,
             bool shuffled);
  const std::vector<Ray>& rays(RayKind kind) const;
};

}  // namespace lucarium::bench
