// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "grammar/command_line.h"
#include "lucarium/job/job.h"

namespace lucarium::app {

/// What the chosen command does; returns the exit code. Set while the command line is parsed, run afterwards.
using Action = std::function<int(const Messages&)>;

// Each adds its subcommand; build_app() calls them all.
void add_render_command(Command program, Action& action);
void add_reference_command(Command program, Action& action);
void add_compare_command(Command program, Action& action);
void add_reproduce_command(Command program, Action& action);
void add_report_command(Command program, Action& action);
void add_diff_command(Command program, Action& action);
void add_scene_command(Command program, Action& action);
void add_view_command(Command program, Action& action);
void add_state_command(Command program, Action& action);
void add_techniques_command(Command program, Action& action);
void add_devices_command(Command program, Action& action);
void add_check_command(Command program, Action& action);
void add_new_technique_command(Command program, Action& action);
void add_manual_commands(const Command& program, Action& action);  ///< help, commands, man, completion
void add_job_command(Command program, Action& action);
void add_array_task_command(Command program, Action& action);

// What the commands of these names do, with a job's settings instead of options. Each returns the exit code.
int render(const Job& job, const RenderWork& work);
int reference(const Job& job, const ReferenceWork& work);

}  // namespace lucarium::app
