// SPDX-License-Identifier: Apache-2.0
// lucarium: the command-line program, as a library that start/ loads. All work is in the framework; this only reads
// arguments and prints.
#include "program.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "build_app.h"
#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"

namespace {

using namespace lucarium;

/// One line, whatever a library put into the message.
void print_error(std::string message, const std::string& details) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  print_note("lucarium: error: {}\n", printable_line(message));
  if (!details.empty() && log_level() >= LogLevel::info) print_note("{}\n", details);
}

/// Every frame that is shown takes memory for its images. The C library gives it back to the system and has it cleared
/// again, which takes longer than what is done with it: so much is kept instead, in images of 32 MiB at the most.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

int run(int argc, char** argv) {
  app::Action action;
  app::CommandLine line = app::build_app(action);
  if (const std::optional<int> done = line.parse(argc, argv)) return *done;
  line.messages().apply();
  return action(line.messages());
}

}  // namespace

int lucarium_main(int argc, char** argv) {
  install_interrupt_handler();  // instead of the one that stood until now
  end_with_parent();
  keep_freed_memory();
  try {
    const int code = run(argc, argv);
    flush_results();
    return code;
  } catch (const Error& error) {
    print_error(error.what(), error.details());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    print_error("the host's memory does not suffice; use a smaller scene, --size or --texture-size", "");
    return static_cast<int>(ErrorClass::device);
  } catch (const std::exception& error) {
    print_error(fmt::format("internal: {}; please report it", error.what()), "");
  } catch (...) {
    print_error("internal: something that is no exception was thrown; please report it", "");
  }
  return static_cast<int>(ErrorClass::internal);
}
