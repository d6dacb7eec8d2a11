// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/program/program.h"
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::bidirectional {

/// Rasterizes perspective views one after the other, and keeps the nearest triangle of every texel.
class FaceRaster {
 public:
  /// `keep`: kernel of `program` that copies a face (number, side, seen) into `triangles`. `name`: of the passes.
  /// `remedy`: when memory does not suffice. `scene` must outlive this.
  FaceRaster(KernelScheduler& scheduler, const SceneBuffers& scene, const std::string& name, uint32_t side,
             const Program& program, const std::string& keep, const TypedBuffer<LayeredView>& views,
             const TypedBuffer<uint32_t>& triangles, const std::string& remedy, const std::string& owner);

  /// The first `views` views. False when cancelled.
  bool fill(uint32_t views);
  /// Follows a change of the scene. False where schedules must be recorded again.
  bool update();
  void warm_up() { scheduler_.warm_up(schedule_); }
  static size_t estimate_bytes(size_t triangles, uint32_t side);

 private:
  KernelScheduler& scheduler_;
  LayeredRaster raster_;
  uint64_t generation_;
  Schedule schedule_;
  Variable<uint32_t> number_;
};

}  // namespace lucarium::bidirectional
