// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace lucarium::app {

/// What an option or a word of the command line is called and does: the same in every command that takes it.
struct OptionText {
  const char* names;  ///< "-o,--output", or "scene" for a word by its place
  const char* group;  ///< heading in --help
  const char* value;  ///< what its value is called; empty: a flag
  const char* text;
  const char* words = "";  ///< values to choose from, "a|b"; others may be allowed, too
};

/// The entry that has `name` ("--output", "scene") among its names; a name without an entry is a fault of ours.
const OptionText& option_text(std::string_view name);

/// The values to choose from of `name`.
std::vector<std::string> option_words(std::string_view name);

/// Headings of --help in the order in which they stand there.
const std::vector<const char*>& option_groups();

}  // namespace lucarium::app
