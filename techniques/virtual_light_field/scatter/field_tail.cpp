// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/scatter/field_tail.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lucarium::vlf {
namespace {

constexpr double kLargest = 0.999;  // λ above it has no tail worth adding

}  // namespace

FieldTail find_tail(const Norms& norms) {
  FieldTail result;
  double error = 0, missing = 0;
  const auto channel = [](const float4& v, int c) { return static_cast<double>(c == 0 ? v.x : c == 1 ? v.y : v.z); };
  float* const lambdas[3] = {&result.lambda.x, &result.lambda.y, &result.lambda.z};
  float* const factors[3] = {&result.factor.x, &result.factor.y, &result.factor.z};
  const double total = static_cast<double>(norms[0].w);
  bool diverges = false;
  for (int c = 0; c < 3; ++c) {
    const double now = channel(norms[0], c), before = channel(norms[1], c);
    if (!(now > 0)) continue;
    const double lambda = before > 0 ? now / before : std::numeric_limits<double>::infinity();
    if (!(lambda < kLargest)) {
      diverges = true;
      continue;
    }
    *lambdas[c] = static_cast<float>(lambda);
    const double factor = lambda / (1 - lambda);
    *factors[c] = static_cast<float>(factor);
    const double aa = channel(norms[2], c), ab = channel(norms[3], c), bb = channel(norms[4], c);
    const double rest = std::max(0., aa - 2 * lambda * ab + lambda * lambda * bb);
    error += rest * (factor / (1 - lambda)) * (factor / (1 - lambda));
    missing += aa * factor * factor;
  }
  if (diverges) {
    result.error = result.without = std::numeric_limits<double>::infinity();
    return result;
  }
  result.error = total > 0 ? std::sqrt(error / total) : 0;
  result.without = total > 0 ? std::sqrt(missing / total) : 0;
  return result;
}

}  // namespace lucarium::vlf
