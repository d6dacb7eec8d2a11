// SPDX-License-Identifier: Apache-2.0
// Plans for a budget of time, over a technique whose cost is a formula.
#include "lucarium/technique/budget_plan.h"

#include <doctest/doctest.h>

#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/technique/technique_base.h"
#include "tolerance.h"

using namespace lucarium;

namespace {

struct Options {
  int points = 800, edge = 24, step = 1, depth = 4, rounds = 100;
  float accuracy = 0.5f;
  template <class V>
  void describe(V& v) {
    v.number("points", points, 1, 1000, "", "of the test");
    v.number("edge", edge, 1, 64, "", "of the test");
    v.number("step", step, 1, 8, "", "of the test");
    v.number("depth", depth, 1, 8, "", "of the test");
    v.number("rounds", rounds, 0, 1000, "", "of the test; 0: no limit");
    v.number("accuracy", accuracy, 0.f, 1.f, "", "of the test; 0: none");
    v.presets({{"coarse", {{"edge", "20"}}}}, "of the test");
  }
};

/// Takes points / 10 s of the host and edge² / step² / 10 s of the device.
class Priced : public TechniqueBase<Options> {
 public:
  PathSet path_set(const Scene&, const RenderSettings&) const override {
    PathSet set;
    set.max_bounces = parameters_.depth;
    return set;
  }
  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override { return {}; }
  size_t estimate_bytes(const Scene&, const RenderSettings&) const override { return 0; }
  double estimate_seconds(const Scene&, const RenderSettings&, const ComputePower& power) const override {
    const double edge = static_cast<double>(parameters_.edge) / parameters_.step;
    return free ? 0 : (parameters_.points / power.host + edge * edge / power.device) / 10 * parameters_.depth / 4;
  }
  std::vector<ParameterSaving> savings(const Scene&, const RenderSettings&) const override {
    return {{"step", {"2", "4"}, true},
            {"points", {"900", "760", "400", "200", "100"}},
            {"edge", {"16", "8"}},
            {"depth", {"1"}}};  // other light paths
  }
  std::vector<std::pair<std::string, std::string>> endless() const override {
    return {{"rounds", "0"}, {"accuracy", "0"}};
  }
  bool free = false;

 protected:
  void build() override {}
  void restart() override {}
  bool step() override { return true; }
  void write(Film& film) override { film.layer("priced", {"R", "G", "B"}, true); }
  void warm_up_kernels() override {}
};

using Parameters = std::vector<std::pair<std::string, std::string>>;

struct Planned {
  BudgetPlan plan;
  std::string parameters;
  int points, edge, step;
};

Planned planned(const TimeBudget& time, const Parameters& given = {}, ComputePower power = {}) {
  Priced technique;
  technique.parameters().set_all(given);
  const BudgetPlan plan = plan_budget(technique, given, make_builtin_scene("furnace"), RenderSettings(), power, time);
  const auto number = [&](const char* name) { return std::stoi(technique.parameters().get(name)); };
  return {plan, technique.parameters().to_string(), number("points"), number("edge"), number("step")};
}

Planned planned(double seconds, const Parameters& given = {}, ComputePower power = {}) {
  return planned(TimeBudget{seconds, false}, given, power);
}

bool has_limits(const Planned& now) {
  return now.parameters.find("rounds=0") == std::string::npos &&
         now.parameters.find("accuracy=0.5") != std::string::npos;
}

}  // namespace

TEST_CASE("a budget that is long enough changes nothing") {
  const Planned rich = planned(1e6);
  CHECK(rich.plan.changes.empty());
  CHECK(rich.plan.changes_text().empty());
  CHECK(rich.plan.fits());
  CHECK(rich.parameters == "preset=default,points=800,edge=24,step=1,depth=4,rounds=100,accuracy=0.5");
  CHECK(rich.plan.lifted.empty());
  CHECK(rich.plan.expected_seconds == rich.plan.default_seconds);
}

TEST_CASE("with less time no parameter grows, and what is planned is what the technique has") {
  Planned before = planned(1e6);
  for (double seconds = 500; seconds > 0.5; seconds *= 0.9) {
    CAPTURE(seconds);
    const Planned now = planned(seconds);
    CHECK(now.points <= before.points);
    CHECK(now.edge <= before.edge);
    CHECK(now.step >= before.step);
    CHECK(now.plan.expected_seconds <= before.plan.expected_seconds);
    CHECK(now.parameters == planned(seconds).parameters);
    for (const BudgetPlan::Change& change : now.plan.changes)
      CHECK(now.parameters.find("," + change.parameter + "=" + change.to) != std::string::npos);
    if (now.points > 100) CHECK(now.step == 1);  // the last resort comes last
    before = now;
  }
  CHECK(before.points == 100);
  CHECK(before.step > 1);
}

