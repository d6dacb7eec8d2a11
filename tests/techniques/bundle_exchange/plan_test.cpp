// SPDX-License-Identifier: Apache-2.0
// What bundle_exchange says of parameters that have no effect.
#include <doctest/doctest.h>

#include <algorithm>

#include "bundle_exchange/bundle_plan.h"

using namespace lucarium;
using namespace lucarium::bundle;

TEST_CASE("preview and warm_start without forgetting senders are listed as limitations") {
  const auto listed = [](const Parameters& parameters) {
    const std::vector<std::string> list = limitations(parameters, Scene{}, {});
    return std::count_if(list.begin(), list.end(), [](const std::string& line) {
      return line.find("it needs interleave=sd") != std::string::npos;
    });
  };
  Parameters parameters;
  parameters.preview = parameters.warm_start = true;
  CHECK(listed(parameters) == 0);
  parameters.interleave = Interleave::pingpong;
  CHECK(listed(parameters) == 2);
  parameters.interleave = Interleave::fixed;
  parameters.warm_start = false;
  CHECK(listed(parameters) == 1);
}
