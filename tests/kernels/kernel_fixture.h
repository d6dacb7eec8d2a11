// SPDX-License-Identifier: Apache-2.0
// Programs of this folder, which include the device library.
#pragma once
#include <map>
#include <string>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/device/scene_buffers.h"

const lucarium::EmbeddedSources& test_kernels_kernels();

namespace lucarium::test {

/// NAME.cl beside this file, compiled with extra definitions.
inline Program kernel_program(const std::string& name, const std::map<std::string, std::string>& defines = {}) {
  SourceLibrary library;
  library.add(test_kernels_kernels());
  ProgramSpec spec;
  spec.name = "test_kernels/" + name;
  spec.files = {"test_kernels/" + name + ".cl"};
  spec.defines = defines;
  return Program(*test_device(), library, spec);
}

}  // namespace lucarium::test