TEST_CASE("a picture takes half of its budget, or says which budget would do") {
  const Planned enough = planned(60);
  CHECK(enough.plan.expected_seconds <= 30);
  CHECK(enough.plan.changes_text().find("points 800 -> ") == 0);
  const Planned poor = planned(1);
  CHECK_FALSE(poor.plan.fits());
  CHECK(poor.plan.sufficient_seconds > 1);
  const Planned sufficient = planned(poor.plan.sufficient_seconds);
  CHECK(sufficient.plan.fits());
  CHECK(sufficient.plan.expected_seconds == test::relative(sufficient.plan.sufficient_seconds / 2));
}

TEST_CASE("seconds of computing have no start of the program in them") {
  const Planned quick = planned(0.9, {{"points", "1"}, {"edge", "1"}});  // takes 0.2 s
  CHECK(quick.plan.fits());
  CHECK(quick.plan.changes.empty());
}

TEST_CASE("what the user gave, himself or by a preset, which gives all parameters, is left alone") {
  CHECK(planned(1, {{"points", "700"}}).points == 700);
  CHECK(planned(1, {{"points", "800"}}).points == 800);  // the default, but given
  const Planned preset = planned(1, {{"preset", "coarse"}});
  CHECK(preset.edge == 20);
  CHECK(preset.points == 800);
  CHECK(preset.plan.changes.empty());
  CHECK(preset.parameters.find("preset=coarse") == 0);
  CHECK(planned(1, {{"preset", "default"}}).points == 800);
}

TEST_CASE("a value that saves too little does not hide those after it") {
  // 760 points save a twentieth; 400 were never tried behind them.
  const Planned now = planned(100, {{"edge", "1"}});
  CHECK(now.points == 400);
  CHECK(now.step == 1);
}

TEST_CASE("a plan keeps the light paths, for which the reference is rendered") {
  CHECK(planned(0.1).parameters.find("depth=4") != std::string::npos);
}

TEST_CASE("more cores, fewer changes; nothing is planned for a technique that names no time") {
  CHECK(planned(30, {}, {8, 8}).points > planned(30).points);
  Priced technique;
  technique.free = true;
  const BudgetPlan plan =
      plan_budget(technique, {}, make_builtin_scene("furnace"), RenderSettings(), ComputePower(), {0.1});
  CHECK(plan.budget_seconds == 0);
  CHECK(plan.changes.empty());
}

TEST_CASE("a budget that must be used to its end lifts all limits, or none where the user gave one") {
  for (const double seconds : {0.0, 1.0, 1e6}) {
    CAPTURE(seconds);
    const Planned lifted = planned({seconds, true});
    CHECK(lifted.parameters.find("rounds=0,accuracy=0") != std::string::npos);
    REQUIRE(lifted.plan.lifted.size() == 2);
    CHECK(lifted.plan.lifted[0].parameter == "rounds");
    CHECK(lifted.plan.lifted[0].from == "100");
    CHECK(lifted.plan.lifted[1].to == "0");
    for (const BudgetPlan::Change& change : lifted.plan.changes) CHECK(change.parameter != "rounds");  // not lowered
    CHECK(has_limits(planned({seconds, false})));
    CHECK(has_limits(planned({seconds, true}, {{"rounds", "100"}})));
    CHECK(has_limits(planned({seconds, true}, {{"accuracy", "0.5"}})));
    CHECK(has_limits(planned({seconds, true}, {{"preset", "default"}})));
    CHECK_FALSE(has_limits(planned({seconds, true}, {{"points", "700"}})));
    const Planned other = planned({seconds, true}, {{"accuracy", "0"}});  // given, and no limit
    CHECK(other.parameters.find("rounds=0,accuracy=0") != std::string::npos);
    CHECK(other.plan.lifted.size() == 1);
  }
}

TEST_CASE("limits are lifted for a technique that names no time, and without a budget of time nothing is lowered") {
  Priced technique;
  technique.free = true;
  const BudgetPlan plan =
      plan_budget(technique, {}, make_builtin_scene("furnace"), RenderSettings(), ComputePower(), {0.1, true});
  CHECK(plan.lifted.size() == 2);
  CHECK(planned({0, true}).plan.changes.empty());
  CHECK(planned({0, true}).points == 800);
}
