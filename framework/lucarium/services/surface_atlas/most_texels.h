// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

constexpr int kMaxAtlasTexels = 1 << 24;  ///< that techniques ask for, and states may be of

}  // namespace lucarium
