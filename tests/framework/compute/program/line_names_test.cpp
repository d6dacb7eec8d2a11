// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/line_names.h"

#include <doctest/doctest.h>

using namespace lucarium;

TEST_CASE("lines of a text without names get those of #line") {
  const std::string source =
      "before\n"
      "#line 1 \"a.cl\"\n"
      "first of a.cl\n"
      "second\n"
      "#line 1 \"b \\\"c\\\".clh\"\n"
      "first of b\n"
      "#line 3 \"a.cl\"\n"
      "third of a.cl\n";
  CHECK(name_lines("<kernel>:3:7: error: x\n", source) == "a.cl:1:7: error: x\n");
  CHECK(name_lines("<kernel>:4:1: note: y", source) == "a.cl:2:1: note: y\n");
  CHECK(name_lines("<kernel>:6:2: warning: z\n", source) == "b \"c\".clh:1:2: warning: z\n");
  CHECK(name_lines("<kernel>:8:2: e\n  ^\n<kernel>:9:1: f\n", source) == "a.cl:3:2: e\n  ^\na.cl:4:1: f\n");
  // Before the first name, or without a number, there is nothing to say.
  CHECK(name_lines("<kernel>:1:1: e\n", source) == "<kernel>:1:1: e\n");
  CHECK(name_lines("<kernel>:x\n", source) == "<kernel>:x\n");
  // Who heeds #line is left alone.
  CHECK(name_lines("a.cl:2:1: error: y", source) == "a.cl:2:1: error: y");
}
