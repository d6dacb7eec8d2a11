// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "lucarium/scene/import_options.h"

namespace lucarium {

/// Reads .gltf or .glb. Loads completely or throws Error{input} with one line: file, what, where.
Scene import_gltf(const std::filesystem::path& file, const ImportOptions& options = {});
/// The same from memory (fuzzing, embedded files); external URIs are resolved against `folder`.
Scene import_gltf_bytes(std::string_view bytes, const std::filesystem::path& folder, const std::string& shown_name,
                        const ImportOptions& options = {});

}  // namespace lucarium
