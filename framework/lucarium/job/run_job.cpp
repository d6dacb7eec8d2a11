// SPDX-License-Identifier: Apache-2.0
#include "lucarium/job/run_job.h"

#include "lucarium/base/json.h"
#include "lucarium/job/job_file.h"

namespace lucarium {

ChildResult run_job(std::vector<std::string> program, const Job& job,
                    const std::function<void(std::string_view)>& on_error_line,
                    const std::function<bool()>& stop_requested) {
  program.insert(program.end(), {job_command, "/dev/stdin"});
  return run_child(program, on_error_line, job_json(job), stop_requested);
}

nlohmann::json frame_of(const ChildResult& rendering) {
  return nlohmann::json::parse(rendering.out).at("frames").at(0);
}

}  // namespace lucarium
