// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

/// What the process says when a signal ends it at once.
inline constexpr char interrupt_message[] = "lucarium: error: interrupted; nothing was kept\n";

/// For the first moment of a program: SIGINT, SIGTERM and SIGHUP end the process with one line of error and the exit
/// code of `interrupted`. While there is nothing to keep they do so at once, whatever the process is at: kernels that
/// compile, images that are decoded. While a KeepOnInterrupt lives they set a flag instead, and a second one ends the
/// process. A SIGHUP that was ignored at the start (nohup) stays ignored.
void install_interrupt_handler();

/// Whether the user asked to stop. Long loops keep what they have and return.
bool interrupt_requested();

/// Throws Error{interrupted} if so: "WHAT: interrupted". For long work on the host that leaves nothing to keep.
void throw_if_interrupted(const char* what);

/// Sets or clears the flag by hand (tests, embedding programs).
void set_interrupt_requested(bool requested);

/// While one lives there is something to keep: signals set the flag alone, and whoever made this asks for it. OpenCL
/// work in flight cannot be stopped, so loops ask between passes.
class KeepOnInterrupt {
 public:
  KeepOnInterrupt();
  ~KeepOnInterrupt();
  KeepOnInterrupt(const KeepOnInterrupt&) = delete;
  KeepOnInterrupt& operator=(const KeepOnInterrupt&) = delete;
};

/// While one lives a signal waits, for a moment only: a file that is half written is finished first. Then the process
/// ends, unless there is something to keep.
class DelayInterrupt {
 public:
  DelayInterrupt();
  ~DelayInterrupt();
  DelayInterrupt(const DelayInterrupt&) = delete;
  DelayInterrupt& operator=(const DelayInterrupt&) = delete;
};

}  // namespace lucarium
