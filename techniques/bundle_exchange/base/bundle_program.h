// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "lucarium/compute/schedule/schedule.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"

namespace lucarium::bundle {

/// The program of everything but the exchange itself, whose kernels share exchange_layout.clh.
Program make_technique_program(Device& device, std::map<std::string, std::string> defines);

/// The program of one kernel file of the technique, FILE.cl.
Program make_bundle_program(Device& device, const std::string& file, std::map<std::string, std::string> defines);

/// A pass of a kernel that knows the scene and the atlas.
PassBuilder surface_pass(ScheduleRecorder& recorder, const std::string& name, const Program& program,
                         const std::string& kernel, const SceneBuffers& scene, const SurfaceAtlas& atlas);

}  // namespace lucarium::bundle
