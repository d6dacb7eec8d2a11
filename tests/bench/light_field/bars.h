// SPDX-License-Identifier: Apache-2.0
// Measured ratios, each with what it must reach (floor) and what it should (goal).
#pragma once
#include <string>
#include <vector>

namespace lucarium::bench {

/// How large the measurements are.
struct Sizes {
  int rounds = 5;
  uint32_t width = 256;      ///< of square pictures
  int dir_n = 6;             ///< of fields whose error does not matter
  uint32_t reference = 256;  ///< samples of each of three references
  uint32_t subfield = 512;   ///< pixels along an edge, of the sweeps beside rays
};

class Bars {
 public:
  /// A ratio, printed at once; NaN: none was reached. `at_most`: small ones are good.
  void add(const std::string& what, double floor, double goal, double value, bool at_most = false);
  /// A number that stands beside them, with the paper's where it has one.
  void note(const std::string& what, double value, const std::string& unit, double paper = 0);
  std::string json() const;

 private:
  struct Row {
    std::string what, unit;
    double floor = 0, goal = 0, value = 0, paper = 0;
    bool at_most = false, is_bar = false;
  };
  const char* verdict(const Row& row) const;
  std::vector<Row> rows_;
};

/// Sweeps alone: kept fragments, rays, lamps, sky, threads.
void measure_sweeps(Bars& bars, const Sizes& sizes);
/// What the passes of a line of a sweep take.
void measure_lines(const Sizes& sizes);
/// Frames of walks, what they look up, loaded fields, bytes of cells.
void measure_frames(Bars& bars, const Sizes& sizes);
/// A frame of a walk beside paths and rays: the first of these.
void measure_walk(Bars& bars, const Sizes& sizes);
/// What the passes of frames of walks take.
void measure_passes(const Sizes& sizes);
/// Time to an error, beside path_tracing.
void measure_errors(Bars& bars, const Sizes& sizes);

}  // namespace lucarium::bench
