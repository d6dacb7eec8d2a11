// SPDX-License-Identifier: Apache-2.0
// lucarium job FILE: what comparisons and the conformance kit start for each of their renderings; lucarium array-task:
// what an array of Slurm starts for each of its tasks. Declared in commands.h.
#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/compare/execute/array_task.h"
#include "lucarium/job/job_file.h"
#include "lucarium/job/run_job.h"

namespace lucarium::app {
namespace {

int perform(const std::filesystem::path& file) {
  const Job job = read_job(file);
  if (const auto* work = std::get_if<RenderWork>(&job.work)) return render(job, *work);
  return reference(job, std::get<ReferenceWork>(job.work));
}

}  // namespace

void add_job_command(Command program, Action& action) {
  auto file = std::make_shared<std::filesystem::path>();
  Command command = program.add_subcommand(job_command, "perform the rendering that a job file describes; prints JSON");
  command.option("file", *file).required();
  command.hide();
  command.callback([file, &action] { action = [file](const Messages&) { return perform(*file); }; });
}

void add_array_task_command(Command program, Action& action) {
  auto folder = std::make_shared<std::filesystem::path>();
  auto index = std::make_shared<uint64_t>(0);
  Command command = program.add_subcommand(array_task_command, "perform one task of an array in its folder");
  command.option("batch", *folder).required();
  command.option("index", *index).required();
  command.hide();
  command.callback([folder, index, &action] {
    action = [folder, index](const Messages&) {
      const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
      return run_array_task(program, *folder, *index) ? 0 : static_cast<int>(ErrorClass::interrupted);
    };
  });
}

}  // namespace lucarium::app
