// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <string>

#include "lucarium/base/time_left.h"

namespace lucarium {

/// Progress of long work on standard error: on a terminal a bar with rate and, once it can be
/// estimated, time left; otherwise a plain line now and then; nothing when quiet.
class Progress {
 public:
  enum class Style { quiet, automatic };
  Progress(std::string label, Style style);
  ~Progress();  ///< ends the bar's line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `fraction` of the work that is done (negative: unknown), and what to say beside it ("12 of 64 samples").
  void update(double fraction, const std::string& text);
  /// Takes the bar off a terminal, so that a line can be printed; the next update() draws it at once.
  void clear();

 private:
  void draw(double fraction, const std::string& text, double elapsed);
  std::string label_;
  bool quiet_, terminal_, drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
  TimeLeft left_;
  double line_interval_ = 2;  // [s]; grows, so that a long run does not fill a log
};

/// "1:05", "2:03:10".
std::string format_duration(double seconds);

}  // namespace lucarium
