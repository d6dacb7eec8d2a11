// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/child_conversation.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#include "lucarium/base/error.h"

namespace lucarium {
namespace {

/// Above the standard streams, whose places the child's ends take.
int above_standard_streams(int descriptor) {
  if (descriptor < 0 || descriptor > STDERR_FILENO) return descriptor;
  const int moved = ::fcntl(descriptor, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  ::close(descriptor);
  return moved;
}

/// Starts the child with the other end of `own`.
SpawnedProcess start(std::vector<std::string> arguments, int held, int& own) {
  struct Ends {
    int child = -1, silence = -1;
    ~Ends() {
      if (child >= 0) ::close(child);
      if (silence >= 0) ::close(silence);
    }
  } ends;
  int pair[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0) {
    own = pair[0];
    ends.child = above_standard_streams(pair[1]);
    ends.silence = above_standard_streams(::open("/dev/null", O_WRONLY | O_CLOEXEC));
  }
  if (ends.child < 0 || ends.silence < 0)
    throw_error(ErrorClass::input, "cannot talk to {}: {}", arguments[0], std::strerror(errno));
  return SpawnedProcess(std::move(arguments), ends.child, ends.child, ends.silence, held);
}

}  // namespace

ChildConversation::ChildConversation(std::vector<std::string> arguments, int held)
    : child_(start(std::move(arguments), held, own_.descriptor)) {}

ChildConversation::Socket::~Socket() {
  if (descriptor >= 0) ::close(descriptor);
}

bool ChildConversation::ask(const std::string& line, std::string& answer) {
  const std::string message = line + '\n';
  for (std::string_view rest = message; !rest.empty();) {
    const ssize_t count = ::send(own_.descriptor, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    rest.remove_prefix(static_cast<size_t>(count));
  }
  std::array<char, 4096> bytes;
  for (;;) {
    if (const size_t end = received_.find('\n'); end != std::string::npos) {
      answer = received_.substr(0, end);
      received_.erase(0, end + 1);
      return true;
    }
    const ssize_t count = ::recv(own_.descriptor, bytes.data(), bytes.size(), 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    received_.append(bytes.data(), static_cast<size_t>(count));
  }
}

void ChildConversation::kill() const { child_.signal(SIGKILL); }

}  // namespace lucarium
