// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <memory>

#include "lucarium/technique/state_file.h"
#include "options/options.h"

namespace lucarium::app {

/// --save-state, --load-state, --compress-state
struct StateArguments {
  std::filesystem::path save_file, load_file;
  bool compress = false;
  bool has_seed = false, has_bounces = false;  ///< --seed and --max-bounces are on the command line
  void add_to(Command command);
  bool any() const { return !save_file.empty() || !load_file.empty(); }
  /// The state to begin with, or null.
  std::unique_ptr<StateFile> open() const;
  /// Seed and bounces of the state, where the command line has none.
  void apply_to(RenderSettings& settings, const StateFile& state) const;
};

/// What `state` was saved with, where the command line says nothing else: its technique; and its parameters, of which
/// those of the view give way to a preset.
TechniqueArguments::Spec spec_of_state(const TechniqueArguments& arguments, const TechniqueRegistry& registry,
                                       const StateFile& state);

/// Throws Error{usage} unless the technique has a state with these parameters.
void check_state(const TechniqueType& type, const TechniqueArguments::Spec& spec);

}  // namespace lucarium::app
