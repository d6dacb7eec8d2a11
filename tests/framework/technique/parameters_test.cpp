// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/parameters.h"

#include <doctest/doctest.h>

#include <functional>

#include "lucarium/services/path_set.h"

using namespace lucarium;

namespace {

enum class Mode { fast, exact };

struct Example {
  int bounces = 4;
  float radius = 0.5f;
  bool filter = true;
  Mode mode = Mode::exact;
  template <class V>
  void describe(V& v) {
    v.number("bounces", bounces, 0, 16, "", "how many");
    v.number("radius", radius, 0.f, 2.f, "m", "how wide");
    v.flag("filter", filter, "smooth it");
    v.choice("mode", mode, {{"fast", Mode::fast}, {"exact", Mode::exact}}, "how well");
  }
};

struct Grouped : Example {
  std::vector<std::string> named = {"bounces", "mode"};
  template <class V>
  void describe(V& v) {
    Example::describe(v);
    v.presets({{"quick", {{"mode", "fast"}}}}, "values for drafts");
    v.basic(named);
  }
};

struct Fine {
  float width = 0.3f;
  double clamp = 1.0 / 3;
  template <class V>
  void describe(V& v) {
    v.number("width", width, 0.1f, 0.7f, "m", "");
    v.number("clamp", clamp, 0.0, 1e30, "", "");
  }
};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::usage);
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("parameters are read and written as text, with the member initialisers as defaults") {
  Example example;
  ParameterTable table = make_parameter_table(example);
  CHECK(table.to_string() == "bounces=4,radius=0.5,filter=on,mode=exact");
  table.set("bounces", "7");
  table.set("radius", "1e-1");
  table.set("filter", "off");
  table.set("mode", "fast");
  CHECK(example.bounces == 7);
  CHECK(example.radius == 0.1f);
  CHECK_FALSE(example.filter);
  CHECK(example.mode == Mode::fast);
  CHECK(table.entries()[0].info.default_value == "4");
  CHECK(table.entries()[1].info.range == "0 … 2");
  CHECK(table.entries()[3].info.range == "fast|exact");
}

TEST_CASE("numbers survive their text, and the limits' own texts are inside") {
  Fine fine, again;
  ParameterTable table = make_parameter_table(fine), copy = make_parameter_table(again);
  CHECK(table.get("width") == "0.3");
  for (const char* text : {"0.1", "0.7", "0.123456789"}) {
    table.set("width", text);
    copy.set("width", table.get("width"));
    CHECK(again.width == fine.width);
  }
  again.clamp = 0;
  copy.set("clamp", table.get("clamp"));
  CHECK(again.clamp == 1.0 / 3);
  CHECK(message_of([&] { table.set("width", "0.70001"); }) == "parameter width: 0.70001 is outside 0.1 … 0.7");
}

TEST_CASE("mistakes name the parameter, the range or the nearest name") {
  Example example;
  ParameterTable table = make_parameter_table(example);
  CHECK(message_of([&] { table.set("bounce", "1"); }) == "no parameter is called 'bounce'; did you mean 'bounces'?");
  CHECK(message_of([&] { table.set("bounces", "17"); }) == "parameter bounces: 17 is outside 0 … 16");
  CHECK(message_of([&] { table.set("bounces", "1.5"); }) == "parameter bounces: '1.5' is not a whole number");
  CHECK(message_of([&] { table.set("radius", "wide"); }) == "parameter radius: 'wide' is not a number");
  CHECK(message_of([&] { table.set("radius", "nan"); }) == "parameter radius: nan is outside 0 … 2");
  CHECK(message_of([&] { table.set("mode", "exakt"); }) ==
        "parameter mode: no value is called 'exakt'; did you mean 'exact'?");
  CHECK(table.to_string() == "bounces=4,radius=0.5,filter=on,mode=exact");
}

TEST_CASE("a path set survives its text, and differences are named") {
  PathSet a;
  a.max_bounces = 3;
  a.secondary_lambert_only = true;
  a.indirect_clamp = 1.0 / 3;
  CHECK(PathSet::parse(a.to_string()) == a);
  const std::vector<std::string> lines = a.differences(PathSet());
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "max_bounces: 3 against -1");
  CHECK(message_of([] { PathSet::parse("max_bounce=1"); }).find("did you mean 'max_bounces'?") != std::string::npos);
  CHECK(message_of([] { PathSet::parse("direct=maybe"); }) == "path set: 'maybe' is not a value of direct: on or off");
}

namespace {

struct WithPresets {
  int size = 24;
  bool fill = true;
  template <class V>
  void describe(V& v) {
    v.number("size", size, 8, 64, "", "how large");
    v.flag("fill", fill, "whether");
    v.presets({{"paper", {{"fill", "off"}}}, {"small", {{"size", "8"}}}}, "values that belong together");
  }
};

}  // namespace

TEST_CASE("a preset sets all parameters, and what is set after it wins") {
  WithPresets values;
  ParameterTable table = make_parameter_table(values);
  CHECK(table.to_string() == "preset=default,size=24,fill=on");
  table.set_all({{"size", "12"}, {"preset", "paper"}});
  CHECK(table.to_string() == "preset=paper,size=12,fill=off");
  table.set("preset", "default");
  table.set("size", "16");
  table.set("preset", "paper");
  CHECK(table.to_string() == "preset=paper,size=24,fill=off");
  table.set("size", "12");
  CHECK(table.to_string() == "preset=paper,size=12,fill=off");
  table.set("preset", "small");
  CHECK(table.to_string() == "preset=small,size=8,fill=on");
  table.set("preset", "default");
  CHECK(table.to_string() == "preset=default,size=24,fill=on");
  CHECK(message_of([&] { table.set("preset", "papr"); }) ==
        "parameter preset: no value is called 'papr'; did you mean 'paper'?");
  CHECK(table.entries().front().info.range == "default|paper|small");
}

TEST_CASE("what basic() does not name is advanced; the preset is basic, and without basic() everything is") {
  Grouped grouped;
  std::string basic;
  for (const ParameterTable table = make_parameter_table(grouped); const ParameterTable::Entry& entry : table.entries())
    if (!entry.info.advanced) basic += entry.info.name + " ";
  CHECK(basic == "preset bounces mode ");
  Example example;
  for (const ParameterTable table = make_parameter_table(example); const ParameterTable::Entry& entry : table.entries())
    CHECK_FALSE(entry.info.advanced);
  grouped.named = {"bounce"};
  CHECK_THROWS_AS(make_parameter_table(grouped), Error);
}
