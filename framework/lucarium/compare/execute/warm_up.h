// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "lucarium/job/job.h"

namespace lucarium {

/// Name of the folder beside those of batches.
inline constexpr const char* warm_folder = "warm";

/// The shortest job, as JSON, that compiles what `job` needs: its first iterations, without an image that stays. Jobs
/// that differ in seed, reference, output or the length of their work have the same. `folder` is of the next function.
std::string warm_up_text(const Job& job, const std::filesystem::path& folder);

/// Sees to it that the kernels of jobs with this warm-up job (JSON) are in the cache before they begin, compiled once
/// per kind of machine and not by all tasks of an array at once: the first one does it under a lock in `folder`, the
/// others wait. What fails there is left for the job itself to report.
void warm_up(const std::filesystem::path& program, const std::string& job, const std::filesystem::path& folder);

}  // namespace lucarium
