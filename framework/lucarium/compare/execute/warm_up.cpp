// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/warm_up.h"

#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/hash.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/compare/results/machine.h"
#include "lucarium/job/job_file.h"
#include "lucarium/job/run_job.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr uint64_t warm_iterations = 64;  // at most: until the technique knows how much work there is
constexpr uint64_t warm_samples = 16;     // of a round of a reference

}  // namespace

std::string warm_up_text(const Job& job, const fs::path& folder) {
  Job warm = job;
  warm.seed = 1;
  warm.verbose = false;
  if (auto* render = std::get_if<RenderWork>(&warm.work)) {
    render->iterations = warm_iterations;
    render->work_iterations = 1;
    render->samples = 0;
    render->relmse = 0;
    render->reference.clear();
    render->curve = false;
    render->output.clear();
    render->walk = {};
    return job_json(warm);
  }
  auto& reference = std::get<ReferenceWork>(warm.work);
  reference.samples = 0;
  reference.relmse = 0;
  reference.round_samples = warm_samples;
  reference.output.clear();
  reference.output = folder / (Hasher().add(job_json(warm)).finish().hex() + ".exr");
  return job_json(warm);
}

void warm_up(const fs::path& program, const std::string& job, const fs::path& folder) {
  const std::string cpu = describe_machine().cpu;
  const std::string key = Hasher().add(cpu).add(job).finish().hex();
  const fs::path done = folder / (key + ".done");
  if (fs::exists(done)) return;
  fs::create_directories(folder);
  const FileLock lock(folder / (key + ".lock"), [] {});
  if (fs::exists(done)) return;
  const ChildResult child = run_child({program.string(), job_command, "/dev/stdin"}, {}, job);
  if (interrupt_requested()) return;
  write_file_atomically(done, fmt::format("{}, {}\n", cpu, describe_end(child)));
}

}  // namespace lucarium
