// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <string>

#include "lucarium/compare/execute/piece_executor.h"
#include "lucarium/compare/reference/reference_render.h"

namespace lucarium {

/// What extend_shared_reference() reports.
struct SharedReferenceEvents {
  std::function<void(ReferenceImage& image, const Film& round, double seconds)> keep;  ///< after every round
  std::function<void(const ReferenceProgress&)> progress;
  std::function<void(const std::string& line)> say;
};

/// Adds rounds to `image` as extend_reference() does, to the same bits, with rounds that an executor renders. `job`:
/// scene, image and device, with a ReferenceWork that says the path set. `folder`: of the rounds' files while they are
/// not in the image; made and removed. Returns false when interrupted: rounds that ended before one ahead of them then
/// stay there, for the next start. Throws Error{usage} for a goal of seconds:
/// rounds that are shared out have no clock in common; and the error of a round that failed.
bool extend_shared_reference(PieceExecutor& executor, const Job& job, ReferenceImage& image, const ReferenceGoal& goal,
                             const std::filesystem::path& folder, const SharedReferenceEvents& events);

}  // namespace lucarium
