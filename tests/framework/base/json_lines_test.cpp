// SPDX-License-Identifier: Apache-2.0
// Lines of the values of a JSON file.
#include "lucarium/base/files/json_lines.h"

#include <doctest/doctest.h>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "test_support.h"

using namespace lucarium;

namespace {

JsonWithLines read(const std::string& text) {
  const test::TemporaryFolder folder;
  write_file_atomically(folder.path() / "a.json", text);
  return read_json_with_lines(folder.path() / "a.json");
}

}  // namespace

TEST_CASE("the line of a number that ends its line was one too late") {
  const JsonWithLines json = read("[\n1,\n2\n,\n-3.5\n]\n");
  CHECK(json.line("/0") == 2);
  CHECK(json.line("/1") == 3);
  CHECK(json.line("/2") == 5);
}

TEST_CASE("keys, texts and objects have the line on which they begin") {
  const JsonWithLines json = read("{\n\"a\":\n1,\n\"b\": [\"x\"\n, {\n\"c\": null\n}\n]}");
  CHECK(json.line("/a") == 2);
  CHECK(json.line("/b") == 4);
  CHECK(json.line("/b/0") == 4);
  CHECK(json.line("/b/1") == 5);
  CHECK(json.line("/b/1/c") == 6);
  CHECK(json.line("/b/1/c/unknown") == 6);
}

TEST_CASE("what is no JSON is complained about on its own line") {
  try {
    read("{\n\"a\": 1\n\"b\": 2}");
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find("a.json:3: ") != std::string::npos);
  }
}
