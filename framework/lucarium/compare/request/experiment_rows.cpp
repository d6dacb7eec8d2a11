// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/request/experiment_rows.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compare/request/expression.h"

namespace lucarium {

using nlohmann::json;

namespace {

const std::vector<std::string> kinds = {"scene", "technique", "budget"};

void replace_all(std::string& text, const std::string& part, const std::string& by) {
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + by.size()))
    text.replace(at, part.size(), by);
}

/// Puts the label in place of {kind}: as a part of a name in expressions and their names, as it is in all other texts.
void put_label(json& object, const std::string& kind, const std::string& label) {
  for (const auto& [key, value] : object.items()) {
    if (!value.is_string()) continue;
    std::string text = value;
    const bool in_names = key == "name" || key == "value" || key == "holds";
    replace_all(text, "{" + kind + "}", in_names ? expression_name(label) : label);
    value = text;
  }
}

/// What was written but not stated in "each" would otherwise be shown as it is.
void check_no_placeholder(const JsonFile& file, const json& object, const std::string& pointer) {
  for (const std::string& kind : kinds) {
    for (const auto& [key, value] : object.items()) {
      if (value.is_string() && value.get<std::string>().find("{" + kind + "}") != std::string::npos)
        file.fail(pointer + "/" + key, fmt::format("{{{}}} has no list in \"each\"", kind));
    }
  }
}

}  // namespace

std::vector<std::string> comparison_labels(const ComparisonSpec& spec, const std::string& kind) {
  std::vector<std::string> labels;
  if (kind == "scene") {
    for (const ComparisonScene& scene : spec.scenes) labels.push_back(scene.label());
  } else if (kind == "technique") {
    for (const TechniqueVariant& variant : spec.variants) labels.push_back(variant.label());
  } else {
    for (const ComparisonBudget& budget : spec.budgets) labels.push_back(budget.label());
  }
  return labels;
}

std::optional<size_t> label_position(const std::vector<std::string>& labels, const std::string& label) {
  const auto found = std::find(labels.begin(), labels.end(), label);
  if (found == labels.end()) return std::nullopt;
  return static_cast<size_t>(found - labels.begin());
}

void check_label(const JsonFile& file, const std::string& label, const std::string& pointer, const ComparisonSpec& full,
                 const std::string& kind) {
  const std::vector<std::string> labels = comparison_labels(full, kind);
  if (label_position(labels, label)) return;
  file.fail(pointer, fmt::format("no {} has the label '{}'{}", kind, label, suggest_name(label, labels)));
}

std::vector<std::string> chosen_labels(const JsonFile& file, const json& value, const std::string& pointer,
                                       const ComparisonSpec& full, const std::string& kind) {
  if (value == "all") return comparison_labels(full, kind);
  if (!value.is_array() || value.empty()) file.fail(pointer, "must be \"all\" or an array of labels");
  std::vector<std::string> labels;
  for (size_t i = 0; i < value.size(); ++i) {
    labels.push_back(file.text(value[i], fmt::format("{}/{}", pointer, i)));
    check_label(file, labels.back(), fmt::format("{}/{}", pointer, i), full, kind);
  }
  return labels;
}

std::vector<ExperimentRow> experiment_rows(const JsonFile& file, const json& object, const std::string& pointer,
                                           const ComparisonSpec& full, const ComparisonSpec& run) {
  std::vector<ExperimentRow> rows = {{object, true}};
  if (object.is_object() && object.contains("each")) {
    const json& each = object["each"];
    if (!each.is_object()) file.fail(pointer + "/each", "must be an object");
    file.check_keys(each, pointer + "/each", kinds);
    rows.front().object.erase("each");
    for (const std::string& kind : kinds) {
      if (!each.contains(kind)) continue;
      if (object.contains(kind)) file.fail(pointer + "/" + kind, "stands in \"each\", too");
      const std::vector<std::string> taking_part = comparison_labels(run, kind);
      std::vector<ExperimentRow> more;
      for (const ExperimentRow& row : rows) {
        for (const std::string& label : chosen_labels(file, each[kind], pointer + "/each/" + kind, full, kind)) {
          more.push_back(row);
          // A trend has no scene of its own.
          if (!object.contains("holds")) more.back().object[kind] = label;
          put_label(more.back().object, kind, label);
          more.back().takes_part = row.takes_part && label_position(taking_part, label);
        }
      }
      rows = std::move(more);
    }
  }
  for (const ExperimentRow& row : rows) check_no_placeholder(file, row.object, pointer);
  return rows;
}

}  // namespace lucarium
