// SPDX-License-Identifier: Apache-2.0
// lucarium techniques [NAME]: everything a technique declares, as text, JSON, or the page docs/techniques.md. Declared
// in commands.h.
#include <fmt/ranges.h>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/technique/plugin.h"
#include "options/options.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct TechniquesArguments {
  std::string name;
  std::vector<fs::path> folders;
  bool markdown = false;
};

/// With its default parameters.
double admitted_bias(const TechniqueType& type) { return type.admitted_bias(*type.create()); }

std::string bias_text(const TechniqueType& type) {
  const double bias = admitted_bias(type);
  return bias > 0 ? fmt::format("bias of at most {:.3g} %", 100 * bias) : std::string("unbiased");
}

std::string bounces_text(const Capabilities& can) {
  return can.max_bounces < 0 ? std::string("unlimited") : fmt::format("at most {}", can.max_bounces);
}

/// The parameters that most pictures need, or the others.
std::vector<ParameterInfo> parameters(const TechniqueType& type, bool advanced) {
  std::vector<ParameterInfo> chosen;
  const std::unique_ptr<Technique> technique = type.create();
  for (const ParameterTable::Entry& entry : technique->parameters().entries())
    if (entry.info.advanced == advanced) chosen.push_back(entry.info);
  return chosen;
}

void print_text(const TechniqueType& type) {
  const TechniqueInfo& info = type.info();
  const Capabilities& can = info.capabilities;
  print_result("{} {}: {}\n", info.name, info.version, info.summary);
  if (!info.citation.empty()) print_result("  paper       {}\n", info.citation);
  print_result("  file        {}\n  lights      {}\n  materials   {}\n  changes     {}\n  bounces     {}\n",
               type.file().string(), fmt::join(names_of(can.lights), ", "), fmt::join(names_of(can.materials), ", "),
               fmt::join(names_of(can.changes), ", "), bounces_text(can));
  print_result("  {}, {}, {}\n  layers      {}\n", can.progressive ? "progressive" : "one-shot",
               can.view_independent ? "view-independent data" : "view-dependent", bias_text(type),
               fmt::join(info.layers, ", "));
  for (const OptionalLayers& optional : info.optional_layers)
    print_result("  with {}: {}\n", optional.parameters, fmt::join(optional.names, ", "));
  for (const bool advanced : {false, true}) {
    const std::vector<ParameterInfo> listed = parameters(type, advanced);
    if (!listed.empty()) print_result("  {}\n", advanced ? "advanced parameters" : "parameters");
    for (const ParameterInfo& p : listed) {
      print_result("    {}={}  ({}{}{})\n        {}\n", p.name, p.default_value, p.range, p.unit.empty() ? "" : " ",
                   p.unit, p.doc);
    }
  }
}

ordered_json to_json(const TechniqueType& type) {
  const TechniqueInfo& info = type.info();
  const Capabilities& can = info.capabilities;
  ordered_json json = {{"name", info.name},
                       {"version", info.version},
                       {"summary", info.summary},
                       {"citation", info.citation},
                       {"file", type.file().string()},
                       {"layers", info.layers},
                       {"optional_layers", ordered_json::array()},
                       {"capabilities",
                        {{"lights", names_of(can.lights)},
                         {"materials", names_of(can.materials)},
                         {"changes", names_of(can.changes)},
                         {"max_bounces", can.max_bounces},
                         {"progressive", can.progressive},
                         {"view_independent", can.view_independent},
                         {"bias", admitted_bias(type)},
                         {"pixel_sampling", can.pixel_sampling}}},
                       {"parameters", ordered_json::array()}};
  for (const OptionalLayers& optional : info.optional_layers)
    json["optional_layers"].push_back({{"parameters", optional.parameters}, {"layers", optional.names}});
  const std::unique_ptr<Technique> technique = type.create();
  for (const ParameterTable::Entry& entry : technique->parameters().entries()) {
    const ParameterInfo& p = entry.info;
    json["parameters"].push_back({{"name", p.name},
                                  {"type", p.type},
                                  {"default", p.default_value},
                                  {"range", p.range},
                                  {"unit", p.unit},
                                  {"advanced", p.advanced},
                                  {"meaning", p.doc}});
  }
  return json;
}

