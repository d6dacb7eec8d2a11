// SPDX-License-Identifier: Apache-2.0
#include "options/state_arguments.h"

#include <algorithm>

#include "lucarium/session/saved_state.h"

namespace lucarium::app {

void StateArguments::add_to(Command command) {
  command.option("--save-state", save_file).default_text("none");
  command.flag("--compress-state", compress);
  command.option("--load-state", load_file).default_text("none");
  command.needs({"--compress-state"}, {"--save-state"});
  command.excludes({"--load-state"}, {"--save-state"});
  command.excludes({"--watch"}, {"--save-state", "--load-state"});
}

std::unique_ptr<StateFile> StateArguments::open() const {
  return load_file.empty() ? nullptr : std::make_unique<StateFile>(load_file);
}

void StateArguments::apply_to(RenderSettings& settings, const StateFile& state) const {
  if (!has_seed) settings.seed = state.header().seed;
  if (!has_bounces) settings.max_bounces = state.header().max_bounces;
}

TechniqueArguments::Spec spec_of_state(const TechniqueArguments& arguments, const TechniqueRegistry& registry,
                                       const StateFile& state) {
  const StateHeader& saved = state.header();
  TechniqueArguments::Spec spec = arguments.single("render", saved.technique);
  if (spec.name != saved.technique) return spec;  // which is refused with the reason
  const bool has_preset = std::any_of(spec.parameters.begin(), spec.parameters.end(),
                                      [](const auto& parameter) { return parameter.first == "preset"; });
  const std::vector<std::string> free = registry.find(spec.name).create()->parameters_of_view();
  TechniqueArguments::Parameters parameters;
  for (const auto& parameter : saved.parameters) {
    const bool of_view = std::find(free.begin(), free.end(), parameter.first) != free.end();
    if (!of_view || !has_preset) parameters.push_back(parameter);
  }
  parameters.insert(parameters.end(), spec.parameters.begin(), spec.parameters.end());
  return {spec.name, std::move(parameters)};
}

void check_state(const TechniqueType& type, const TechniqueArguments::Spec& spec) {
  const std::unique_ptr<Technique> technique = type.create();
  technique->parameters().set_all(spec.parameters);
  require_state(type.info(), *technique);
}

}  // namespace lucarium::app
