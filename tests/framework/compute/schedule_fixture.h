// SPDX-License-Identifier: Apache-2.0
// What the scheduler's tests share.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "device_fixture.h"
#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"

const lucarium::EmbeddedSources& test_compute_kernels();

namespace lucarium::test {

using Uints = std::vector<uint32_t>;

/// tests/framework/compute/schedule/schedule_kernels.cl.
inline const Program& schedule_program() {
  static const Program program = [] {
    SourceLibrary library;
    library.add(test_compute_kernels());
    ProgramSpec spec;
    spec.name = "schedule_kernels";
    spec.files = {"test_compute/schedule/schedule_kernels.cl"};
    return Program(*test_device(), library, spec);
  }();
  return program;
}

inline TypedBuffer<uint32_t> make_buffer(const std::string& name, const Uints& values) {
  return TypedBuffer<uint32_t>(*test_device(), "test", name, values);
}

/// The message of the Error that `action` throws, or "nothing was thrown".
inline std::string error_message(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace lucarium::test
