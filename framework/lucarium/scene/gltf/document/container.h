// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string_view>

#include "lucarium/scene/gltf/document/context.h"

namespace lucarium::gltf {

/// The parts of a .gltf or .glb file, as views of its bytes.
struct Container {
  std::string_view json;
  std::optional<std::string_view> binary_chunk;  ///< of a GLB; may be empty
};

/// Splits a file by its content (glTF 2.0, section 4.4), whatever its name says. Refuses glTF 1.0 containers, damaged
/// headers and chunks that reach beyond the file.
Container split_container(std::string_view bytes, ImportContext& context);

}  // namespace lucarium::gltf
