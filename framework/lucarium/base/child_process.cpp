// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/spawned_process.h"
#include "lucarium/base/stopwatch.h"

namespace lucarium {
namespace {

constexpr size_t kept_lines = 20;
constexpr int look_up_milliseconds = 200;  // between two looks at the interrupt flag

struct Pipe {
  int read_end = -1, write_end = -1;
  Pipe() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw_error(ErrorClass::input, "cannot make a pipe: {}", std::strerror(errno));
    read_end = ends[0];
    write_end = ends[1];
  }
  ~Pipe() {
    close_end(read_end);
    close_end(write_end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
};

/// Cuts a byte stream into lines; carriage returns (progress bars) count as line ends.
class LineSplitter {
 public:
  void add(std::string_view bytes, const std::function<void(std::string)>& on_line) {
    for (const char c : bytes) {
      if (c != '\n' && c != '\r') {
        partial_ += c;
        continue;
      }
      if (!partial_.empty()) on_line(std::move(partial_));
      partial_.clear();
    }
  }
  void finish(const std::function<void(std::string)>& on_line) {
    if (!partial_.empty()) on_line(std::move(partial_));
    partial_.clear();
  }

 private:
  std::string partial_;
};

/// A file in memory, opened at its beginning.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : file_(::memfd_create("input", MFD_CLOEXEC)) {
    while (file_ >= 0 && !bytes.empty()) {
      const ssize_t count = ::write(file_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) fail();
      bytes.remove_prefix(static_cast<size_t>(count));
    }
    if (file_ < 0 || ::lseek(file_, 0, SEEK_SET) != 0) fail();
  }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  int descriptor() const { return file_; }

 private:
  [[noreturn]] void fail() const {
    const int reason = errno;
    if (file_ >= 0) ::close(file_);
    throw_error(ErrorClass::input, "cannot make a file in memory: {}", std::strerror(reason));
  }
  int file_;
};

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments,
                      const std::function<void(std::string_view)>& on_error_line, std::string_view input,
                      const std::function<bool()>& stop_requested) {
  const Stopwatch watch;
  const MemoryFile in(input);
  Pipe out, err;
  SpawnedProcess child(arguments, in.descriptor(), out.write_end, err.write_end);
  Pipe::close_end(out.write_end);
  Pipe::close_end(err.write_end);

  ChildResult result;
  LineSplitter splitter;
  const auto keep = [&](std::string line) {
    if (on_error_line) on_error_line(line);
    if (result.last_words.size() == kept_lines) result.last_words.erase(result.last_words.begin());
    result.last_words.push_back(std::move(line));
  };
  std::array<pollfd, 2> streams = {{{out.read_end, POLLIN, 0}, {err.read_end, POLLIN, 0}}};
  std::array<char, 65536> bytes;
  bool passed_on = false;
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    const int ready = ::poll(streams.data(), streams.size(), look_up_milliseconds);
    if (!passed_on && (interrupt_requested() || (stop_requested && stop_requested()))) {
      // A terminal interrupts both, others only this process. SIGTERM, since a second SIGINT would end the child at
      // once.
      child.signal(SIGTERM);
      passed_on = true;
    }
    if (ready < 0 && errno != EINTR)
      throw_error(ErrorClass::internal, "cannot read the output of {}: {}", arguments[0], std::strerror(errno));
    if (ready <= 0) continue;
    for (pollfd& stream : streams) {
      if (stream.fd < 0 || !(stream.revents & (POLLIN | POLLHUP | POLLERR))) continue;
      const ssize_t count = ::read(stream.fd, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        stream.fd = -1;
      } else if (&stream == &streams[0]) {
        result.out.append(bytes.data(), static_cast<size_t>(count));
      } else {
        splitter.add({bytes.data(), static_cast<size_t>(count)}, keep);
      }
    }
  }
  splitter.finish(keep);

  const auto [status, usage] = child.wait();
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  result.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  result.peak_memory_bytes = static_cast<size_t>(usage.ru_maxrss) * 1024;
  result.seconds = watch.seconds();
  return result;
}

void end_with_parent() {
  const char* parent = std::getenv(parent_variable);
  if (!parent) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  // It may have ended before the request; then another process has adopted this one.
  if (std::to_string(::getppid()) != parent) ::raise(SIGTERM);
}

ErrorClass class_of_end(const ChildResult& result) {
  const int code = result.exit_code;
  const bool stated = code >= static_cast<int>(ErrorClass::usage) && code <= static_cast<int>(ErrorClass::interrupted);
  return stated ? static_cast<ErrorClass>(code) : ErrorClass::technique;
}

std::string reason_of_end(const ChildResult& result) {
  for (const std::string& line : result.last_words) {
    if (line.starts_with(error_prefix)) return line.substr(error_prefix.size());
  }
  return describe_end(result) + (result.last_words.empty() ? "" : ": " + result.last_words.back());
}

std::string describe_end(const ChildResult& result) {
  if (result.signal) return fmt::format("killed by signal {} ({})", result.signal, strsignal(result.signal));
  return fmt::format("exit code {}", result.exit_code);
}

}  // namespace lucarium
