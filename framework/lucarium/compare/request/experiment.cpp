// SPDX-License-Identifier: Apache-2.0
// Reading experiments; every complaint names file, line and key.
#include "lucarium/compare/request/experiment.h"

#include <algorithm>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/log.h"
#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compare/request/comparison_file.h"
#include "lucarium/compare/request/experiment_rows.h"
#include "lucarium/compare/request/expression.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* paper_schema = "lucarium-paper-1";
constexpr const char* experiment_schema = "lucarium-experiment-1";

std::string required_text(const JsonFile& file, const json& object, const std::string& pointer,
                          const std::string& key) {
  if (!object.contains(key)) file.fail(pointer, fmt::format("\"{}\" is missing", key));
  return file.text(object[key], pointer + "/" + key);
}

std::string optional_text(const JsonFile& file, const json& object, const std::string& pointer,
                          const std::string& key) {
  return object.contains(key) ? file.text(object[key], pointer + "/" + key) : "";
}

class ExperimentReader {
 public:
  ExperimentReader(const fs::path& path, bool quick) : file_(path), quick_(quick) {}

  Experiment read() {
    const json& root = file_.root();
    check_schema(file_, experiment_schema);
    file_.check_keys(
        root, "",
        {"schema", "title", "place", "claim", "differences", "comparison", "quick", "values", "plots", "trends"});
    if (!root.contains("comparison")) file_.fail("", "\"comparison\" is missing");
    Experiment experiment;
    experiment.title = required_text(file_, root, "", "title");
    experiment.place = required_text(file_, root, "", "place");
    experiment.claim = required_text(file_, root, "", "claim");
    experiment.differences = optional_text(file_, root, "", "differences");
    experiment.quick = quick_;
    full_ = read_comparison(file_, root["comparison"], "/comparison");
    check_comparison(full_);
    const ComparisonSpec quick = root.contains("quick") ? quick_comparison() : full_;  // its mistakes are never missed
    run_ = quick_ ? quick : full_;
    experiment.comparison = run_;
    each_row("values", [&](const json& object, const std::string& at, bool takes_part) {
      const ExperimentValue row = value(object, at);
      if (takes_part) experiment.values.push_back(row);
    });
    for (size_t i = 0; i < list("plots").size(); ++i)
      experiment.plots.push_back(plot(list("plots")[i], fmt::format("/plots/{}", i)));
    each_row("trends", [&](const json& object, const std::string& at, bool takes_part) {
      const ExperimentTrend row = trend(object, at);
      if (takes_part) experiment.trends.push_back(row);
    });
    return experiment;
  }

 private:
  /// The comparison as RFC 7396 changes it.
  ComparisonSpec quick_comparison() const {
    json object = file_.root()["comparison"];
    object.merge_patch(file_.root()["quick"]);
    const ComparisonSpec spec = read_comparison(file_, object, "/quick");
    check_comparison(spec);
    return spec;
  }

  const json& list(const std::string& key) const {
    static const json none = json::array();
    if (!file_.root().contains(key)) return none;
    if (!file_.root()[key].is_array()) file_.fail("/" + key, "must be an array");
    return file_.root()[key];
  }

  /// Calls visit(object, pointer, takes part) for what `key` lists, once for each that a row is stated for.
  template <class Visit>
  void each_row(const std::string& key, Visit&& visit) const {
    for (size_t i = 0; i < list(key).size(); ++i) {
      const std::string at = fmt::format("/{}/{}", key, i);
      for (const ExperimentRow& row : experiment_rows(file_, list(key)[i], at, full_, run_))
        visit(row.object, at, row.takes_part);
    }
  }

  ExperimentValue value(const json& object, const std::string& at) {
    file_.check_keys(
        object, at,
        {"name", "label", "unit", "value", "technique", "against", "scene", "budget", "paper", "each", "layer"});
    ExperimentValue result;
    result.name = required_text(file_, object, at, "name");
    result.label = object.contains("label") ? file_.text(object["label"], at + "/label") : result.name;
    result.unit = optional_text(file_, object, at, "unit");
    result.expression = required_text(file_, object, at, "value");
    result.variant = optional_text(file_, object, at, "technique");
    if (!result.variant.empty()) check_label(file_, result.variant, at + "/technique", full_, "technique");
    result.against = optional_text(file_, object, at, "against");
    if (!result.against.empty()) {
      check_label(file_, result.against, at + "/against", full_, "technique");
      if (result.variant.empty()) file_.fail(at + "/against", "needs \"technique\": whose images are compared");
    }
    result.layer = optional_text(file_, object, at, "layer");
    if (!result.layer.empty() && (result.variant.empty() || !result.against.empty()))
      file_.fail(at + "/layer", "needs \"technique\", and no \"against\": it is measured against the reference's");
    result.scene = position(object, at, "scene");
    result.budget = position(object, at, "budget");
    if (object.contains("paper")) result.paper = file_.number(object["paper"], at + "/paper");
    if (!is_expression_name(result.name)) file_.fail(at + "/name", "must be letters, digits and _, a letter first");
    add_name(result.name, at + "/name");
    check_expression(result.expression, at + "/value");
    return result;
  }

