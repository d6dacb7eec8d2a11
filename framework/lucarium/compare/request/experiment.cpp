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
    file_.check_keys(root, "",
                     {"schema", "title", "place", "claim", "differences", "comparison", "quick", "values", "trends"});
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
    experiment.comparison = quick_ ? quick : full_;
    for (size_t i = 0; i < list("values").size(); ++i) experiment.values.push_back(value(i));
    for (size_t i = 0; i < list("trends").size(); ++i) experiment.trends.push_back(trend(i));
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

  ExperimentValue value(size_t index) {
    const json& object = list("values")[index];
    const std::string at = fmt::format("/values/{}", index);
    file_.check_keys(object, at,
                     {"name", "label", "unit", "value", "technique", "against", "scene", "budget", "paper"});
    ExperimentValue result;
    result.name = required_text(file_, object, at, "name");
    result.label = object.contains("label") ? file_.text(object["label"], at + "/label") : result.name;
    result.unit = optional_text(file_, object, at, "unit");
    result.expression = required_text(file_, object, at, "value");
    result.variant = optional_text(file_, object, at, "technique");
    if (!result.variant.empty()) check_variant(result.variant, at + "/technique");
    result.against = optional_text(file_, object, at, "against");
    if (!result.against.empty()) {
      check_variant(result.against, at + "/against");
      if (result.variant.empty()) file_.fail(at + "/against", "needs \"technique\": whose images are compared");
    }
    result.scene = position(object, at, "scene", full_.scenes.size());
    result.budget = position(object, at, "budget", full_.budgets.size());
    if (object.contains("paper")) result.paper = file_.number(object["paper"], at + "/paper");
    if (!is_expression_name(result.name)) file_.fail(at + "/name", "must be letters, digits and _, a letter first");
    if (!names_.insert(result.name).second) file_.fail(at + "/name", fmt::format("'{}' is given twice", result.name));
    check_expression(result.expression, at + "/value");
    return result;
  }

  ExperimentTrend trend(size_t index) const {
    const json& object = list("trends")[index];
    const std::string at = fmt::format("/trends/{}", index);
    file_.check_keys(object, at, {"claim", "holds"});
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

  void check_variant(const std::string& label, const std::string& pointer) const {
    std::vector<std::string> labels;
    for (const TechniqueVariant& variant : full_.variants) labels.push_back(variant.label());
    if (std::find(labels.begin(), labels.end(), label) == labels.end()) {
      file_.fail(pointer, fmt::format("no technique has the label '{}'{}", label, suggest_name(label, labels)));
    }
  }

  /// A position in a list, counted from 0.
  size_t position(const json& object, const std::string& at, const std::string& key, size_t count) const {
    if (!object.contains(key)) return 0;
    const size_t index = file_.count(object[key], at + "/" + key);
    if (index >= count) file_.fail(at + "/" + key, fmt::format("there are {}, numbered from 0", count));
    return index;
  }

  JsonFile file_;
  bool quick_;
  ComparisonSpec full_;
  std::set<std::string> names_;
};

}  // namespace

Paper read_paper(const fs::path& folder) {
  const JsonFile file(folder / "paper.json");
  const json& root = file.root();
  check_schema(file, paper_schema);
  file.check_keys(root, "", {"schema", "citation", "technique", "machine", "experiments"});
  Paper paper;
  paper.name = folder.filename().string();
  paper.folder = folder;
  paper.citation = required_text(file, root, "", "citation");
  paper.technique = required_text(file, root, "", "technique");
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
