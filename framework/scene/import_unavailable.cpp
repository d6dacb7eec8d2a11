// SPDX-License-Identifier: Apache-2.0
// Weak definitions that keep the library linkable until the importer is there; delete together with its landing.
#include "lucarium/base/error.h"
#include "lucarium/scene/load_scene.h"

namespace lucarium {

__attribute__((weak)) Scene import_gltf(const std::filesystem::path& file, const ImportOptions&) {
  throw_error(ErrorClass::input, "{}: glTF files cannot be read by this build", file.string());
}

__attribute__((weak)) Environment load_environment(const std::filesystem::path& file, const ImportOptions&) {
  throw_error(ErrorClass::input, "{}: environment maps cannot be read by this build", file.string());
}

}  // namespace lucarium
