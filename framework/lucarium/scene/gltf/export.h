// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "lucarium/scene/scene.h"

namespace lucarium {

/// The files that `export_gltf` would write: the .glb, FILE.lucarium.json beside it with the exposure and the
/// environment, for which glTF has no place, and FILE.environment.exr where that is a picture.
std::vector<std::filesystem::path> exported_files(const Scene& scene, const std::filesystem::path& file);

/// Writes the scene as it stands at its evaluated time, overrides and poses included, as one self-contained binary
/// glTF 2.0 file; loading it gives the same triangles, materials, lights and cameras (colours that glTF keeps as two
/// factors may differ in the last bit). Animations and skins are left behind. Throws Error{input} where a file cannot
/// be written or would be larger than the 4 GiB of a .glb.
void export_gltf(const Scene& scene, const std::filesystem::path& file);

}  // namespace lucarium
