// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <string_view>

namespace lucarium {

/// OpenCL sources by virtual name ("lucarium/bsdf.clh"), generated at build time by lucarium_embed_kernels().
using EmbeddedSources = std::map<std::string, std::string_view, std::less<>>;

}  // namespace lucarium
