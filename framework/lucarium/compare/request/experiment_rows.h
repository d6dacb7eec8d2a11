// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "lucarium/base/files/json_file.h"
#include "lucarium/compare/request/comparison_spec.h"

namespace lucarium {

/// A value or trend of an experiment's file, for one scene, technique and budget of those that it is stated for.
struct ExperimentRow {
  nlohmann::json object;   ///< without "each"; the labels stand in place of {scene}, {technique}, {budget}
  bool takes_part = true;  ///< false: the quick setting leaves out its scene, technique or budget
};

/// The rows that "each" makes of one object, in the order of its lists (docs/reproducing.md); of one without it,
/// itself. `full` has all labels, `run` those of the setting that runs. Throws Error{input} naming file, line and key.
std::vector<ExperimentRow> experiment_rows(const JsonFile& file, const nlohmann::json& object,
                                           const std::string& pointer, const ComparisonSpec& full,
                                           const ComparisonSpec& run);

/// What scenes, techniques and budgets of a comparison are called; `kind` is "scene", "technique" or "budget".
std::vector<std::string> comparison_labels(const ComparisonSpec& spec, const std::string& kind);

/// The labels that `value` names: "all", or a list of some. Throws Error{input}.
std::vector<std::string> chosen_labels(const JsonFile& file, const nlohmann::json& value, const std::string& pointer,
                                       const ComparisonSpec& full, const std::string& kind);

/// Where the label stands; absent where it does not.
std::optional<size_t> label_position(const std::vector<std::string>& labels, const std::string& label);

/// Throws Error{input} unless the label is one of the comparison's.
void check_label(const JsonFile& file, const std::string& label, const std::string& pointer, const ComparisonSpec& full,
                 const std::string& kind);

}  // namespace lucarium
