// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdlib>
#include <string>

#include "test_support.h"

namespace lucarium::test {

/// What PoCL calls two devices of one processor, in the variable POCL_DEVICES.
inline constexpr const char* two_devices_of_pocl = "pthread pthread";

/// Whether programs then see two devices: other drivers (tools/test --driver) lend one. Tests that need two call
/// `if (!lends_two_devices()) return skip("PoCL, which lends two devices");`.
inline bool lends_two_devices() {
  static const bool two =
      run_program(std::string("POCL_DEVICES='") + two_devices_of_pocl + "' " + lucarium_program() + " devices")
          .out.find("\n1  ") != std::string::npos;
  return two;
}

}  // namespace lucarium::test
