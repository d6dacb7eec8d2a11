// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "lucarium/scene/gltf/document/context.h"

namespace lucarium::gltf {

using Bytes = std::vector<uint8_t>;

/// The bytes behind a buffer's or image's URI: a base64 or percent-encoded data URI, or a file inside `folder`, named
/// by a relative path that may be percent-encoded and hold spaces. Other schemes, absolute paths and paths that leave
/// the folder are refused: a scene must not read what its user did not put beside it. Reads at most `limit` bytes.
/// `where` names the owner in messages ("/buffers/0").
Bytes read_uri(const std::string& uri, const std::filesystem::path& folder, uint64_t limit, const std::string& where,
               const ImportContext& context);

/// "data:image/png;base64,iVBO…" shortened for messages.
std::string shown_uri(const std::string& uri);

/// Contents of a regular file, at most `limit` bytes.
Bytes read_file(const std::filesystem::path& file, uint64_t limit, const std::string& where,
                const ImportContext& context);

}  // namespace lucarium::gltf
