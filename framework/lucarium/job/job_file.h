// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "lucarium/job/job.h"

namespace lucarium {

/// The job as JSON (schema lucarium-job-1); read_job() is its inverse. Every key is written. Throws Error{usage} for
/// names that are not UTF-8.
std::string job_json(const Job& job);

/// Throws Error{input} that names file, line and key for whatever job_json() would not write: unknown, missing and
/// doubled keys, values of another type or out of range.
Job read_job(const std::filesystem::path& file);

}  // namespace lucarium
