// SPDX-License-Identifier: Apache-2.0
// Programs of this folder, with the technique's kernels.
#pragma once
#include <map>
#include <string>

#include "device_fixture.h"

const lucarium::EmbeddedSources& test_micro_rendering_kernels();  // of this folder
const lucarium::EmbeddedSources& micro_rendering_kernels();       // of the technique

namespace lucarium::test {

/// The file of that virtual name ("test_micro_rendering/node.cl"), compiled.
inline Program micro_program(const std::string& file, const std::map<std::string, std::string>& defines = {}) {
  SourceLibrary library;
  library.add(micro_rendering_kernels());
  library.add(test_micro_rendering_kernels());
  return Program(*test_device(), library, {file, {file}, defines});
}

}  // namespace lucarium::test
