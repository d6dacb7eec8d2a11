// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compare/execute/piece_executor.h"
#include "lucarium/compare/report/report_page.h"
#include "lucarium/compare/request/experiment.h"
#include "lucarium/compare/results/comparison_result.h"
#include "lucarium/technique/plugin.h"

namespace lucarium {

struct ComparisonOptions {
  std::filesystem::path folder;  ///< of the results; created
  bool resume = false;           ///< continue the comparison in the folder
  bool overwrite = false;        ///< replace the comparison in the folder
  std::vector<Gate> gates;
  std::optional<Experiment> experiment;  ///< values to read off the results
  std::filesystem::path baseline;        ///< folder of an earlier run
  ReportOptions report;
  std::filesystem::path program;                         ///< the lucarium executable that renders the pieces
  std::filesystem::path cache_dir;                       ///< of references and compiled kernels
  bool use_cache = true;                                 ///< of compiled kernels
  std::vector<std::filesystem::path> technique_folders;  ///< where the pieces look for plug-ins first
  ExecutorOptions executor;                              ///< what runs references and pieces
  std::function<void(const std::string&)> progress;      ///< one line for people
};

/// Runs what is missing, keeps results.json, the CSVs and report.html up to date as pieces come, and returns the
/// results. Each piece runs in a process of its own. On Ctrl-C the finished pieces stay and `interrupted` is set.
ComparisonResult run_comparison(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                const ComparisonOptions& options);

}  // namespace lucarium
