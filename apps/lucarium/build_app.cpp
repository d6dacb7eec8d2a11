// SPDX-License-Identifier: Apache-2.0
#include "build_app.h"

#include "program_version.h"

namespace lucarium::app {

CommandLine build_app(Action& action) {
  CommandLine line("lucarium", "Compares global-illumination techniques on glTF scenes, on any OpenCL device.",
                   program_version());
  Command program = line.program();
  add_render_command(program, action);
  add_reference_command(program, action);
  add_compare_command(program, action);
  add_reproduce_command(program, action);
  add_report_command(program, action);
  add_diff_command(program, action);
  add_scene_command(program, action);
  add_view_command(program, action);
  add_state_command(program, action);
  add_techniques_command(program, action);
  add_devices_command(program, action);
  add_check_command(program, action);
  add_new_technique_command(program, action);
  add_manual_commands(program, action);
  add_job_command(program, action);
  add_array_task_command(program, action);
  program.examples({"lucarium render builtin:cornell -o cornell.png", "lucarium render --help"}, "docs/rendering.md");
  return line;
}

}  // namespace lucarium::app
