// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

#include "virtual_light_field/shared/field.h"

namespace lucarium::vlf {

/// Sums of norms.clh, over texel sides and cells.
using Norms = std::array<float4, FIELD_NORMS>;

/// What is known of the series of bounces after a sweep. Sweep after sweep the field a^(s) that is sent shrinks, in the
/// end by the same factor λ each time: the largest eigenvalue of transport and scattering. What is still missing is
/// then
///
///   Σ_{k ≥ 1} λ^k a = λ / (1 - λ) a,       error ≤ λ ‖a - λ b‖ / ((1 - λ)² ‖T‖),
///
/// a what is sent now, b before, T all that was. Per channel λ is the ratio of the powers.
struct FieldTail {
  float4 lambda{}, factor{};  ///< per channel; λ / (1 - λ), 0 where nothing is sent
  double error = 0;           ///< bound of the relative error with the tail; infinity where λ is not below 1
  double without = 0;         ///< the same where no tail is added: ‖λ / (1 - λ) a‖ / ‖T‖
};
FieldTail find_tail(const Norms& norms);

}  // namespace lucarium::vlf
