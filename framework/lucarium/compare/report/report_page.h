// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace lucarium {

struct ReportOptions {
  /// Images in full precision in `report_images/` beside the page, instead of within it.
  bool link_images = false;
};

/// Writes `folder`/report.html from `folder`/results.json and the images it names (docs/report.md). One file that works
/// offline and stays below 150 MB: what does not fit is kept at less resolution or precision, and the page says so.
/// Throws Error{input} when results.json is missing, damaged or of another schema.
void write_report(const std::filesystem::path& folder, const ReportOptions& options = {});

}  // namespace lucarium
