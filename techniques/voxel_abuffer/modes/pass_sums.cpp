// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/modes/pass_sums.h"

#include "lucarium/compute/device/remedies.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

PassSums::PassSums(KernelScheduler& scheduler, size_t pixels, const std::vector<std::string>& layers, uint32_t samples)
    : scheduler_(&scheduler), names_(layers), sums_(scheduler.device(), technique_name, pixels, layers) {
  const Program program = make_program(scheduler.device(), voxel_abuffer_kernels(), {"voxel_abuffer/modes/add_pass"});
  ScheduleRecorder begin = scheduler.record("begin pass", technique_name),
                   commit = scheduler.record("add pass", technique_name);
  for (const std::string& name : names_) {
    pass_.emplace_back(scheduler.device(), technique_name, "pass of " + name, pixels, remedies::lower_size);
    begin.fill_zero("clear pass of " + name, pass_.back());
    commit.pass("add pass of " + name, program, "add_pass")
        .global(pixels)
        .arg("pixels", static_cast<uint32_t>(pixels))
        .arg("samples", samples)
        .arg("pass", pass_.back())
        .arg("sums", sums_[name]);
  }
  begin_ = begin.compile();
  commit_ = commit.compile();
}

bool PassSums::begin() { return scheduler_->run(begin_) == RunResult::done; }

void PassSums::commit() { scheduler_->run_to_end(commit_); }

void PassSums::clear() {
  scheduler_->finish();
  sums_.clear();
}

void PassSums::warm_up() {
  scheduler_->warm_up(begin_);
  scheduler_->warm_up(commit_);
}

}  // namespace lucarium::abuffer
