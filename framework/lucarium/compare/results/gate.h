// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace lucarium {

/// A bar that every result of a comparison must clear: "relmse<0.01", "LABEL:psnr>30". The metric is one of
/// metric_table(), or seconds, prepare_seconds, peak_host_bytes, peak_device_bytes; a label limits it to one variant.
struct Gate {
  std::string text;     ///< as written
  std::string variant;  ///< label, or empty: all
  std::string metric;
  bool below = true;  ///< the value must be below the bar, else above
  double bar = 0;
};

/// Throws Error{usage} that quotes the text and says the form.
Gate parse_gate(const std::string& text);

/// A gate applied to one summary.
struct GateResult {
  std::string gate;
  size_t scene = 0, variant = 0, budget = 0;
  double value = 0;  ///< NaN: there is no result, which fails
  bool passed = false;
  bool unlike_machines = false;  ///< a bar on seconds of several kinds of machine: unknown, and so not passed
};

struct ComparisonResult;
/// Applies every gate to every summary it speaks of. Throws Error{usage} when no variant has the label.
std::vector<GateResult> apply_gates(const std::vector<Gate>& gates, const ComparisonResult& result);

}  // namespace lucarium
