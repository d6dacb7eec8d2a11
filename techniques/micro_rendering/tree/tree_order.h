// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "micro_rendering/points/point_sampling.h"

namespace lucarium::micro {

/// The order of 2^depth points in which they are the leaves of a complete binary tree
/// (Ritschel et al. 2009, section 2.1, figure 2): each inner node splits its points at the median of the longest axis.
/// Thin sheets are the exception: their sides, and parallel layers that hide each other, are separated first, so that
/// no node mixes visible with hidden light. Deterministic; `threads` of 2 and more halve the work.
std::vector<uint32_t> tree_order(std::span<const SampledPoint> points, int threads);

}  // namespace lucarium::micro
