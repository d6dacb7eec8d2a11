// SPDX-License-Identifier: Apache-2.0
// What results.json says about parameters.
#include <doctest/doctest.h>

#include "lucarium/base/json.h"
#include "small_comparison.h"

using namespace lucarium;
using nlohmann::json;

TEST_CASE("results.json named only the parameters that were given, not those in effect") {
  test::SmallComparison comparison;
  comparison.spec.variants.push_back({"path_tracing", {{"roulette_start", "7"}}, "late"});
  const ComparisonResult result = comparison.run();
  const json results = json::parse(comparison.results());

  const std::unique_ptr<Technique> technique = comparison.registry.find("path_tracing").create();
  for (const size_t variant : {0, 1}) {
    CAPTURE(variant);
    if (variant == 1) technique->parameters().set("roulette_start", "7");
    const json& entry = results["variants"][variant];
    CHECK(entry["given"] == (variant == 0 ? json::array() : json::array({"roulette_start"})));
    CHECK(entry["parameters"].size() == technique->parameters().entries().size());
    for (const ParameterTable::Entry& parameter : technique->parameters().entries())
      CHECK(entry["parameters"].at(parameter.info.name) == parameter.get());
    CHECK(results["pieces"][variant]["parameters"] == technique->parameters().to_string());
  }
}
