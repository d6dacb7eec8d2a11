// SPDX-License-Identifier: Apache-2.0
// lucarium job FILE: what comparisons and the conformance kit start for each of their renderings. Declared in
// commands.h.
#include "commands/commands.h"
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

}  // namespace lucarium::app
