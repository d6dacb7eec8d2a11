// SPDX-License-Identifier: Apache-2.0
// What may stand at the cursor: scenes, techniques, parameters, experiments. Declared in completion.h.
#include <algorithm>

#include "lucarium/base/text/nearest_name.h"
#include "lucarium/compare/request/experiment.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_folders.h"
#include "manual/completion.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

/// Values of the option in the words, as "--name VALUE" and "--name=VALUE".
std::vector<std::string> values_of(const std::vector<std::string>& words, const std::string& name) {
  std::vector<std::string> values;
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    if (words[i] == name && i + 2 < words.size()) values.push_back(words[i + 1]);
    if (words[i].starts_with(name + "=")) values.push_back(words[i].substr(name.size() + 1));
  }
  return values;
}

/// The technique that parameters at the cursor belong to: the last that was named, else the one that is taken then.
std::string named_technique(const TechniqueRegistry& registry, const std::vector<std::string>& words) {
  std::string name = "path_tracing";
  for (size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string value = words[i].starts_with("--technique=") ? words[i].substr(words[i].find('=') + 1) : words[i];
    const std::string candidate = value.substr(0, value.find(':'));
    const auto has_name = [&](const TechniqueType& type) { return type.info().name == candidate; };
    if (std::any_of(registry.types().begin(), registry.types().end(), has_name)) name = candidate;
  }
  return name;
}

/// "KEY=VALUE,…" that goes on behind `typed`; nothing of a technique that does not exist.
std::vector<Candidate> assignments(const TechniqueRegistry& registry, const std::string& technique,
                                   const std::string& typed) {
  std::vector<Candidate> candidates;
  const size_t begin = typed.rfind(',') + 1;  // 0 without a comma
  const std::string before = typed.substr(0, begin), last = typed.substr(begin), key = last.substr(0, last.find('='));
  for (const TechniqueType& type : registry.types()) {
    if (type.info().name != technique) continue;
    const std::unique_ptr<Technique> instance = type.create();
    for (const ParameterTable::Entry& entry : instance->parameters().entries()) {
      const ParameterInfo& parameter = entry.info;
      if (key.size() == last.size()) {
        candidates.push_back({before + parameter.name + "=", parameter.doc});
      } else if (parameter.name == key) {
        for (const std::string& choice : parameter.choices) candidates.push_back({before + key + "=" + choice, ""});
      }
    }
  }
  return candidates;
}

std::vector<Candidate> techniques(const TechniqueRegistry& registry, const std::string& typed) {
  std::vector<Candidate> candidates;
  if (const size_t colon = typed.find(':'); colon != std::string::npos) {
    candidates = assignments(registry, typed.substr(0, colon), typed.substr(colon + 1));
    for (Candidate& candidate : candidates) candidate.name = typed.substr(0, colon + 1) + candidate.name;
  } else {
    for (const TechniqueType& type : registry.types()) candidates.push_back({type.info().name, type.info().summary});
  }
  return candidates;
}

std::vector<Candidate> experiments(const std::vector<fs::path>& folders) {
  std::vector<Candidate> candidates;
  for (const Paper& paper : find_papers(technique_folders(folders))) {
    candidates.push_back({paper.name, paper.citation});
    for (const std::string& name : paper.experiments)
      candidates.push_back({paper.name + "/" + name, read_experiment(paper, name, false).title});
  }
  return candidates;
}

}  // namespace

std::vector<Candidate> complete(const std::string& kind, const std::vector<std::string>& words) {
  const std::string typed = words.empty() ? "" : words.back();
  const std::vector<std::string> named = values_of(words, "--technique-path");
  const std::vector<fs::path> folders(named.begin(), named.end());
  std::vector<Candidate> candidates;
  if (kind == "scene") {
    for (const std::string& name : builtin_scene_names()) {
      candidates.push_back({"builtin:" + name, ""});
      if (!typed.starts_with("builtin:" + name + ":")) continue;
      for (const BuiltinParameter& parameter : builtin_scene_parameters(name))
        candidates.push_back({"builtin:" + name + ":" + parameter.name + "=", parameter.doc});
    }
  } else if (kind == "technique") {
    candidates = techniques(TechniqueRegistry(folders), typed);
  } else if (kind == "parameter") {
    const TechniqueRegistry registry(folders);
    candidates = assignments(registry, named_technique(registry, words), typed);
  } else if (kind == "experiment") {
    candidates = experiments(folders);
  } else {
    throw_error(ErrorClass::usage, "nothing is completed as '{}'{}", kind,
                suggest_name(kind, {"scene", "technique", "parameter", "experiment"}));
  }
  const auto differs = [&](const Candidate& candidate) { return !candidate.name.starts_with(typed); };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), differs), candidates.end());
  return candidates;
}

}  // namespace lucarium::app
