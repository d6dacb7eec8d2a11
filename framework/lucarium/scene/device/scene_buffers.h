// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "lucarium/compute/device/buffer.h"
#include "lucarium/compute/schedule/schedule.h"
#include "lucarium/scene/device/light_list.h"
#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/scene/device/scene_transform.h"
#include "lucarium/scene/scene.h"
#include "lucarium/shared/camera.h"
#include "lucarium/shared/scene_buffers.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium {

/// The scene on the device: object-space meshes, instances with stable ids, and the derived world-space vertices and
/// triangles that most kernels read. Owner "scene" in the memory account.
class SceneBuffers {
 public:
  /// Throws Error{device} with required and free bytes, and --texture-size as remedy, if the scene does not fit.
  SceneBuffers(Device& device, const Scene& scene, LightChoice light_choice = LightChoice::tree);
  SceneBuffers(SceneBuffers&&) noexcept;
  SceneBuffers& operator=(SceneBuffers&&) noexcept;
  ~SceneBuffers();  // compiled once, not in every source that has one

  /// Uploads and derives exactly what the change touches; ids stay. Afterwards the buffers hold what a new
  /// SceneBuffers of the scene would hold. Waits for the device first: not to be called during a schedule's run.
  void update(const Scene& scene, const SceneChange& change);

  /// Grows when a buffer had to be replaced (topology, more lights than before, another environment size): schedules
  /// that bind scene buffers must be recorded again.
  uint64_t generation() const { return generation_; }

  /// Binds every scene buffer the pass's kernel has a parameter for (LUCARIUM_SCENE_PARAMETERS, or single ones).
  void bind(PassBuilder& pass) const;

#define LUCARIUM_DECLARE_SCENE_BUFFER(type, name, meaning) TypedBuffer<type> name;
  LUCARIUM_SCENE_BUFFERS(LUCARIUM_DECLARE_SCENE_BUFFER)
#undef LUCARIUM_DECLARE_SCENE_BUFFER

  TypedBuffer<Vertex> scene_mesh_vertices;  ///< object space
  TypedBuffer<uint4> scene_mesh_triangles;  ///< object space: v0, v1, v2 relative to the mesh, unused

  const SceneInfo& info() const { return info_; }
  size_t bytes() const;
  /// What the constructor would allocate, without allocating.
  static size_t estimate_bytes(const Scene& scene);

 private:
  void build(const Scene& scene);
  void refuse_if_too_large(const Scene& scene) const;
  void upload_meshes(const Scene& scene);
  void upload_vertices(const Mesh& mesh, uint32_t first);
  void upload_materials(const Scene& scene);
  void upload_textures(const Scene& scene);
  void upload_environment(const Scene& scene);
  void update_geometry(const Scene& scene, const SceneChange& change);
  void derive(const std::vector<VertexRange>& ranges, bool triangles);
  void refresh_info(const Scene& scene);
  void refresh_lights(const Scene& scene);
  bool lights_change(const Scene& scene, const SceneChange& change, float previous_radius) const;

  size_t replaceable_bytes() const;  ///< that are given back when this lets go of its buffers

  /// Uploads, into new memory only when the buffer is too small (or not there).
  template <class T>
  void store(TypedBuffer<T>& buffer, const char* name, const std::vector<T>& values, size_t capacity = 0);

  Device* device_;
  LightChoice light_choice_;
  uint64_t generation_ = 0;
  SceneInfo info_{};
  SceneLayout layout_;
  std::vector<Bounds> instance_bounds_;
  LightListBuilder light_builder_;
  LightList light_list_;
  SceneTransform transform_;
};

/// The kernel camera for an image of the given aspect (width / height).
Camera make_camera(const SceneCamera& camera, float aspect);

}  // namespace lucarium
