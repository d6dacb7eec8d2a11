// SPDX-License-Identifier: Apache-2.0
// A report in a real browser: report_browser.py presses keys, looks at it in light, dark and on paper, and reads the
// console; report_selftest.js is put into the page, presses its controls and writes what it found.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cstdlib>

#include "lucarium/compare/report/report_page.h"
#include "report_example.h"
#include "test_support.h"

using namespace lucarium;

namespace {

/// What was found, line by line, and whether there is a browser.
test::ProgramResult look_at(const std::filesystem::path& folder) {
  const std::filesystem::path here =
      std::filesystem::path(std::getenv("LUCARIUM_TEST_SOURCE")) / "tests/framework/compare/report";
  std::string page = read_file(folder / "report.html");
  page.insert(page.rfind("</body>"), "<script>" + read_file(here / "report_selftest.js") + "</script>");
  write_file_atomically(folder / "selftest.html", page);
  return test::run_program(fmt::format("python3 '{}' '{}'", (here / "report_browser.py").string(), folder.string()),
                           540);
}

/// Gives the second scene a reference that none of its techniques has, before the one that all have.
void add_foreign_reference(const std::filesystem::path& folder) {
  nlohmann::ordered_json results = nlohmann::ordered_json::parse(read_file(folder / "results.json"));
  nlohmann::ordered_json& scene = results["scenes"][1];
  scene["references"].push_back(scene["references"][0]);
  for (nlohmann::ordered_json& variant : scene["variants"]) variant["reference"] = 1;
  write_file_atomically(folder / "results.json", results.dump());
}

}  // namespace

TEST_CASE("report in a browser: controls, keys, light, dark and print work, and the console stays empty") {
  const test::TemporaryFolder folder;
  test::write_report_example(folder.path());
  add_foreign_reference(folder.path());
  for (const bool link : {false, true}) {
    if (link && !test::full_run()) break;
    CAPTURE(link);
    write_report(folder.path(), {.link_images = link});
    const test::ProgramResult found = look_at(folder.path());
    if (found.exit_code == 77) return test::skip("chromium");
    INFO(found.out << found.err);
    CHECK(found.exit_code == 0);
    CHECK(found.out.find("FAILED") == std::string::npos);
    CHECK(found.out.find("ok windows are chosen") != std::string::npos);
    CHECK(found.out.ends_with("end\n"));
  }
}
