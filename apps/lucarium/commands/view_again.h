// SPDX-License-Identifier: Apache-2.0
// `lucarium view --watch` starts itself again when an input has changed: plug-ins and kernels are then loaded afresh.
#pragma once
#include <optional>
#include <string>

#include "lucarium/view/hub.h"
#include "lucarium/view/server.h"

namespace lucarium::app {

/// What outlives the program: where it serves, and what pages want.
struct ViewState {
  int port = 0;
  std::string token;
  ViewRequest request;
};

/// In a program that start_again() has started: what the one before left. The variable is gone then.
std::optional<ViewState> state_of_earlier_view();

/// Replaces this program by a new one with the command line `words` (own_command_line()). Throws Error{internal} if
/// that fails.
[[noreturn]] void start_again(std::vector<std::string> words, const ViewState& state);

}  // namespace lucarium::app
