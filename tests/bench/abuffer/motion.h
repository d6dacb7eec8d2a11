// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium::bench {

/// Prints for animations of the built-in scenes what a frame costs through voxel_abuffer's structure, through the
/// hierarchy rebuilt and through the hierarchy refitted, and up to how many rays per frame each rebuild pays. `only`:
/// part of the names of those that are measured.
void measure_motion(KernelScheduler& scheduler, int rounds, uint32_t width, uint32_t height, const std::string& only);

}  // namespace lucarium::bench
