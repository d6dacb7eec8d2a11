// SPDX-License-Identifier: Apache-2.0
// A report in a real browser: report_selftest.js is put into the page, presses its controls and writes what it found.
#include <doctest/doctest.h>

#include <cstdlib>

#include "lucarium/compare/report/report_page.h"
#include "report_example.h"
#include "test_support.h"

using namespace lucarium;

namespace {

/// What the page says of itself, line by line.
std::string selftest(const std::filesystem::path& folder) {
  std::string page = read_file(folder / "report.html");
  const std::string script = read_file(std::filesystem::path(std::getenv("LUCARIUM_TEST_SOURCE")) /
                                       "tests/framework/compare/report_selftest.js");
  page.insert(page.rfind("</body>"), "<script>" + script + "</script>");
  write_file_atomically(folder / "selftest.html", page);
  const test::ProgramResult run = test::run_program(
      "chromium --headless --no-sandbox --disable-gpu --user-data-dir='" + (folder / "profile").string() +
          "' --window-size=1280,900 --virtual-time-budget=120000 --dump-dom 'file://" +
          (folder / "selftest.html").string() + "'",
      240);
  const size_t begin = run.out.rfind("<pre id=\"selftest\">");
  REQUIRE_MESSAGE(begin != std::string::npos, run.err.substr(0, 2000));
  return run.out.substr(begin + 19, run.out.find("</pre>", begin) - begin - 19);
}

}  // namespace

TEST_CASE("every control of a report works, and nothing goes to the console") {
  if (test::run_program("chromium --version").exit_code != 0) return test::skip("chromium");
  const test::TemporaryFolder folder;
  test::write_report_example(folder.path());
  for (const bool link : {false, true}) {
    if (link && !test::full_run()) break;
    CAPTURE(link);
    write_report(folder.path(), {.link_images = link});
    const std::string found = selftest(folder.path());
    INFO(found);
    CHECK(found.find("FAILED") == std::string::npos);
    CHECK(found.find("ok windows are chosen") != std::string::npos);
    CHECK(found.substr(found.size() - 3) == "end");
  }
}
