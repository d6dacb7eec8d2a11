// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/saved_state.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/version.h"

namespace lucarium {

namespace {

/// All parameters but `preset`, which only sets others.
std::vector<std::pair<std::string, std::string>> parameters_of(Technique& technique) {
  std::vector<std::pair<std::string, std::string>> parameters;
  for (const ParameterTable::Entry& entry : technique.parameters().entries())
    if (entry.presets.empty()) parameters.emplace_back(entry.info.name, entry.get());
  return parameters;
}

/// The value of one name, or a text that no value is.
std::string value_in(const std::vector<std::pair<std::string, std::string>>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.first == name; });
  return found == parameters.end() ? "(none)" : found->second;
}

void require_same_parameters(const StateFile& state, Technique& technique) {
  const std::vector<std::string> free = technique.parameters_of_view();
  const auto own = parameters_of(technique);
  const auto& saved = state.header().parameters;
  const auto compare = [&](const std::string& name) {
    if (std::find(free.begin(), free.end(), name) != free.end()) return;
    const std::string was = value_in(saved, name), is = value_in(own, name);
    if (was != is)
      throw_error(ErrorClass::usage,
                  "{}: it was saved with {}={}, here it is {}; give -p {}={}, or save the state again",
                  state.path().string(), name, was, is, name, was);
  };
  for (const auto& [name, value] : own) compare(name);
  for (const auto& [name, value] : saved) compare(name);
}

}  // namespace

StateHeader state_header(const TechniqueInfo& info, Technique& technique, const Scene& scene,
                         const RenderSettings& settings) {
  StateHeader header;
  header.program_version = LUCARIUM_VERSION;
  header.scene = scene.source;
  header.scene_hash = scene.hash().hex();
  header.technique = info.name;
  header.technique_version = info.version;
  header.parameters = parameters_of(technique);
  header.path_set = technique.path_set(scene, settings).to_string();
  header.max_bounces = settings.max_bounces;
  header.seed = settings.seed;
  header.width = settings.width;
  header.height = settings.height;
  return header;
}

void require_state(const TechniqueInfo& info, const Technique& technique) {
  if (const std::string reason = technique.state_refusal(); !reason.empty())
    throw_error(ErrorClass::usage, "{} has no state to save or load: it {}", info.name, reason);
}

void require_same(const StateFile& state, const TechniqueInfo& info, Technique& technique, const Scene& scene,
                  const RenderSettings& settings) {
  const StateHeader& saved = state.header();
  const std::string file = state.path().string();
  if (saved.technique != info.name)
    throw_error(ErrorClass::usage, "{}: it is a state of {}, not of {}; give -t {}", file, saved.technique, info.name,
                saved.technique);
  require_state(info, technique);
  if (saved.technique_version != info.version)
    throw_error(ErrorClass::input, "{}: it is of {} {}, here is version {}; save the state again", file, info.name,
                saved.technique_version, info.version);
  require_same_parameters(state, technique);
  if (saved.max_bounces != settings.max_bounces)
    throw_error(ErrorClass::usage, "{}: it was saved with --max-bounces {}; give that", file, saved.max_bounces);
  if (saved.seed != settings.seed)
    throw_error(ErrorClass::usage, "{}: it was saved with --seed {}; give that, or leave --seed out", file, saved.seed);
  if (saved.scene_hash != scene.hash().hex())
    throw_error(ErrorClass::input,
                "{}: it belongs to another scene ({}), or to this one as it was; save the state again", file,
                saved.scene);
  if (saved.path_set != technique.path_set(scene, settings).to_string())
    throw_error(ErrorClass::input, "{}: it holds other light paths ({}); save the state again", file, saved.path_set);
}

}  // namespace lucarium
