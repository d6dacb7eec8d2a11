// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/compare/results/error_curve.h"
#include "lucarium/job/job.h"

namespace lucarium {

/// A rendering within the budget, with the error curve that belongs to it.
RenderWork work_within(const ComparisonBudget& budget);

/// File name of a piece below the result folder, without extension: "pieces/scene1-variant2-budget1-seed3".
std::string piece_stem(size_t scene, size_t variant, size_t budget, uint32_t seed);

/// File name of the mean image over the seeds of a piece.
std::string mean_file(const PieceResult& piece);

/// Fills everything that the summary of `lucarium render --json` in piece.render_summary says. Throws Error{input} when
/// it is not one.
void read_summary(PieceResult& piece, const ComparisonBudget& budget);

/// relMSE over seconds of preparing and iterating; the same over processor seconds, empty where they are not known.
std::vector<CurvePoint> curve_of(const PieceResult& piece);
std::vector<CurvePoint> processor_curve_of(const PieceResult& piece);

}  // namespace lucarium
