// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/terminal.h"

#include <doctest/doctest.h>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"

using namespace lucarium;

TEST_CASE("control characters are written out, and all that is text stays") {
  CHECK(printable("plain text,\ttabs\nand lines") == "plain text,\ttabs\nand lines");
  CHECK(printable("Ωμέγα 光 🙂 e\u0301") == "Ωμέγα 光 🙂 e\u0301");
  CHECK(printable("\x1b[2J\x1b]0;evil\x07") == "\\u001b[2J\\u001b]0;evil\\u0007");
  CHECK(printable(std::string_view("a\0b\r\x7f", 5)) == "a\\u0000b\\u000d\\u007f");
  CHECK(printable("\xc2\x9b"
                  "31m") == "\\u009b31m");                        // CSI as one character
  CHECK(printable("safe\u202egnp.exe") == "safe\\u202egnp.exe");  // turns the direction of writing
  CHECK(printable_line("two\nlines\t") == "two\\u000alines\\u0009");
}

TEST_CASE("bytes that are no UTF-8 cannot smuggle control characters in") {
  const std::string replaced = "\ufffd";
  CHECK(printable("a\x9b"
                  "31m") == "a" + replaced + "31m");    // CSI in Latin-1
  CHECK(printable("\xc0\x9b") == replaced + replaced);  // longer than needed
  CHECK(printable("\xe0\x82\x9b") == replaced + replaced + replaced);
  CHECK(printable("\xed\xa0\x80") == replaced + replaced + replaced);                 // a surrogate
  CHECK(printable("\xf4\x90\x80\x80") == replaced + replaced + replaced + replaced);  // beyond U+10FFFF
  CHECK(printable("cut \xe5\x85") == "cut " + replaced + replaced);
}

TEST_CASE("JSON whose strings hold control characters stays the same JSON") {
  const nlohmann::json json = {{"name",
                                "\xc2\x9b"
                                "31m\x7f\u202e\x1b"}};
  const std::string text = printable(json.dump(2));
  for (const char* raw : {"\xc2\x9b", "\x7f", "\u202e", "\x1b"}) CHECK(text.find(raw) == std::string::npos);
  CHECK(nlohmann::json::parse(text) == json);
}

TEST_CASE("context that an error has already is not put before it again") {
  const Error inner = Error(ErrorClass::technique, "it failed").with_context("path_tracing");
  CHECK(std::string(inner.with_context("path_tracing").what()) == "path_tracing: it failed");
  CHECK(std::string(inner.with_context("path").what()) == "path: path_tracing: it failed");
}
