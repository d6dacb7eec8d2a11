// SPDX-License-Identifier: Apache-2.0
// lucarium_bidirectional_bench: the ratios that bidirectional_vpl is judged by, each with its bars. Contestants take
// turns within one run; ratios are medians over the rounds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

#include "measures.h"

int main(int argc, char** argv) {
  using namespace lucarium::bench;
  Effort effort;
  std::vector<std::string> parts = {"paths", "ways", "stored", "rates"};
  std::string json;
  CLI::App app("The ratios that bidirectional_vpl is judged by, with floors and goals");
  app.add_option("parts", parts, "what is measured")
      ->check(CLI::IsMember({"paths", "ways", "stored", "rates", "light"}));
  const auto number = [&](const char* name, auto& value, const char* text, int low, int high) {
    app.add_option(name, value, text)->check(CLI::Range(low, high))->capture_default_str();
  };
  number("--rounds", effort.rounds, "measurements of each contestant", 1, 1000);
  number("--width", effort.width, "edge of pictures whose errors are measured [pixels]", 16, 4096);
  number("--samples", effort.samples, "samples of each of them (of ways that take more rays to one, fewer)", 2,
         1 << 20);
  number("--reference", effort.reference, "times as many, of each of the two references", 1, 1024);
  number("--seeds", effort.seeds, "pictures of each kind", 2, 64);
  app.add_option("--scene", effort.scene, "the one scene that is rendered beside path_tracing: builtin:NAME or sponza");
  app.add_option("--json", json, "writes the rows to a file, too");
  CLI11_PARSE(app, argc, argv);
  try {
    Bars bars;
    const auto asked = [&](const char* part) { return std::find(parts.begin(), parts.end(), part) != parts.end(); };
    if (asked("paths")) measure_paths(bars, effort);
    if (asked("ways")) measure_ways(bars, effort);
    if (asked("stored")) measure_stored(bars, effort);
    if (asked("rates")) measure_rates(bars, effort);
    if (asked("light")) measure_light_rays(bars, effort);
    if (!json.empty() && !(std::ofstream(json) << bars.json()))
      throw std::runtime_error(json + ": cannot be written; give another file");
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
