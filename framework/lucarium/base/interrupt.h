// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

/// Makes SIGINT and SIGTERM set a flag instead of ending the process; a second SIGINT ends it at once.
/// The handler does nothing else: OpenCL work in flight cannot be stopped, so loops ask between passes.
void install_interrupt_handler();

/// Whether the user asked to stop. Long loops keep what they have and return.
bool interrupt_requested();

/// Throws Error{interrupted} if so: "WHAT: interrupted". For long work on the host that leaves nothing to keep.
void throw_if_interrupted(const char* what);

/// Sets or clears the flag by hand (tests, embedding programs).
void set_interrupt_requested(bool requested);

/// While one lives there is nothing to keep: SIGINT and SIGTERM, where install_interrupt_handler() was called, end the
/// process at once, with one line of error and the exit code of `interrupted`. So work that cannot be stopped, such as
/// the compilation of kernels, can be left all the same. Not nested. Throws where the flag is set already.
class EndOnInterrupt {
 public:
  EndOnInterrupt();
  ~EndOnInterrupt();
  EndOnInterrupt(const EndOnInterrupt&) = delete;
  EndOnInterrupt& operator=(const EndOnInterrupt&) = delete;
};

}  // namespace lucarium
