// SPDX-License-Identifier: Apache-2.0
// Pages about the command line, made from its declarations.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "manual/declarations.h"

namespace lucarium::app {

/// The manual page lucarium(1), or that of a command, lucarium-render(1), as roff with the macros of man(7).
std::string man_page(const ProgramDeclaration& program);
std::string man_page(const ProgramDeclaration& program, const CommandDeclaration& command);

/// "lucarium-render" for "render".
std::string man_page_name(const CommandDeclaration& command);

/// docs/command_line.md: every command with its options, and which option belongs to which command.
std::string markdown_page(const ProgramDeclaration& program);

/// All declarations as JSON (schema lucarium-commands-1).
nlohmann::ordered_json declarations_json(const ProgramDeclaration& program);

}  // namespace lucarium::app
