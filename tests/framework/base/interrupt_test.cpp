// SPDX-License-Identifier: Apache-2.0
// Effects of signals, each in a process of its own that reports its progress.
#include "lucarium/base/interrupt.h"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <string>

#include "lucarium/base/error.h"

using namespace lucarium;

namespace {

constexpr int interrupted = static_cast<int>(ErrorClass::interrupted), ran_through = 42, noticed = 43;
constexpr unsigned patience_seconds = 60;  // then the child is ended by SIGALRM and the test fails

/// A forked child that runs `work`, which says by `ready` when the signals may come, and what it wrote to stderr.
class Child {
 public:
  explicit Child(const std::function<void(const std::function<void(char)>& ready)>& work) {
    int steps[2], errors[2];
    REQUIRE(::pipe(steps) == 0);
    REQUIRE(::pipe(errors) == 0);
    pid_ = ::fork();
    REQUIRE(pid_ >= 0);
    if (pid_ == 0) {
      ::alarm(patience_seconds);
      ::dup2(errors[1], STDERR_FILENO);
      ::close(errors[1]);
      work([&](char step) { [[maybe_unused]] const ssize_t written = ::write(steps[1], &step, 1); });
      ::_exit(ran_through);
    }
    ::close(steps[1]);
    ::close(errors[1]);
    steps_ = steps[0];
    errors_ = errors[0];
  }
  ~Child() {
    if (!ended_) ::kill(pid_, SIGKILL), ::waitpid(pid_, nullptr, 0);
    ::close(steps_);
    ::close(errors_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void wait_for(char step) const {
    char got = 0;
    REQUIRE(::read(steps_, &got, 1) == 1);
    REQUIRE(got == step);
  }
  void send(int signal) const { REQUIRE(::kill(pid_, signal) == 0); }
  /// Exit code, or 128 + signal.
  int end() {
    int status = 0;
    REQUIRE(::waitpid(pid_, &status, 0) == pid_);
    ended_ = true;
    for (char c; ::read(errors_, &c, 1) == 1;) text_ += c;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  const std::string& text() const { return text_; }

 private:
  pid_t pid_ = -1;
  int steps_ = -1, errors_ = -1;
  bool ended_ = false;
  std::string text_;
};

[[noreturn]] void work_for_ever() {
  while (true) ::pause();
}

constexpr const char* the_line = "lucarium: error: interrupted; nothing was kept\n";

}  // namespace

TEST_CASE("with nothing to keep each signal ends the process at once, with one line and exit code 6") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    Child child([](const auto& ready) {
      install_interrupt_handler();
      ready('r');
      work_for_ever();
    });
    child.wait_for('r');
    child.send(signal);
    CHECK(child.end() == interrupted);
    CHECK(child.text() == the_line);
  }
}

TEST_CASE("with something to keep each signal sets the flag alone, and a second one ends the process") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto keeps = [](const auto& ready) {
      install_interrupt_handler();
      const KeepOnInterrupt keep;
      ready('r');
      while (!interrupt_requested()) ::usleep(1000);
      ready('n');
    };
    Child child([&](const auto& ready) {
      keeps(ready);
      ::_exit(noticed);
    });
    child.wait_for('r');
    child.send(signal);
    CHECK(child.end() == noticed);
    CHECK(child.text() == "");

    Child deaf([&](const auto& ready) {
      keeps(ready);
      work_for_ever();
    });
    deaf.wait_for('r');
    deaf.send(signal);
    deaf.wait_for('n');
    deaf.send(signal);
    CHECK(deaf.end() == 128 + signal);
  }
}

TEST_CASE("what was kept no longer delays the end") {
  Child child([](const auto& ready) {
    install_interrupt_handler();
    { const KeepOnInterrupt keep; }
    ready('r');
    work_for_ever();
  });
  child.wait_for('r');
  child.send(SIGINT);
  CHECK(child.end() == interrupted);
}

TEST_CASE("a file that is half written is finished before the process ends") {
  Child child([](const auto& ready) {
    install_interrupt_handler();
    {
      const DelayInterrupt delay;
      ready('r');
      while (!interrupt_requested()) ::usleep(1000);
      ready('f');
    }
    ready('x');
  });
  child.wait_for('r');
  child.send(SIGTERM);
  child.wait_for('f');
  CHECK(child.end() == interrupted);
  CHECK(child.text() == the_line);
}

TEST_CASE("a hang-up that was ignored from the start (nohup) stays ignored") {
  Child child([](const auto& ready) {
    std::signal(SIGHUP, SIG_IGN);
    install_interrupt_handler();
    ::raise(SIGHUP);
    ready('r');
  });
  child.wait_for('r');
  CHECK(child.end() == ran_through);
}
