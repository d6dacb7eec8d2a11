// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

/// Y of linear Rec.709 (ITU-R BT.709-6); as luminance() in kernels/lucarium/math.clh.
template <class T>
constexpr T luminance(T r, T g, T b) {
  return T(0.2126) * r + T(0.7152) * g + T(0.0722) * b;
}

}  // namespace lucarium
