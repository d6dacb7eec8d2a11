// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium::bench {

/// Prints the ratios that voxel_abuffer is judged by, each with what it must reach and what it should, and whether it
/// does. The device should have two threads.
void measure_ratios(KernelScheduler& scheduler, int rounds, uint32_t width, uint32_t height);

}  // namespace lucarium::bench
