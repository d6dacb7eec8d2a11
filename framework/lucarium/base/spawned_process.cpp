// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/spawned_process.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include "lucarium/base/error.h"

extern char** environ;

namespace lucarium {
namespace {

/// This process' environment with its number as the parent's.
std::vector<std::string> child_environment() {
  const std::string assigned = fmt::format("{}=", parent_variable);
  std::vector<std::string> variables = {assigned + std::to_string(::getpid())};
  for (char** variable = environ; *variable; ++variable) {
    if (!std::string_view(*variable).starts_with(assigned)) variables.emplace_back(*variable);
  }
  return variables;
}

/// Pointers into the strings, with a null at the end, as exec wants them.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

SpawnedProcess::SpawnedProcess(std::vector<std::string> arguments, int in, int out, int error, int held) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, error, STDERR_FILENO);
  if (held >= 0) posix_spawn_file_actions_adddup2(&actions, held, held);  // no longer closed by exec
  std::vector<std::string> variables = child_environment();
  const int failure = posix_spawnp(&id_, arguments[0].c_str(), &actions, nullptr, pointers_to(arguments).data(),
                                   pointers_to(variables).data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure) throw_error(ErrorClass::input, "cannot start {}: {}", arguments[0], std::strerror(failure));
}

SpawnedProcess::~SpawnedProcess() {
  if (id_ < 0) return;
  signal(SIGKILL);
  wait();
}

void SpawnedProcess::signal(int number) const {
  if (id_ >= 0) ::kill(id_, number);
}

std::pair<int, rusage> SpawnedProcess::wait() {
  int status = 0;
  rusage usage{};
  while (::wait4(id_, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  id_ = -1;
  return {status, usage};
}

}  // namespace lucarium
