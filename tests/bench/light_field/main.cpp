// SPDX-License-Identifier: Apache-2.0
// lucarium_field_bench: the ratios that virtual_light_field is judged by, each with its bars. Contestants take turns
// within one run; ratios are medians over the rounds of processor time, of two threads, where a row does not say
// otherwise.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

#include "bars.h"

int main(int argc, char** argv) {
  using namespace lucarium::bench;
  Sizes sizes;
  std::vector<std::string> parts = {"sweeps", "frames", "errors"};
  std::string json;
  CLI::App app("The ratios that virtual_light_field is judged by, with floors and goals");
  app.add_option("parts", parts,
                 "what is measured (walk: the first of frames; passes: device time of their passes; lines: that of "
                 "sweeps)")
      ->check(CLI::IsMember({"sweeps", "frames", "errors", "walk", "passes", "lines"}));
  app.add_option("--rounds", sizes.rounds, "measurements of each contestant")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--width", sizes.width, "edge of square pictures [pixels]")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  app.add_option("--dir-n", sizes.dir_n, "dir_n of fields whose error is not measured")
      ->check(CLI::Range(2, 64))
      ->capture_default_str();
  app.add_option("--reference", sizes.reference, "samples of each of the three references")
      ->check(CLI::Range(2, 1 << 20))
      ->capture_default_str();
  app.add_option("--subfield", sizes.subfield, "edge of subfields beside rays [pixels]")
      ->check(CLI::Range(128, 2048))
      ->capture_default_str();
  app.add_option("--json", json, "writes the rows to a file, too");
  CLI11_PARSE(app, argc, argv);
  try {
    Bars bars;
    const auto asked = [&](const char* part) { return std::find(parts.begin(), parts.end(), part) != parts.end(); };
    if (asked("sweeps")) measure_sweeps(bars, sizes);
    if (asked("frames")) measure_frames(bars, sizes);
    if (asked("walk")) measure_walk(bars, sizes);
    if (asked("passes")) measure_passes(sizes);
    if (asked("lines")) measure_lines(sizes);
    if (asked("errors")) measure_errors(bars, sizes);
    if (!json.empty() && !(std::ofstream(json) << bars.json()))
      throw std::runtime_error(json + ": cannot be written; give another file");
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
