// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "lucarium/compare/comparison.h"
#include "lucarium/film/film.h"

namespace lucarium {

/// Everything a rendered reference depends on; its hash is its name in the cache.
struct ReferenceKey {
  std::string scene_hash, camera, path_set;
  std::string renderer;  ///< identity of the kernels, the plug-in and its settings
  uint32_t width = 0, height = 0, pixel_sampling = 0, samples = 0;
  std::string file_name() const;  ///< "<hash>.exr"
};

/// Text of everything in a camera that changes an image.
std::string describe_camera(const SceneCamera& camera);

/// Error of a reference estimated from the spread of its independent replicates (layer "Variance", variance of the
/// mean per channel): MSE = ⟨var⟩, relMSE = ⟨var / (r² + 0.01 Ȳ²)⟩. Leaves `error_known` false without that layer.
void estimate_reference_error(const Film& reference, ReferenceResult& result);

}  // namespace lucarium
