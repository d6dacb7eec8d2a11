// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/interrupt.h"

#include <unistd.h>

#include <csignal>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

constexpr char kNothingKept[] =
    "lucarium: error: interrupted before the first iteration was done; nothing was written\n";
constexpr char kClearLine[] = "\r\x1b[2K";  // a progress bar may stand there

volatile std::sig_atomic_t requested = 0, nothing_to_keep = 0, on_terminal = 0;

void on_signal(int number) {
  requested = 1;
  if (nothing_to_keep) {
    [[maybe_unused]] ssize_t written = on_terminal ? ::write(STDERR_FILENO, kClearLine, sizeof kClearLine - 1) : 0;
    written = ::write(STDERR_FILENO, kNothingKept, sizeof kNothingKept - 1);
    ::_exit(static_cast<int>(ErrorClass::interrupted));
  }
  std::signal(number, SIG_DFL);  // the second one ends the process
}

}  // namespace

void install_interrupt_handler() {
  on_terminal = ::isatty(STDERR_FILENO);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupt_requested() { return requested != 0; }
void set_interrupt_requested(bool value) { requested = value ? 1 : 0; }

void throw_if_interrupted(const char* what) {
  if (interrupt_requested()) throw_error(ErrorClass::interrupted, "{}: interrupted", what);
}

EndOnInterrupt::EndOnInterrupt() {
  nothing_to_keep = 1;
  if (!interrupt_requested()) return;
  nothing_to_keep = 0;
  throw_if_interrupted("start");
}

EndOnInterrupt::~EndOnInterrupt() { nothing_to_keep = 0; }

}  // namespace lucarium
