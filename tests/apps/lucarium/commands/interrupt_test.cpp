// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, SIGTERM and SIGHUP in every command, from its first moment. That a rendering keeps what it has is the subject
// of render_test, and what signals do in general that of base/interrupt_test.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <optional>
#include <sstream>

#include "cli_support.h"

using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

constexpr int interrupted = 6, attempts = 10;

struct Outcome {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string err;
};

/// wait_until() that asks every 0.1 ms.
bool wait_closely(const std::function<bool()>& holds) {
  return wait_until([&] {
    for (int i = 0; i < 1000; ++i) {
      if (holds()) return true;
      ::usleep(100);
    }
    return false;
  });
}

/// Whether it is the program by now: first it is a copy of this test, which catches signals of its own, and a shell.
bool is_program(pid_t process) {
  std::error_code gone;
  return fs::read_symlink("/proc/" + std::to_string(process) + "/exe", gone).filename() == "lucarium";
}

/// Processor time of the process [s].
double processor_seconds(pid_t process) {
  double nanoseconds = 0;
  std::ifstream("/proc/" + std::to_string(process) + "/schedstat") >> nanoseconds;
  return nanoseconds * 1e-9;
}

/// Whether the process is the program and catches the signal; empty when it has ended.
std::optional<bool> catches(pid_t process, int signal) {
  const bool program = is_program(process);  // before its handlers are read
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("State:") && line.find("Z") != std::string::npos) return std::nullopt;
    if (line.starts_with("SigCgt:"))
      return program && (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
  }
  return std::nullopt;
}

/// Starts the program; its standard error goes to the file.
pid_t start(const std::string& arguments, const fs::path& err) {
  const std::string line = "exec " + lucarium_program() + " " + arguments + " >/dev/null 2>" + err.string();
  const pid_t process = ::fork();
  REQUIRE(process >= 0);
  if (process == 0) {
    ::execl("/bin/sh", "sh", "-c", line.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  return process;
}

/// Sends the signal and waits for the end.
Outcome end_with(pid_t process, int signal, const fs::path& err) {
  ::kill(process, signal);
  int status = 0;
  const bool ended = wait_until([&] { return ::waitpid(process, &status, WNOHANG) == process; });
  if (!ended) {
    ::kill(process, SIGKILL);
    ::waitpid(process, &status, 0);
  }
  std::ostringstream text;
  text << std::ifstream(err).rdbuf();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text.str()};
}

/// Runs the program and sends the signal as soon as it is caught, which is before main() begins.
Outcome run_and_signal(const std::string& arguments, int signal) {
  const TemporaryFolder folder;
  const fs::path err = folder.path() / "err";
  const pid_t process = start(arguments, err);
  std::optional<bool> caught = false;
  wait_closely([&] { return (caught = catches(process, signal)) != false; });
  return end_with(process, signal, err);
}

/// The command ends with the exit code and the line of an interrupt. One that was through before the signal came (its
/// own exit code) tries again.
void check_interrupted(const std::string& arguments, int signal, int undisturbed = 0) {
  CAPTURE(arguments);
  CAPTURE(signal);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const Outcome outcome = run_and_signal(arguments, signal);
    CAPTURE(outcome.err);
    if (outcome.exit_code == undisturbed) continue;
    CHECK(outcome.exit_code == interrupted);
    CHECK(outcome.err == "lucarium: error: interrupted; nothing was kept\n");
    return;
  }
  FAIL_CHECK("it was always done before the signal came");
}

}  // namespace

TEST_CASE("every command ends with exit code 6 and one line, from its first moment") {
  const TemporaryFolder folder;
  const std::string out = " -o " + (folder.path() / "out").string();
  for (const char* command : {"scene builtin:atrium", "devices", "techniques", "check path_tracing", "reproduce --list",
                              "render builtin:atrium --json"}) {
    check_interrupted(command, SIGINT);
  }
  check_interrupted("report " + folder.path().string(), SIGINT, 3);
  check_interrupted("diff a.exr b.exr", SIGINT, 3);
  check_interrupted("compare builtin:atrium -t path_tracing --iterations 1" + out, SIGINT);
  check_interrupted("reproduce none" + out, SIGINT, 2);
  check_interrupted("reference builtin:atrium" + out + ".exr", SIGINT);
  check_interrupted("new-technique path_tracing", SIGINT, 2);
  check_interrupted("scene builtin:atrium", SIGTERM);
  check_interrupted("scene builtin:atrium", SIGHUP);
}

TEST_CASE("a signal while the libraries were loaded ended the program by the signal, not with exit code 6") {
  // Loading 260 libraries takes 30 to 200 ms of a processor, the executable's own start 1 ms (with sanitizers 5).
  constexpr double start_seconds = 0.01;
  const int runs = full_run() ? 400 : 60;
  const TemporaryFolder folder;
  const fs::path err = folder.path() / "err";
  int too_late = 0;
  for (int run = 0; run < runs; ++run) {
    const int signal = std::array{SIGINT, SIGTERM, SIGHUP}[run % 3];
    const pid_t process = start("scene builtin:atrium", err);
    REQUIRE(wait_closely([&] { return is_program(process); }));
    const double before = processor_seconds(process);
    REQUIRE(wait_closely([&] { return processor_seconds(process) >= before + start_seconds; }));
    ::usleep(static_cast<useconds_t>(500'000.0 * (run / 3) * 3 / runs));
    const Outcome outcome = end_with(process, signal, err);
    CAPTURE(run);
    if (outcome.exit_code == 0) {
      ++too_late;
      continue;
    }
    CHECK(outcome.exit_code == interrupted);
    CHECK(outcome.err == "lucarium: error: interrupted; nothing was kept\n");
  }
  CHECK(too_late < runs);
}
