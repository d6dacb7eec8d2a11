// SPDX-License-Identifier: Apache-2.0
// The executable: it links nothing but the C library, so that signals are handled within its first millisecond, and
// then loads the program with its libraries, which takes up to half a second where the machine is busy.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"

namespace {

using lucarium::ErrorClass;

/// As long as nothing is loaded there is nothing to keep.
void end_at_once(int) {
  [[maybe_unused]] const ssize_t written =
      ::write(STDERR_FILENO, lucarium::interrupt_message, sizeof lucarium::interrupt_message - 1);
  ::_exit(static_cast<int>(ErrorClass::interrupted));
}

/// As install_interrupt_handler(), which takes over; before main(), and before the constructors of any library.
void handle_signals(int, char**, char**) {
  std::signal(SIGINT, end_at_once);
  std::signal(SIGTERM, end_at_once);
  if (std::signal(SIGHUP, end_at_once) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const run_first)(int, char**, char**) = handle_signals;

int fail(const char* what) {
  std::fprintf(stderr, "lucarium: error: %s; install the program again\n", what);
  return static_cast<int>(ErrorClass::internal);
}

/// A closed standard stream would be the number of the next file that is opened, and results would be written into it.
/// In its place stands a file that nothing can be written to.
void fill_closed_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDONLY) != stream) std::_Exit(fail("no /dev/null"));
  }
}

}  // namespace

int main(int argc, char** argv) {
  fill_closed_streams();
  char path[PATH_MAX + sizeof LUCARIUM_PROGRAM_LIBRARY] = {};  // of this executable, then of the program
  if (::readlink("/proc/self/exe", path, PATH_MAX) <= 0) return fail("/proc/self/exe cannot be read");
  std::strcpy(std::strrchr(path, '/') + 1, LUCARIUM_PROGRAM_LIBRARY);
  // As for libraries that an executable names: bound when first called, and one for all plug-ins.
  void* program = ::dlopen(path, RTLD_LAZY | RTLD_GLOBAL);
  if (program == nullptr) return fail(::dlerror());
  void* const found = ::dlsym(program, "lucarium_main");
  if (found == nullptr) return fail(::dlerror());
  return reinterpret_cast<int (*)(int, char**)>(found)(argc, argv);
}
