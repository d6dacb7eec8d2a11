// SPDX-License-Identifier: Apache-2.0
// Ctrl-C, SIGTERM and SIGHUP in every command, from its first moment. That a rendering keeps what it has is the subject
// of render_test, and what signals do in general that of base/interrupt_test.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

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

/// Whether the process, once it is the program, catches the signal; empty when it has ended. Before that it is a copy
/// of this test, which catches signals of its own, and a shell.
std::optional<bool> catches(pid_t process, int signal) {
  std::error_code gone;
  const bool is_program = fs::read_symlink("/proc/" + std::to_string(process) + "/exe", gone).filename() == "lucarium";
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("State:") && line.find("Z") != std::string::npos) return std::nullopt;
    if (line.starts_with("SigCgt:"))
      return is_program && (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
  }
  return std::nullopt;
}

/// Runs the program and sends the signal as soon as it is caught, which is before main() begins.
Outcome run_and_signal(const std::string& arguments, int signal) {
  const TemporaryFolder folder;
  const fs::path err = folder.path() / "err";
  const std::string line = "exec " + lucarium_program() + " " + arguments + " >/dev/null 2>" + err.string();
  const pid_t process = ::fork();
  REQUIRE(process >= 0);
  if (process == 0) {
    ::execl("/bin/sh", "sh", "-c", line.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  std::optional<bool> caught = false;
  wait_until([&] {
    for (int i = 0; i < 1000 && (caught = catches(process, signal)) == false; ++i) ::usleep(100);
    return caught != false;
  });
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
