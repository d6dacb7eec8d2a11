// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr char kClearLine[] = "\r\x1b[2K";  // a progress bar may stand there

std::atomic<bool> requested{false}, signalled{false}, ended{false}, on_terminal{false};
std::atomic<int> keepers{0}, delays{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free, "used by a handler");

/// Ends the process unless something is kept or half written. Calls only what a signal handler may call.
void end_if_free() {
  if (keepers != 0 || delays != 0 || ended.exchange(true)) return;
  [[maybe_unused]] ssize_t written = on_terminal ? ::write(STDERR_FILENO, kClearLine, sizeof kClearLine - 1) : 0;
  written = ::write(STDERR_FILENO, interrupt_message, sizeof interrupt_message - 1);
  ::_exit(static_cast<int>(ErrorClass::interrupted));
}

void on_signal(int number) {
  requested = true;
  signalled = true;  // before the counters are read: whoever lowers one of them reads this afterwards
  end_if_free();
  std::signal(number, SIG_DFL);  // the second one ends the process
}

}  // namespace

void install_interrupt_handler() {
  on_terminal = ::isatty(STDERR_FILENO) != 0;
  // Shells start commands in the background with SIGINT ignored; who sends it to one of them means it.
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool interrupt_requested() { return requested; }
void set_interrupt_requested(bool value) { requested = value; }

void throw_if_interrupted(const char* what) {
  if (interrupt_requested()) throw_error(ErrorClass::interrupted, "{}: interrupted", what);
}

KeepOnInterrupt::KeepOnInterrupt() { ++keepers; }
KeepOnInterrupt::~KeepOnInterrupt() { --keepers; }

DelayInterrupt::DelayInterrupt() { ++delays; }
DelayInterrupt::~DelayInterrupt() {
  --delays;
  if (signalled) end_if_free();
}

}  // namespace lucarium
