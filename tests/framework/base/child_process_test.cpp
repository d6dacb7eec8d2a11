// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/child_process.h"

#include <doctest/doctest.h>

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
