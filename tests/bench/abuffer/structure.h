// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"

namespace lucarium::bench {

/// voxel_abuffer's structure, or one that it is compared with, whatever its class.
struct Structure {
  std::unique_ptr<Intersector> intersector;
  std::function<void()> rebuild;
  std::function<std::string()> summary;  ///< sizes and bytes, in one line
};

inline constexpr const char* structure_modes =
    "exact, auto, 2d, 3, 1 (the last three: parity), linked (2d by linked lists), and to compare with: grid, octree, "
    "voxel; MODE@N: of N voxels";

/// `size`: abuffer_size, `grid`: grid_size, where `named` names none.
Structure make_structure(const std::string& named, KernelScheduler& scheduler, const Scene& scene,
                         const SceneBuffers& buffers, uint32_t size, uint32_t grid);

}  // namespace lucarium::bench
