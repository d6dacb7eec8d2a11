// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compare/request/comparison_spec.h"

namespace lucarium {

constexpr size_t no_position = SIZE_MAX;

/// A number of an experiment: made from one variant's results, or from values above it.
struct ExperimentValue {
  std::string name;   ///< in expressions below it: letters, digits, _
  std::string label;  ///< for people
  std::string unit;
  std::string expression;  ///< docs/reproducing.md
  std::string variant;     ///< label of the variant whose quantities the expression uses; empty: values only
  std::string against;     ///< label of the variant whose images of the same seeds take the reference's place, or empty
  std::string layer;       ///< whose metrics are meant, against the reference's layer; empty: those of the image
  size_t scene = 0, budget = 0;  ///< positions; no_position: it takes no part in the quick setting
  std::optional<double> paper;   ///< what the paper measured, where it says so
};

/// What should come out, independently of the machine: an expression over the values that is true or false.
struct ExperimentTrend {
  std::string claim, expression;
};

/// A quantity over another, both logarithmic: a line for each variant, a point for each scene.
struct ExperimentPlot {
  std::string name;  ///< the slope of a line is the value NAME_VARIANT
  std::string title, x_label, y_label;
  std::string x, y;  ///< expressions over the quantities of a variant
  std::vector<std::string> variants;
  std::vector<size_t> scenes;
  size_t budget = 0;

  std::string slope_name(const std::string& variant) const;
};

/// A table or figure of a paper: a comparison, and the values read off it (docs/reproducing.md).
struct Experiment {
  std::string paper, name;  ///< "hermes2010", "resolution"
  std::string title;
  std::string place;        ///< in the paper: "Table 1"
  std::string claim;        ///< what the paper says
  std::string differences;  ///< what is not as in the paper
  bool quick = false;       ///< the quick setting, not the full one
  bool own = false;         ///< of no paper: what the project says of itself
  ComparisonSpec comparison;
  std::vector<ExperimentValue> values;
  std::vector<ExperimentPlot> plots;
  std::vector<ExperimentTrend> trends;

  std::string id() const { return paper + "/" + name; }
};

/// A paper whose experiments are data: a folder with paper.json and a file for each experiment. Where it names no
/// technique they are of no paper, but compare techniques for their own sake.
struct Paper {
  std::string name;  ///< of the folder: "hermes2010"
  std::filesystem::path folder;
  std::string citation, technique, machine;
  std::vector<std::string> experiments;  ///< names, in the order in which they run
};

/// The folder's paper.json. Throws Error{input} naming file, line and key.
Paper read_paper(const std::filesystem::path& folder);

/// One experiment of a paper, with the quick setting or the full one. Everything that can be wrong is found here:
/// expressions that do not parse, values of techniques that do not take part. Throws Error{input}.
Experiment read_experiment(const Paper& paper, const std::string& name, bool quick);

/// The papers found in `experiments/` of the technique folders (technique_folders.h), by name.
std::vector<Paper> find_papers(const std::vector<std::filesystem::path>& technique_folders);

}  // namespace lucarium
