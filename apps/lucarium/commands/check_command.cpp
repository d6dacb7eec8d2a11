// SPDX-License-Identifier: Apache-2.0
// lucarium check TECHNIQUE: the conformance kit as a table or JSON; exit code 1 when a check failed. Declared in
// commands.h.
#include <algorithm>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/conformance/conformance.h"
#include "lucarium/version.h"
#include "options/options.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct CheckArguments {
  std::string technique;
  std::vector<std::string> parameters, only;
  std::vector<fs::path> folders;
  bool full = false;
  DeviceArguments device;
};

size_t count(const std::vector<CheckResult>& results, Verdict verdict) {
  return static_cast<size_t>(
      std::count_if(results.begin(), results.end(), [&](const CheckResult& r) { return r.verdict == verdict; }));
}

void print_head(const TechniqueType& type, const ConformanceOptions& options, const Device& device) {
  std::string settings;
  for (const auto& [name, value] : effective_parameters(type.info(), options))
    settings += fmt::format("{}{}={}", settings.empty() ? ", with " : ",", name, value);
  const double bias = admitted_bias(type, options);
  const std::string admits = bias > 0 ? fmt::format("; admits a bias of {:.3g} %", 100 * bias) : "";
  print_result("{} {} on {}{}{}\n", type.info().name, type.info().version, device.info().name, settings, admits);
}

void print_row(const CheckResult& result) {
  print_result("{:<12} {:<31} {}\n", verdict_name(result.verdict), result.name, result.measured);
  if (result.verdict == Verdict::failed) print_result("{:<12} {:<31} required: {}\n", "", "", result.required);
  flush_results();
}

ordered_json to_json(const std::vector<CheckResult>& results, const TechniqueType& type,
                     const ConformanceOptions& options, const Device& device) {
  ordered_json json = {{"schema", "lucarium-check-1"},
                       {"technique", type.info().name},
                       {"technique_version", type.info().version},
                       {"full", options.full},
                       {"parameters", ordered_json::object()},
                       {"bias", admitted_bias(type, options)},
                       {"device", device.info().name},
                       {"driver", device.info().driver_version},
                       {"version", LUCARIUM_VERSION}};
  for (const auto& [name, value] : effective_parameters(type.info(), options)) json["parameters"][name] = value;
  for (const Verdict verdict : {Verdict::passed, Verdict::failed, Verdict::skipped, Verdict::not_claimed}) {
    std::string key = verdict_name(verdict);
    std::replace(key.begin(), key.end(), ' ', '_');
    json[key] = count(results, verdict);
  }
  json["checks"] = ordered_json::array();
  for (const CheckResult& result : results) {
    json["checks"].push_back({{"name", result.name},
                              {"verdict", verdict_name(result.verdict)},
                              {"measured", result.measured},
                              {"required", result.required},
                              {"seconds", result.seconds}});
  }
  return json;
}

int check(const CheckArguments& arguments, const Messages& messages) {
  TechniqueArguments::Spec spec = TechniqueArguments::parse(arguments.technique);
  for (const std::string& text : arguments.parameters) {
    for (auto& parameter : TechniqueArguments::parse_parameters(text)) spec.parameters.push_back(std::move(parameter));
  }
  const TechniqueRegistry registry(arguments.folders);
  const TechniqueType& type = registry.find(spec.name);
  make_technique(type, spec);
  const std::shared_ptr<Device> device = Device::open(arguments.device.resolved());

  ConformanceOptions options;
  options.parameters = spec.parameters;
  options.full = arguments.full;
  options.only = arguments.only;
  options.program = fs::read_symlink("/proc/self/exe");
  options.technique_folders = arguments.folders;
  options.device = arguments.device.resolved();
  const bool table = !messages.json;
  Progress progress("check", messages.quiet ? Progress::Style::quiet : Progress::Style::automatic);
  options.on_check = [&](size_t index, size_t count, const std::string& name) {
    if (index == 0 && table) print_head(type, options, *device);
    progress.update(static_cast<double>(index) / static_cast<double>(count),
                    fmt::format("{}/{} {}", index + 1, count, name));
  };
  options.on_result = [&](const CheckResult& result) {
    progress.clear();
    if (table) print_row(result);
  };
  const KeepOnInterrupt keep_results;
  const std::vector<CheckResult> results = check_technique(device, registry, type, options);
  const bool cut = interrupt_requested();
  if (cut && results.empty()) throw_error(ErrorClass::interrupted, "interrupted before the first check was done");
  const size_t failed = count(results, Verdict::failed);
  if (messages.json) {
    ordered_json json = to_json(results, type, options, *device);
    json["interrupted"] = cut;
    print_result("{}\n", json.dump(2));
  }
  if (table) {
    print_result("{}: {} passed, {} failed, {} skipped, {} not claimed\n", type.info().name,
                 count(results, Verdict::passed), failed, count(results, Verdict::skipped),
                 count(results, Verdict::not_claimed));
  }
  if (cut) {
    log_warning("interrupted after {}, the others are missing", counted(results.size(), "check"));
    return static_cast<int>(ErrorClass::interrupted);
  }
  return failed > 0 ? static_cast<int>(ErrorClass::check_failed) : 0;
}

}  // namespace

void add_check_command(Command program, Action& action) {
  auto arguments = std::make_shared<CheckArguments>();
  Command command = program.add_subcommand("check", "test whether a technique keeps its promises");
  command.option("technique", arguments->technique).required().value_name("NAME[:KEY=VALUE,…]");
  command.option("--only", arguments->only).repeatable().default_text("all");
  command.flag("--full", arguments->full);
  command.option("--parameter", arguments->parameters).repeatable().default_text("the technique's");
  add_technique_path(command, arguments->folders);
  arguments->device.add_to(command);
  command.examples({"lucarium check path_tracing --only light",
                    "lucarium check my_technique --technique-path build/lib/lucarium/techniques"},
                   "docs/conformance.md");
  command.callback(
      [arguments, &action] { action = [arguments](const Messages& messages) { return check(*arguments, messages); }; });
}

}  // namespace lucarium::app
