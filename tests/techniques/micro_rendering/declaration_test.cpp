// SPDX-License-Identifier: Apache-2.0
// What micro_rendering says of parameters that have no effect.
#include "micro_rendering/declaration.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lucarium;
using namespace lucarium::micro;

namespace {

bool tells(const MicroParameters& parameters, const RenderSettings& settings, const std::string& part) {
  const std::vector<std::string> list = limitations(parameters, Scene{}, settings);
  return std::any_of(list.begin(), list.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

}  // namespace

TEST_CASE("a pixel that is not there, or gathers nothing, is told where it is to be inspected") {
  RenderSettings settings;
  settings.width = 32, settings.height = 16, settings.max_bounces = 1;
  MicroParameters parameters;
  CHECK_FALSE(tells(parameters, settings, "micro-buffer"));
  parameters.inspect_x = 31, parameters.inspect_y = 15;
  CHECK_FALSE(tells(parameters, settings, "micro-buffer"));
  settings.max_bounces = 0;
  CHECK(tells(parameters, settings, "nothing is gathered"));
  settings.max_bounces = 1;
  parameters.inspect_y = 16;
  CHECK(tells(parameters, settings, "inspect_x=31, inspect_y=16 is no pixel of 32×16"));
  parameters.inspect_y = -1;
  CHECK(tells(parameters, settings, "is no pixel"));
}
