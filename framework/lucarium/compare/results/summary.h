// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <vector>

#include "lucarium/compare/results/comparison_result.h"

namespace lucarium {

/// Finished pieces of a key in order of their seeds.
std::vector<const PieceResult*> pieces_of(const ComparisonResult& result, const SummaryKey& key);

/// Everything but bias and times; `reference` is the one the pieces were measured against.
Summary summarize(const std::vector<const PieceResult*>& pieces, const ReferenceResult& reference,
                  const ComparisonBudget& budget);

/// Bias of the pieces' images, read from `folder`; also writes the mean image, "means/….exr", there.
BiasAndVariance measure_bias(const std::vector<const PieceResult*>& pieces, const ReferenceResult& reference,
                             const std::filesystem::path& folder);

/// Marks the scene if its pieces ran on several kinds of machine (processor, cores, device, driver), where no
/// time may be ranked, and returns whether they did.
bool mark_unlike_machines(ComparisonResult& result, size_t scene);

/// Errors (1 and 3 times powers of ten, at most six, the smallest first) that some curve of a scene and budget passes,
/// and when each variant's curves get there: in seconds, but not in a scene of unlike machines, and in processor
/// seconds where they are known.
void add_times_to_error(const ComparisonResult& result, size_t scene, size_t budget,
                        std::map<SummaryKey, Summary>& summaries);

/// Not of budgets of time in scenes of unlike machines: such pairs would compare the machines.
std::vector<SummaryPair> make_pairs(const ComparisonResult& result);

}  // namespace lucarium
