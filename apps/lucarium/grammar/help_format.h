// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace lucarium::app {

/// --help: usage, words by their place, options by group on lines of at most 120 columns with their defaults, examples.
std::shared_ptr<CLI::FormatterBase> make_help_format();

/// What a program without any word prints: usage, and the commands with a line each.
std::string short_help(const CLI::App& program);

}  // namespace lucarium::app
