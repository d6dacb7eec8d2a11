// SPDX-License-Identifier: Apache-2.0
// What to do when memory does not suffice, in the words that complete the refusal (buffer.h).
#pragma once

namespace lucarium::remedies {

inline constexpr const char* lower_size = "lower --size";
inline constexpr const char* lower_texels = "lower texels";  ///< the parameter of techniques with a surface atlas

}  // namespace lucarium::remedies
