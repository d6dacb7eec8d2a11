// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium::abuffer {

/// Of the technique, and of the owner of its memory and schedules.
inline constexpr const char* technique_name = "voxel_abuffer";

}  // namespace lucarium::abuffer
