// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/child_process.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cerrno>
#include <stdexcept>

#include "lucarium/base/error.h"

using namespace lucarium;

TEST_CASE("a child's output, last words and exit code come back") {
  const ChildResult result = run_child({"sh", "-c", "echo result; echo first >&2; printf last >&2; exit 3"});
  CHECK(result.exit_code == 3);
  CHECK(result.signal == 0);
  CHECK(result.out == "result\n");
  REQUIRE(result.last_words.size() == 2);
  CHECK(result.last_words[1] == "last");
  CHECK(describe_end(result) == "exit code 3");
}

TEST_CASE("a killed child says by what") {
  const ChildResult result = run_child({"sh", "-c", "kill -9 $$"});
  CHECK(result.exit_code == -1);
  CHECK(result.signal == 9);
  CHECK(describe_end(result) == "killed by signal 9 (Killed)");
}

TEST_CASE("a child with much output on both streams does not stall") {
  int lines = 0;
  const ChildResult result =
      run_child({"sh", "-c", "i=0; while [ $i -lt 20000 ]; do echo 0123456789; echo x >&2; i=$((i+1)); done"},
                [&](std::string_view) { ++lines; });
  CHECK(result.out.size() == 20000 * 11);
  CHECK(lines == 20000);
  CHECK(result.last_words.size() == 20);
}

TEST_CASE("a program that does not exist is an error") { CHECK_THROWS_AS(run_child({"/nonexistent/program"}), Error); }

TEST_CASE("a callback that throws left the child running and unwaited for") {
  CHECK_THROWS_AS(
      run_child({"sh", "-c", "echo x >&2; sleep 600"}, [](std::string_view) { throw std::runtime_error("enough"); }),
      std::runtime_error);
  CHECK(::waitpid(-1, nullptr, WNOHANG) == -1);
  CHECK(errno == ECHILD);
}

TEST_CASE("an error of poll waited for ever for a child that fills its pipe") {
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
  const auto break_poll = [&](std::string_view) {
    const rlimit none{1, before.rlim_max};  // poll() refuses more descriptors than a process may have
    ::setrlimit(RLIMIT_NOFILE, &none);
  };
  CHECK_THROWS_WITH_AS(run_child({"sh", "-c", "echo x >&2; head -c 1000000 /dev/zero"}, break_poll),
                       doctest::Contains("cannot read the output of sh: Invalid argument"), Error);
  ::setrlimit(RLIMIT_NOFILE, &before);
  CHECK(::waitpid(-1, nullptr, WNOHANG) == -1);
}