std::string table_cell(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.replace(at, 1, "\\|");
  return text;
}

std::string markdown(const TechniqueType& type) {
  const TechniqueInfo& info = type.info();
  const Capabilities& can = info.capabilities;
  std::string page = fmt::format("\n## {}\n\n{}.\n\n", info.name, info.summary);
  if (!info.citation.empty()) page += fmt::format("{}.\n\n", info.citation);
  page += fmt::format("- lights: {}\n- materials: {}\n- scene changes: {}\n- bounces: {}\n- {}; {}; {}\n- layers: {}\n",
                      fmt::join(names_of(can.lights), ", "), fmt::join(names_of(can.materials), ", "),
                      fmt::join(names_of(can.changes), ", "), bounces_text(can),
                      can.progressive ? "progressive" : "one-shot",
                      can.view_independent ? "data do not depend on the view" : "data depend on the view",
                      bias_text(type), fmt::join(info.layers, ", "));
  for (const OptionalLayers& optional : info.optional_layers)
    page += fmt::format("- layers with {}: {}\n", optional.parameters, fmt::join(optional.names, ", "));
  page += '\n';
  for (const bool advanced : {false, true}) {
    const std::vector<ParameterInfo> listed = parameters(type, advanced);
    if (listed.empty()) continue;
    if (advanced) page += "\nAdvanced parameters:\n\n";
    page += "| parameter | type | default | range | unit | meaning |\n|---|---|---|---|---|---|\n";
    for (const ParameterInfo& p : listed) {
      page += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", p.name, p.type, p.default_value, table_cell(p.range),
                          p.unit, table_cell(p.doc));
    }
  }
  return page;
}

int techniques(const TechniquesArguments& arguments, const Messages& messages) {
  const TechniqueRegistry registry(arguments.folders);
  std::vector<const TechniqueType*> chosen;
  if (!arguments.name.empty()) {
    chosen.push_back(&registry.find(arguments.name));
  } else {
    for (const TechniqueType& type : registry.types()) chosen.push_back(&type);
  }
  if (messages.json) {
    ordered_json list = ordered_json::array();
    for (const TechniqueType* type : chosen) list.push_back(to_json(*type));
    print_result("{}\n", ordered_json{{"schema", "lucarium-techniques-2"}, {"techniques", list}}.dump(2));
  } else if (arguments.markdown) {
    print_result(
        "# Techniques\n\nGenerated by `lucarium techniques --markdown`; edit the techniques' `describe()` instead.\n");
    for (const TechniqueType* type : chosen) print_result("{}", markdown(*type));
  } else if (!arguments.name.empty()) {
    print_text(*chosen.front());
  } else {
    for (const TechniqueType* type : chosen) print_result("{:<24} {}\n", type->info().name, type->info().summary);
  }
  for (const PluginFailure& failure : registry.failures()) log_warning("{}: {}", failure.file.string(), failure.reason);
  if (chosen.empty()) {
    std::string searched;
    for (const fs::path& folder : registry.searched()) searched += (searched.empty() ? "" : ", ") + folder.string();
    throw_error(ErrorClass::technique, "no technique found; searched {}; name a folder with --technique-path",
                searched);
  }
  return 0;
}

}  // namespace

void add_techniques_command(Command program, Action& action) {
  auto arguments = std::make_shared<TechniquesArguments>();
  Command command = program.add_subcommand("techniques", "list techniques, or print everything one declares");
  command.option("technique", arguments->name);
  command.flag("--markdown", arguments->markdown);
  add_technique_path(command, arguments->folders);
  command.excludes({"--markdown"}, {"--json"});
  command.examples({"lucarium techniques", "lucarium techniques path_tracing"}, "docs/techniques.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return techniques(*arguments, messages); };
  });
}

}  // namespace lucarium::app
