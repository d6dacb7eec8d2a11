// SPDX-License-Identifier: Apache-2.0
// What bundle_exchange says of parameters that have no effect, and of an exchange without an end.
#include <doctest/doctest.h>

#include <algorithm>

#include "bundle_exchange/bundle_plan.h"
#include "bundle_exchange/declaration.h"
#include "lucarium/scene/load/load_scene.h"
#include "saved_state.h"
#include "technique_rig.h"

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

TEST_CASE("an exchange without a limit goes on where one with many directions does, bit for bit, and never converges") {
  const test::Options few = {{"texels", "1024"}, {"direct_mode", "exchange"}};
  const auto image = [&](const test::Options& more) {
    const auto run = test::session("bundle_exchange", load_scene("builtin:cornell"), -1, test::with(few, more));
    run->run({.iterations = 60});
    CHECK_FALSE(run->last().converged);
    return std::pair(run->last().progress, run->resolve().image());
  };
  const auto limited = image({{"directions", "1000000"}, {"stop_error", "0"}});
  const auto endless = image({{"directions", "0"}, {"stop_error", "0"}, {"camera_samples", "0"}});
  CHECK(limited.second == endless.second);
  CHECK(limited.first > 0);
  CHECK(endless.first == -1);  // no part of a known amount of work
}

TEST_CASE("light that is accurate ends an exchange without a limit; its pixels go on where no number is wanted") {
  const auto run =
      test::session("bundle_exchange", load_scene("builtin:cornell"), -1,
                    {{"texels", "512"}, {"directions", "0"}, {"stop_error", "0.2"}, {"camera_samples", "0"}});
  CHECK_FALSE(run->finish_light());
  run->run({.iterations = 3});
  CHECK(run->last().light_done);
  CHECK_FALSE(run->last().converged);
  CHECK(run->last().progress == -1);
}

TEST_CASE("a time is used to its end; what divides a number of directions keeps that, and what shows a preview ends") {
  using Values = std::vector<std::pair<std::string, std::string>>;
  const auto lifted = [](auto&& set) {
    Parameters parameters;
    set(parameters);
    return endless(parameters);
  };
  const Values pixels = {{"camera_samples", "0"}};
  CHECK(lifted([](Parameters&) {}) == Values{{"directions", "0"}, {"stop_error", "0"}, {"camera_samples", "0"}});
  CHECK(lifted([](Parameters& p) { p.preview = true; }) == pixels);
  CHECK(lifted([](Parameters& p) { p.interleave = Interleave::pingpong; }) == pixels);
  CHECK(lifted([](Parameters& p) { p.interleave = Interleave::fixed; }) == pixels);
  CHECK(lifted([](Parameters& p) { p.sequence = DirectionOrder::hammersley; }) == pixels);
}

TEST_CASE("without a number of directions nothing is divided among them, and no state waits for their end") {
  for (const test::Options& divided :
       {test::Options{{"interleave", "fixed"}}, {{"interleave", "pingpong"}}, {{"sequence", "hammersley"}}}) {
    const test::Options options = test::with(divided, {{"directions", "0"}});
    test::check_refusal([&] { test::session("bundle_exchange", load_scene("builtin:cornell"), -1, options); },
                        ErrorClass::usage, "set directions to 1 or more");
  }
  Parameters parameters;
  parameters.directions = 0;
  CHECK(state_refusal(parameters).find("set them to 1 or more") != std::string::npos);
  parameters.directions = 1;
  CHECK(state_refusal(parameters).empty());
}
