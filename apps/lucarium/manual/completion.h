// SPDX-License-Identifier: Apache-2.0
// Completion scripts. They hold commands, options and words to choose from; what depends on plug-ins they ask of
// `lucarium complete KIND -- WORDS`, where WORDS are those behind the program's name, the one at the cursor last.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "manual/declarations.h"

namespace lucarium::app {

std::string bash_completion(const ProgramDeclaration& program);
std::string zsh_completion(const ProgramDeclaration& program);
std::string fish_completion(const ProgramDeclaration& program);

struct Candidate {
  std::string name, text;
};

/// What may stand at the cursor: "scene", "technique", "parameter" or "experiment" that begins with words.back(). Looks
/// for plug-ins where the words say it, too. A name that ends in ':' or '=' goes on.
std::vector<Candidate> complete(const std::string& kind, const std::vector<std::string>& words);

}  // namespace lucarium::app
