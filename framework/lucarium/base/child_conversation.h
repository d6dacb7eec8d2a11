// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "lucarium/base/spawned_process.h"

namespace lucarium {

/// A child process that answers lines with lines, through its standard input and output; what it says on standard
/// error is dropped. The child is killed when the conversation goes.
class ChildConversation {
 public:
  /// The child holds the descriptor `held` while it lives (-1: none). Throws Error{input} when the program cannot be
  /// started.
  explicit ChildConversation(std::vector<std::string> arguments, int held = -1);

  /// Sends one line and waits for the line that answers it, without its end. False when the child is gone.
  bool ask(const std::string& line, std::string& answer);
  /// Ends the child: ask() returns false in whichever thread it waits.
  void kill() const;

 private:
  /// One end of a pair of sockets: writing to a child that is gone raises no signal, as it would with a pipe.
  struct Socket {
    int descriptor = -1;
    ~Socket();
  };
  Socket own_;
  SpawnedProcess child_;
  std::string received_;  // behind the last answer
};

}  // namespace lucarium
