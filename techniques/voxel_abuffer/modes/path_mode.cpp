// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/modes/path_mode.h"

#include "voxel_abuffer/base/name.h"

namespace lucarium::abuffer {
namespace {

PathIntegratorOptions integrator_options(const PathSet& path_set, uint32_t samples) {
  PathIntegratorOptions options;
  options.path_set = path_set;
  options.samples_per_iteration = samples;
  return options;
}

}  // namespace

PathMode::PathMode(const ModeContext& context, const PathSet& path_set, uint32_t samples)
    : integrator_(context.scheduler.device(), context.scheduler, context.scene, context.primary, context.frame,
                  integrator_options(path_set, samples), technique_name) {}

void PathMode::restart(const Frame& frame, uint64_t seed) {
  integrator_.set_frame(frame);
  integrator_.reset(seed);
}

size_t PathMode::estimate_bytes(uint32_t width, uint32_t height, uint32_t samples, bool ray_ends) {
  return PathIntegrator::estimate_bytes(width, height, integrator_options({}, samples), ray_ends);
}

}  // namespace lucarium::abuffer
