// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/text/nearest_name.h"

#include <doctest/doctest.h>

using namespace lucarium;

TEST_CASE("nearest_name finds a typo and nothing far away") {
  const std::vector<std::string> names = {"max_bounces", "seed", "roulette"};
  CHECK(nearest_name("max_bounce", names) == "max_bounces");
  CHECK(nearest_name("sede", names) == "seed");
  CHECK(nearest_name("temperature", names).empty());
  CHECK(suggest_name("temperature", names) == "; known are max_bounces, seed, roulette");
}