  ExperimentPlot plot(const json& object, const std::string& at) {
    file_.check_keys(object, at, {"name", "title", "x_label", "y_label", "x", "y", "techniques", "scenes", "budget"});
    ExperimentPlot result;
    result.name = required_text(file_, object, at, "name");
    if (!is_expression_name(result.name)) file_.fail(at + "/name", "must be letters, digits and _, a letter first");
    result.title = required_text(file_, object, at, "title");
    result.x_label = required_text(file_, object, at, "x_label");
    result.y_label = required_text(file_, object, at, "y_label");
    result.x = required_text(file_, object, at, "x");
    result.y = required_text(file_, object, at, "y");
    check_expression(result.x, at + "/x");
    check_expression(result.y, at + "/y");
    result.budget = position(object, at, "budget");
    result.variants = chosen(object, at, "techniques", "technique");
    for (const std::string& variant : result.variants) add_name(result.slope_name(variant), at + "/name");
    const std::vector<std::string> taking_part = comparison_labels(run_, "scene");
    for (const std::string& scene : chosen(object, at, "scenes", "scene")) {
      if (const auto found = label_position(taking_part, scene)) result.scenes.push_back(*found);
    }
    return result;
  }

  std::vector<std::string> chosen(const json& object, const std::string& at, const std::string& key,
                                  const std::string& kind) const {
    if (!object.contains(key)) return comparison_labels(full_, kind);
    return chosen_labels(file_, object[key], at + "/" + key, full_, kind);
  }

  void add_name(const std::string& name, const std::string& pointer) {
    if (!names_.insert(name).second) file_.fail(pointer, fmt::format("'{}' is given twice", name));
  }

  ExperimentTrend trend(const json& object, const std::string& at) const {
    file_.check_keys(object, at, {"claim", "holds", "each"});
    const ExperimentTrend result{required_text(file_, object, at, "claim"), required_text(file_, object, at, "holds")};
    check_expression(result.expression, at + "/holds");
    for (const std::string& name : expression_names(result.expression)) {
      if (!names_.contains(name)) {
        file_.fail(at + "/holds",
                   fmt::format("no value is called '{}'{}", name, suggest_name(name, {names_.begin(), names_.end()})));
      }
    }
    return result;
  }

  void check_expression(const std::string& expression, const std::string& pointer) const {
    try {
      expression_names(expression);
    } catch (const Error& error) {
      file_.fail(pointer, error.what());
    }
  }

  /// Of a scene or budget: counted from 0, or by its label, which the quick setting may have elsewhere or not at all.
  size_t position(const json& object, const std::string& at, const std::string& kind) const {
    if (!object.contains(kind)) return 0;
    if (object[kind].is_string()) {
      const std::string label = object[kind];
      check_label(file_, label, at + "/" + kind, full_, kind);
      return label_position(comparison_labels(run_, kind), label).value_or(no_position);
    }
    const size_t index = file_.count(object[kind], at + "/" + kind), count = comparison_labels(full_, kind).size();
    if (index >= count) file_.fail(at + "/" + kind, fmt::format("there are {}, numbered from 0", count));
    return index;
  }

  JsonFile file_;
  bool quick_;
  ComparisonSpec full_, run_;  ///< what the full setting compares, and what the one that is wanted does
  std::set<std::string> names_;
};

}  // namespace

std::string ExperimentPlot::slope_name(const std::string& variant) const {
  return name + "_" + expression_name(variant);
}

Paper read_paper(const fs::path& folder) {
  const JsonFile file(folder / "paper.json");
  const json& root = file.root();
  check_schema(file, paper_schema);
  file.check_keys(root, "", {"schema", "citation", "technique", "machine", "experiments"});
  Paper paper;
  paper.name = folder.filename().string();
  paper.folder = folder;
  paper.citation = required_text(file, root, "", "citation");
  paper.technique = optional_text(file, root, "", "technique");
  paper.machine = optional_text(file, root, "", "machine");
  if (!root.contains("experiments") || !root["experiments"].is_array())
    file.fail("/experiments", "must be an array of names");
  for (const json& name : root["experiments"]) paper.experiments.push_back(file.text(name, "/experiments"));
  return paper;
}

Experiment read_experiment(const Paper& paper, const std::string& name, bool quick) {
  if (std::find(paper.experiments.begin(), paper.experiments.end(), name) == paper.experiments.end()) {
    throw_error(ErrorClass::usage, "{} has no experiment '{}'{}; `lucarium reproduce --list` names them", paper.name,
                name, suggest_name(name, paper.experiments));
  }
  Experiment experiment = ExperimentReader(paper.folder / (name + ".json"), quick).read();
  experiment.paper = paper.name;
  experiment.name = name;
  experiment.own = paper.technique.empty();
  return experiment;
}

std::vector<Paper> find_papers(const std::vector<fs::path>& technique_folders) {
  std::vector<Paper> papers;
  for (const fs::path& folder : technique_folders) {
    std::error_code failure;
    for (const fs::directory_entry& entry : list_folder(folder / "experiments", failure)) {
      const std::string name = entry.path().filename().string();
      const bool known =
          std::any_of(papers.begin(), papers.end(), [&](const Paper& paper) { return paper.name == name; });
      if (known || !fs::exists(entry.path() / "paper.json", failure)) continue;
      papers.push_back(read_paper(entry.path()));
    }
  }
  std::sort(papers.begin(), papers.end(), [](const Paper& a, const Paper& b) { return a.name < b.name; });
  return papers;
}

}  // namespace lucarium
