// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/buffer.h"
#include "lucarium/compute/schedule.h"
#include "lucarium/scene/light_list.h"
#include "lucarium/scene/scene.h"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/scene_buffers.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// The scene on the device: object-space meshes, instances with stable ids, and the derived world-space vertices and
/// triangles that most kernels read. Owner "scene" in the memory account.
class SceneBuffers {
 public:
  /// States its need first and refuses with numbers (Error{device}, remedy --texture-size) when it does not fit.
  SceneBuffers(Device& device, const Scene& scene, LightChoice light_choice = LightChoice::power);

  /// Uploads and derives exactly what the change touches; ids stay.
  void update(const Scene& scene, const SceneChange& change);

  /// Binds every scene buffer the pass's kernel has a parameter for (LUCARIUM_SCENE_PARAMETERS, or single ones).
  void bind(PassBuilder& pass, const Program& program, std::string_view kernel) const;

#define LUCARIUM_DECLARE_SCENE_BUFFER(type, name, meaning) TypedBuffer<type> name;
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_DECLARE_SCENE_BUFFER)
#undef LUCARIUM_DECLARE_SCENE_BUFFER

  TypedBuffer<Vertex> scene_mesh_vertices;   ///< object space
  TypedBuffer<uint4> scene_mesh_triangles;   ///< object space: v0, v1, v2 relative to the mesh, unused

  const SceneInfo& info() const { return info_; }
  size_t bytes() const;
  /// What the constructor would allocate, without allocating.
  static size_t estimate_bytes(const Scene& scene);

 private:
  SceneInfo info_;
  Program transform_program_;
};

/// The kernel camera for an image of the given aspect (width / height).
Camera make_camera(const SceneCamera& camera, float aspect);

}  // namespace lucarium
