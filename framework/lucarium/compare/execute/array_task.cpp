// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/array_task.h"

#include <cstdio>
#include <cstdlib>

#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compare/execute/local_executor.h"
#include "lucarium/compare/execute/slurm_batch.h"
#include "lucarium/compare/execute/warm_up.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// Jobs of Slurm on this machine beside this one: each has a process "slurmstepd: [JOB.batch]".
unsigned count_other_jobs() {
  const std::string own = variable("SLURM_JOB_ID");
  unsigned others = 0;
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder("/proc", failure)) {
    const std::string number = entry.path().filename().string();
    if (number.find_first_not_of("0123456789") != std::string::npos) continue;
    std::string line;
    if (std::FILE* file = std::fopen((entry.path() / "cmdline").c_str(), "r")) {
      char bytes[256];
      line.assign(bytes, std::fread(bytes, 1, sizeof bytes, file));
      std::fclose(file);
    }
    constexpr std::string_view begin = "slurmstepd: [";
    if (!line.starts_with(begin)) continue;
    const std::string step = line.substr(begin.size(), line.find(']') - begin.size());
    others += step.ends_with(".batch") && step != own + ".batch";
  }
  return others;
}

}  // namespace

bool run_array_task(const fs::path& program, const fs::path& folder, size_t index) {
  const SlurmBatch batch(folder);
  const KeepOnInterrupt keep_what_has_ended;
  for (const BatchPiece& piece : batch.read(index)) {
    if (batch.has_ended(piece.name)) continue;
    print_note("{}\n", piece.name);
    warm_up(program, piece.warm_up, folder.parent_path() / warm_folder);
    if (interrupt_requested()) return false;
    const unsigned other_jobs = count_other_jobs();
    PieceEnd end = perform_job(program, piece.job, piece.lock, [](std::string_view line) { print_note("{}\n", line); });
    if (interrupt_requested()) return false;
    end.machine.other_jobs = other_jobs;
    batch.write_ended(piece.name, {end.child, end.machine, variable("SLURMD_NODENAME")});
  }
  return true;
}

}  // namespace lucarium
