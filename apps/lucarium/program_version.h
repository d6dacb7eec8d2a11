// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium::app {

/// The version with the commit that was built, for people (cmake/LucariumVersion.cmake). Results and caches go by
/// LUCARIUM_VERSION, which stays from release to release.
const char* program_version();

}  // namespace lucarium::app
