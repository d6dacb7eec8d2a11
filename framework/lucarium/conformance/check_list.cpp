// SPDX-License-Identifier: Apache-2.0
// The list of checks, in the order of the table, and the loop over them. Declared in conformance.h and checks.h.
#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/conformance/checks.h"
#include "lucarium/scene/load/load_scene.h"

namespace lucarium {
namespace {

using namespace check;

struct Check {
  std::string name, required;
  std::function<Outcome(CheckContext&)> run;
};

void add_radiometric_checks(std::vector<Check>& list, const CheckContext& context) {
  const std::string bias = context.bias > 0 ? fmt::format(" or the admitted bias of {:.3g} %", 100 * context.bias) : "";
  const std::string exact = fmt::format("within t({}) standard errors{}", level, bias);
  const std::string agrees = context.bias > 0
                                 ? fmt::format("difference of at most {:.3g} % beyond noise", 100 * context.bias)
                                 : fmt::format("no block and not the whole image different at the level {}", level);
  list.push_back({"furnace", exact, check_furnace});
  list.push_back({"shining_box", exact, check_shining_box});
  for (const LightKind light : all_kinds<LightKind>())
    list.push_back({"light/" + name_of(light), exact, [light](CheckContext& c) { return check_light(c, light); }});
  for (const LightKind light : all_kinds<LightKind>())
    list.push_back({"reference/light/" + name_of(light), agrees,
                    [light](CheckContext& c) { return check_reference(c, MaterialKind::diffuse, light); }});
  const LightKind light = context.any_light();
  for (const MaterialKind material : all_kinds<MaterialKind>())
    list.push_back({"reference/material/" + name_of(material), agrees,
                    [material, light](CheckContext& c) { return check_reference(c, material, light); }});
  list.push_back({"reference/sky", agrees, check_sky});
  list.push_back({"reference/sides", agrees, check_sides});
  list.push_back({"reference/lobes", agrees, check_lobes});
}

std::vector<Check> make_list(const CheckContext& context) {
  std::vector<Check> list = {
      {"declaration", "known names, none missing", check_declaration},
      {"parameters", "documented, values read back, others rejected", check_parameters},
      {"layers", "those declared, and those of the path set", check_layers},
      {"finite", "no NaN, infinite or negative value", check_finite},
      {"repeat/seed", "same bits", check_seed},
      {"repeat/reset", "same bits", check_reset},
      {"repeat/observing", "same bits", check_observing},
      {"repeat/threads", "same bits", check_threads},
      {"view/kept", "same bits", check_view},
      {"view/saved", "same bits", check_state},
      {"camera_move", "no program, no hierarchy, at most 100 ms", check_camera_cost},
  };
  for (const ChangeKind kind : all_kinds<ChangeKind>())
    list.push_back({"change/" + name_of(kind), "the image of a fresh start",
                    [kind](CheckContext& c) { return check_change(c, kind); }});
  list.push_back({"change/alpha", "the image of a fresh start", check_alpha_change});
  list.push_back({"memory/returned", "as before", check_memory});
  list.push_back({"memory/stated", "at most 1.1 times the estimate", check_estimate});
  list.push_back({"budget/iterations", "exactly as requested, and samples are counted", check_iterations});
  list.push_back({"budget/seconds", "at most 1 s over the budget", check_seconds});
  list.push_back({"cancellation", "within 1 s, image unchanged", check_cancellation});
  add_radiometric_checks(list, context);
  list.push_back({"oclgrind", "no error", check_oclgrind});
  return list;
}

bool is_chosen(const std::string& name, const std::vector<std::string>& only) {
  return only.empty() ||
         std::any_of(only.begin(), only.end(), [&](const std::string& part) { return name.starts_with(part); });
}

CheckResult run_check(const Check& check, CheckContext& context) {
  const Stopwatch watch;
  Outcome outcome;
  try {
    outcome = check.run(context);
  } catch (const Error& error) {
    outcome = verdict_of(false, error.what());
  } catch (const std::exception& error) {
    outcome = verdict_of(false, error.what());
  }
  return {check.name, outcome.verdict, outcome.measured, check.required, watch.seconds()};
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::passed: return "passed";
    case Verdict::failed: return "failed";
    case Verdict::skipped: return "skipped";
    case Verdict::not_claimed: return "not claimed";
  }
  return "?";
}

std::vector<std::pair<std::string, std::string>> effective_parameters(const TechniqueInfo& info,
                                                                      const ConformanceOptions& options) {
  std::vector<std::pair<std::string, std::string>> all;
  if (!options.full) all = info.check_parameters;
  all.insert(all.end(), options.parameters.begin(), options.parameters.end());
  return all;
}

std::vector<std::pair<std::string, std::string>> oclgrind_parameters(const TechniqueInfo& info,
                                                                     const ConformanceOptions& options) {
  if (options.full) return options.parameters;
  auto all = info.check_parameters;
  all.insert(all.end(), info.oclgrind_parameters.begin(), info.oclgrind_parameters.end());
  all.insert(all.end(), options.parameters.begin(), options.parameters.end());
  return all;
}

double admitted_bias(const TechniqueType& type, const ConformanceOptions& options) {
  const std::unique_ptr<Technique> technique = type.create();
  technique->parameters().set_all(effective_parameters(type.info(), options));
  return type.admitted_bias(*technique);
}

std::vector<CheckResult> check_technique(std::shared_ptr<Device> device, const TechniqueRegistry& registry,
                                         const TechniqueType& type, const ConformanceOptions& wanted) {
  ConformanceOptions options = wanted;
  options.parameters = effective_parameters(type.info(), wanted);
  CheckContext context{std::move(device), registry, type, options, oclgrind_parameters(type.info(), wanted), {}};
  const Scene furnace = load_scene("builtin:furnace");
  const std::unique_ptr<Technique> technique = type.create();
  technique->parameters().set_all(options.parameters);
  context.path_set = technique->path_set(furnace, context.settings(furnace));
  context.bias = type.admitted_bias(*technique);

  std::vector<CheckResult> results;
  const auto keep = [&](CheckResult result) {
    if (options.on_result) options.on_result(result);
    results.push_back(std::move(result));
  };
  std::vector<Check> list = make_list(context);
  std::erase_if(list, [&](const Check& check) { return !is_chosen(check.name, options.only); });
  for (size_t i = 0; i < list.size(); ++i) {
    if (interrupt_requested()) return results;
    if (options.on_check) options.on_check(i, list.size(), list[i].name);
    CheckResult result = run_check(list[i], context);
    if (interrupt_requested()) return results;  // one that was cut short says nothing
    keep(std::move(result));
  }
  if (results.empty()) throw_error(ErrorClass::usage, "no check has a name that begins with {}", options.only.front());
  return results;
}

}  // namespace lucarium
