// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "commands/commands.h"
#include "grammar/command_line.h"

namespace lucarium::app {

/// The whole command line, every command with its options; runs nothing. parse() sets `action`, which must outlive it,
/// to what the chosen command does.
CommandLine build_app(Action& action);

}  // namespace lucarium::app
