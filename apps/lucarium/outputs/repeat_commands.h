// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/view/viewer.h"
#include "options/options.h"

namespace lucarium::app {

/// For the viewer: the command lines that render its picture, and that compare its techniques at that view with as many
/// iterations; files for `lucarium compare --comparison` and to lie beside the scene.
RepeatCommands repeat_commands(const RenderingArguments& arguments, const Scene& scene);

/// What was said at the start, and what a page has changed since.
SceneOverrides edited_overrides(SceneOverrides overrides, const SceneEdits& edits);

/// A word for a shell, in quotes where it needs them.
std::string shell_word(const std::string& word);

}  // namespace lucarium::app
