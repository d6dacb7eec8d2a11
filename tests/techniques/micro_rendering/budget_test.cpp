// SPDX-License-Identifier: Apache-2.0
// What micro_rendering does for a budget of time: a cost that savings lower, and a picture before all light is there.
#include <doctest/doctest.h>

#include "micro_rendering/cost.h"
#include "technique_fixture.h"

using namespace lucarium;
using namespace lucarium::micro;

TEST_CASE("every saving is one: with each value the estimate falls, or stays where the parameter is of no use") {
  const Scene scene = load_scene("builtin:cornell");
  const RenderSettings settings = test::settings_for(scene, 64, 3);
  for (const std::string way : {"jacobi", "instant_radiosity", "photon_map"}) {
    MicroParameters parameters;
    ParameterTable table = make_parameter_table(parameters);
    table.set("multibounce", way);
    const auto seconds = [&] { return estimate_seconds(parameters, scene, settings, ComputePower()); };
    const double whole = seconds();
    for (const bool last_resort : {false, true}) {
      for (const ParameterSaving& saving : savings()) {
        if (saving.last_resort != last_resort) continue;
        for (const std::string& value : saving.values) {
          CAPTURE(saving.parameter);
          CAPTURE(value);
          const double before = seconds();
          table.set(saving.parameter, value);
          CHECK(seconds() <= before);
        }
      }
    }
    CHECK(seconds() < whole / 10);
  }
}

TEST_CASE("direct light is seen while light at the points is not there yet, and the frame's bits are the same") {
  Scene scene = load_scene("builtin:cornell");
  const RenderSettings settings = test::settings_for(scene, 16, 3);
  const auto device = Device::open();
  const auto session = [&](const char* batch) {
    return std::make_unique<RenderSession>(device, scene, test::registry().find("micro_rendering"), settings,
                                           test::Parameters{{"points_log2", "11"},
                                                            {"micro_size", "8"},
                                                            {"jacobi_level", "8"},
                                                            {"batch_gathers", batch},
                                                            {"eye_share", "0"}});
  };
  const auto layer = [](RenderSession& of, const char* name) { return of.resolve().find(name)->pixels; };
  const auto whole = session("16384"), parts = session("64");
  CHECK(whole->iterate().samples == 1);

  const IterationResult first = parts->iterate();
  CHECK(first.samples == 0);
  CHECK(first.phase == "light");
  CHECK(first.visible);
  CHECK(layer(*parts, "direct") == layer(*whole, "direct"));
  CHECK(test::mean(layer(*parts, "indirect")) == 0);
  while (parts->last().samples == 0) parts->iterate();
  for (const char* name : {"emission", "direct", "indirect"}) CHECK(layer(*parts, name) == layer(*whole, name));

  // After a restart there is nothing to see until it is found again.
  parts->restart(2);
  whole->restart(2);
  CHECK(parts->iterate().visible);
  while (parts->last().samples == 0) parts->iterate();
  whole->iterate();
  CHECK(layer(*parts, "direct") == layer(*whole, "direct"));
}
