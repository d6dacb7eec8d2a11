// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/child_process.h"
#include "lucarium/job/job.h"

namespace lucarium {

/// The command of the program that reads a job file and performs it, for this library alone: not in --help.
inline constexpr const char* job_command = "job";

/// Performs the job in a process of its own. `program`: the lucarium executable, and before it what runs it. The job is
/// its standard input, so that no file is left behind, however it ends. Lines of its standard error are handed to
/// `on_error_line` as they come. It is interrupted when `stop_requested` becomes true.
ChildResult run_job(std::vector<std::string> program, const Job& job,
                    const std::function<void(std::string_view)>& on_error_line = {},
                    const std::function<bool()>& stop_requested = {});

/// The one frame of what a rendering printed (schema lucarium-render-2, docs/results.md).
nlohmann::json frame_of(const ChildResult& rendering);

}  // namespace lucarium
