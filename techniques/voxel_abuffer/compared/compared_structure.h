// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "lucarium/services/intersector.h"
#include "voxel_abuffer/compared/voxel_pairs.h"

namespace lucarium::abuffer {

struct ComparedStatistics {
  uint32_t voxels = 0;           ///< along the longest side
  uint32_t pairs = 0;            ///< of voxels and triangles that touch
  uint32_t occupied_voxels = 0;  ///< that some triangle touches
  uint64_t builds = 0;
  double build_seconds = 0;  ///< of the last one, elapsed
  size_t bytes = 0;          ///< on the device, for rays
  size_t build_bytes = 0;    ///< kept for building
};

/// Pixels beside a triangle in which a voxel counts as touched, where occupied voxels are all that is known.
inline constexpr float occupied_pad = 0.01f;

/// A structure that voxel_abuffer is compared with (Hu et al. 2014, section 5.2): built on the device from the pairs of
/// voxels and triangles that touch, walked with the same steps as the voxels of the A-buffers. Owner "voxel_abuffer" in
/// the memory account. Results do not depend on the number of threads.
class ComparedStructure : public Intersector {
 public:
  /// Follows a change; after SceneBuffers::update(). Moved geometry rebuilds everything.
  void update(const SceneChange& change);
  void rebuild();
  /// Grows when passes recorded before must be recorded again.
  uint64_t generation() const { return generation_ + pairs_.generation(); }
  const ComparedStatistics& statistics() const { return statistics_; }

  std::string name() const override { return kind_.name; }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override;
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override;

 protected:
  struct Kind {
    std::string name;          ///< of the structure, and of its file of kernels
    bool morton = false;       ///< numbering of its bricks
    bool needs_scene = false;  ///< its kernels read the scene, without MASK or BLEND too
    float pad = 0;             ///< pixels beside a triangle in which voxels count as touched
    std::string remedy;        ///< when memory does not suffice
  };
  ComparedStructure(KernelScheduler& scheduler, const SceneBuffers& buffers, Kind kind);

  /// The grid around the scene's bounds at present.
  virtual AbufferGrid layout() const = 0;
  /// Makes from pairs() what rays need, and adds up statistics_.bytes.
  virtual void fill() = 0;
  virtual void bind(PassBuilder& pass) const = 0;

  template <class T>
  void make_room(TypedBuffer<T>& buffer, const std::string& name, size_t count) {
    generation_ += make_compared_room(scheduler_->device(), buffer, name, count, kind_.remedy);
  }
  KernelScheduler& scheduler() const { return *scheduler_; }
  const VoxelPairs& pairs() const { return pairs_; }
  Bounds bounds() const;
  void bind_scene(PassBuilder& pass) const { buffers_->bind(pass); }
  uint32_t triangle_count() const { return buffers_->info().triangle_count; }
  ComparedStatistics statistics_;

 private:
  void compile();
  void record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel, const RayBuffers& rays,
              const char* result_name, const BufferRef& result) const;

  KernelScheduler* scheduler_;
  const SceneBuffers* buffers_;
  Kind kind_;
  VoxelPairs pairs_;
  Program program_;
  bool alpha_ = false;
  uint64_t generation_ = 0;
};

}  // namespace lucarium::abuffer
