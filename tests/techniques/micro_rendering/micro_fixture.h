// SPDX-License-Identifier: Apache-2.0
// Programs of these tests, with the technique's kernels.
#pragma once
#include <map>
#include <string>
#include <utility>

#include "device_fixture.h"

const lucarium::EmbeddedSources& test_micro_rendering_kernels();  // of these tests
const lucarium::EmbeddedSources& micro_rendering_kernels();       // of the technique

namespace lucarium::test {

using Defines = std::map<std::string, std::string>;

/// The file of that virtual name ("test_micro_rendering/tree/node.cl"), compiled once per process.
inline const Program& micro_program(const std::string& file, const Defines& defines = {}) {
  static std::map<std::pair<std::string, Defines>, Program> programs;
  auto [at, added] = programs.try_emplace({file, defines});
  if (added) {
    SourceLibrary library;
    library.add(micro_rendering_kernels());
    library.add(test_micro_rendering_kernels());
    at->second = Program(*test_device(), library, {file, {file}, defines});
  }
  return at->second;
}

}  // namespace lucarium::test
