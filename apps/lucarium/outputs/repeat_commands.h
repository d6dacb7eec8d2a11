// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/view/viewer.h"
#include "options/options.h"

namespace lucarium::app {

/// For the viewer: the command lines that render its picture, and that compare its technique at that view, by what they
/// are for.
std::function<std::vector<std::pair<std::string, std::string>>(const ViewedPicture&)> repeat_commands(
    const RenderingArguments& arguments, const Scene& scene);

/// A word for a shell, in quotes where it needs them.
std::string shell_word(const std::string& word);

}  // namespace lucarium::app
