// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "lucarium/base/terminal.h"

namespace lucarium {
namespace {

constexpr int bar_width = 24;
constexpr double redraw_seconds = 0.1, longest_line_interval = 60;

}  // namespace

std::string format_duration(double seconds) {
  const auto total = static_cast<long>(std::lround(std::max(0.0, seconds)));
  if (total >= 3600) return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

Progress::Progress(std::string label, Style style)
    : label_(std::move(label)),
      quiet_(style == Style::quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (drawn_ && terminal_) std::fputc('\n', stderr);
}

void Progress::update(double fraction, const std::string& text) {
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  left_.update(fraction, elapsed);
  const double since_last = std::chrono::duration<double>(now - last_).count();
  const double interval = terminal_ ? redraw_seconds : line_interval_;
  if (since_last < interval && !(fraction >= 1 && terminal_)) return;
  last_ = now;
  if (!terminal_) line_interval_ = std::min(2 * line_interval_, longest_line_interval);
  draw(fraction, text, elapsed);
}

void Progress::clear() {
  if (!drawn_ || !terminal_) return;
  fmt::print(stderr, "\r\x1b[2K");
  std::fflush(stderr);
  drawn_ = false;
  last_ = {};
}

void Progress::draw(double fraction, const std::string& raw_text, double elapsed) {
  const std::string text = printable_line(raw_text);
  std::string time = format_duration(elapsed);
  if (const std::optional<double> left = left_.settled_estimate())
    time += fmt::format(", {} left", format_duration(*left));
  const std::string percent = fraction >= 0 ? fmt::format("{:3.0f} % ", 100 * std::min(1.0, fraction)) : "";
  if (!terminal_) {
    fmt::print(stderr, "{}: {}{}, {}\n", label_, percent, text, time);
    return;
  }
  const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * bar_width);
  fmt::print(stderr, "\r\x1b[2K{} [{:#<{}}{:.<{}}] {}{}  {}", label_, "", filled, "", bar_width - filled, percent, text,
             time);
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace lucarium
