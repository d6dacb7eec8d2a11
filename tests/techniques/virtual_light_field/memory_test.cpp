// SPDX-License-Identifier: Apache-2.0
// Memory that the experiment `propagation` reports, in bytes.
#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "cli_support.h"
#include "lucarium/compare/request/expression.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("the experiment's formula gives the bytes of Table 1 for the paper's elements") {
  // Mortensen et al. 2007, Table 1: diffuse and non-diffuse elements.
  constexpr double elements[4][2] = {{34816, 931136}, {816640, 0}, {905984, 0}, {2434560, 7629824}};
  std::ifstream file(environment("LUCARIUM_TEST_SOURCE") +
                     "/techniques/virtual_light_field/experiments/mortensen2007/propagation.json");
  const nlohmann::json experiment = nlohmann::json::parse(file);
  int found = 0;
  for (const auto& value : experiment.at("values")) {
    const std::string expression = value.at("value");
    if (expression.find("counter_sides") == std::string::npos) continue;
    const auto& counts = elements[value.at("scene").get<size_t>()];
    const ExpressionScope scope{{{"counter_sides", counts[0]}, {"counter_cells", counts[1]}}, {}};
    CAPTURE(expression);
    CHECK(evaluate_expression(expression, scope) == doctest::Approx(value.at("paper").get<double>()).epsilon(0.025));
    ++found;
  }
  CHECK(found == 8);
}
