// SPDX-License-Identifier: Apache-2.0
// Checks of what a technique declares. Declared in checks.h.
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/conformance/check_scenes.h"
#include "lucarium/conformance/checks.h"

namespace lucarium::check {
namespace {

/// A kind that is claimed twice; empty: none.
template <class Kind>
std::string repeated_kind(const char* what, const std::vector<Kind>& kinds) {
  std::set<Kind> seen;
  for (const Kind kind : kinds)
    if (!seen.insert(kind).second) return fmt::format("{} has '{}' twice", what, name_of(kind));
  return "";
}

bool is_identifier(const std::string& name) {
  return !name.empty() && name.front() >= 'a' && name.front() <= 'z' &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

bool refuses(ParameterTable& table, const std::string& name, const std::string& value) {
  try {
    table.set(name, value);
  } catch (const Error& error) {
    return error.error_class() == ErrorClass::usage;
  }
  return false;
}

double number_of(const std::string& text) {
  double value = NAN;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Fault in the values of one parameter; empty: none. Leaves it at its default.
std::string values_mistake(ParameterTable& table, const ParameterInfo& info) {
  const auto reads_back = [&](const std::string& value) {
    table.set(info.name, value);
    return table.get(info.name) == value;
  };
  std::vector<std::string> good = info.choices, bad = {"", "no such value"};
  const size_t dots = info.range.find(" … ");
  if (dots != std::string::npos) {
    const std::string low = info.range.substr(0, dots), high = info.range.substr(dots + std::string(" … ").size());
    good = {low, high};
    const double a = number_of(low), b = number_of(high);
    if (!(a <= b)) return fmt::format("range {} is empty", info.range);
    bad.push_back(fmt::format("{}", b + std::max(1.0, std::abs(b))));
    bad.push_back(fmt::format("{}", a - std::max(1.0, std::abs(a))));
    bad.emplace_back("nan");
  }
  for (const std::string& value : good) {
    if (!reads_back(value)) return fmt::format("{} reads back as {}", value, table.get(info.name));
  }
  for (const std::string& value : bad) {
    if (!refuses(table, info.name, value)) return fmt::format("accepts '{}', which is outside {}", value, info.range);
  }
  if (!reads_back(info.default_value))
    return fmt::format("default {} reads back as {}", info.default_value, table.get(info.name));
  return "";
}

}  // namespace

Outcome check_declaration(CheckContext& context) {
  const TechniqueInfo& info = context.type.info();
  const Capabilities& can = info.capabilities;
  std::vector<std::string> mistakes;
  const auto require = [&](bool good, std::string mistake) {
    if (!good) mistakes.push_back(std::move(mistake));
  };
  require(!info.version.empty(), "no version");
  require(!info.summary.empty(), "no summary");
  require(!info.layers.empty(), "no layers");
  for (const OptionalLayers& optional : info.optional_layers)
    for (const std::string& layer : optional.names)
      require(std::find(info.layers.begin(), info.layers.end(), layer) == info.layers.end(),
              fmt::format("layer {} is declared as always there and with {}", layer, optional.parameters));
  require(!can.pixel_sampling.empty(), "no pixel sampling");
  require(can.max_bounces >= -1, "max_bounces below -1");
  for (const double bias : {can.bias, context.bias})
    require(bias >= 0 && bias < 1, fmt::format("bias {} is not in 0 … 1", bias));
  for (const std::string& mistake : {repeated_kind("lights", can.lights), repeated_kind("materials", can.materials),
                                     repeated_kind("changes", can.changes)}) {
    require(mistake.empty(), mistake);
  }
  require(!context.path_set.light_transport() || !can.lights.empty(), "computes light and claims no kind of light");
  require(context.type.file().stem() == info.name,
          fmt::format("its file is called {}", context.type.file().filename().string()));
  if (!mistakes.empty()) return verdict_of(false, fmt::format("{}", fmt::join(mistakes, "; ")));
  return verdict_of(true, fmt::format("{} lights, {} materials, {} changes, {} layers", can.lights.size(),
                                      can.materials.size(), can.changes.size(), info.layers.size()));
}

Outcome check_parameters(CheckContext& context) {
  const std::unique_ptr<Technique> technique = context.type.create();
  technique->parameters().set_all(context.options.parameters);
  ParameterTable& table = technique->parameters();
  std::vector<std::string> mistakes;
  std::set<std::string> names;
  const std::vector<ParameterTable::Entry> entries = table.entries();
  for (const ParameterTable::Entry& entry : entries) {
    const ParameterInfo& info = entry.info;
    if (!is_identifier(info.name)) mistakes.push_back(fmt::format("'{}' is not a name of a-z, 0-9 and _", info.name));
    if (!names.insert(info.name).second) mistakes.push_back(fmt::format("{} is declared twice", info.name));
    if (info.doc.empty()) mistakes.push_back(fmt::format("{} has no description", info.name));
    if (const std::string mistake = values_mistake(table, info); !mistake.empty()) {
      mistakes.push_back(fmt::format("{}: {}", info.name, mistake));
    }
  }
  if (!refuses(table, "no_such_parameter", "1")) mistakes.emplace_back("accepts an unknown parameter");
  if (!mistakes.empty()) return verdict_of(false, fmt::format("{}", fmt::join(mistakes, "; ")));
  return verdict_of(true, fmt::format("{} parameters", entries.size()));
}

Outcome check_layers(CheckContext& context) {
  RenderSession session = context.session(context.plain_scene());
  session.run({.iterations = 1});
  const Film film = session.resolve();
  const std::vector<std::string>& declared = context.type.info().layers;
  std::vector<std::string> mistakes;
  const PathSet set = session.technique().path_set(session.scene(), session.settings());
  for (const auto& [layer, computed] :
       {std::pair{"emission", set.emission}, {"direct", set.direct}, {"indirect", set.indirect}}) {
    const FilmLayer* there = film.find(layer);
    if (computed && !(there && there->additive))
      mistakes.push_back(fmt::format("its path set has {}, its film does not", layer));
    if (!computed && there && there->additive)
      mistakes.push_back(fmt::format("its film has {}, its path set does not", layer));
  }
  for (const FilmLayer& layer : film.layers()) {
    if (std::find(declared.begin(), declared.end(), layer.name) == declared.end()) {
      mistakes.push_back(fmt::format("layer {} is not declared", layer.name));
    }
  }
  if (!mistakes.empty()) return verdict_of(false, fmt::format("{}", fmt::join(mistakes, "; ")));
  return verdict_of(true, fmt::format("{} of {} declared layers in the film", film.layers().size(), declared.size()));
}

Outcome check_finite(CheckContext& context) {
  uint64_t values = 0, negative = 0;
  for (const LightKind light :
       context.can().lights.empty() ? std::vector<LightKind>{LightKind::environment} : context.can().lights) {
    RenderSession session = context.session(make_changing_scene(light));
    for (int i = 0; i < 8; ++i) {
      session.iterate();
      const Film film = session.resolve();  // throws for NaN and infinity
      for (const FilmLayer& layer : film.layers()) values += layer.pixels.size();
      negative += film.count_bad_pixels().negative;
    }
  }
  return verdict_of(negative == 0, fmt::format("{} values, {} negative", values, negative));
}

}  // namespace lucarium::check
