// SPDX-License-Identifier: Apache-2.0
// What micro_rendering says of parameters that have no effect.
#include "micro_rendering/declaration.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lucarium;
using namespace lucarium::micro;

namespace {

bool lists(const MicroParameters& parameters, const RenderSettings& settings, const std::string& part) {
  const std::vector<std::string> list = limitations(parameters, Scene{}, settings);
  return std::any_of(list.begin(), list.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace

TEST_CASE("inspecting a pixel outside the image, or one without gathers, is a limitation") {
  RenderSettings settings;
  settings.width = 32, settings.height = 16, settings.max_bounces = 1;
  MicroParameters parameters;
  CHECK_FALSE(lists(parameters, settings, "micro-buffer"));
  parameters.inspect_x = 31, parameters.inspect_y = 15;
  CHECK_FALSE(lists(parameters, settings, "micro-buffer"));
  settings.max_bounces = 0;
  CHECK(lists(parameters, settings, "nothing is gathered"));
  settings.max_bounces = 1;
  parameters.inspect_y = 16;
  CHECK(lists(parameters, settings, "inspect_x=31, inspect_y=16 is not a pixel of 32×16"));
  parameters.inspect_y = -1;
  CHECK(lists(parameters, settings, "is not a pixel"));
}
