// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/dry_run.h"

#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/progress.h"
#include "lucarium/compare/comparison_plan.h"
#include "lucarium/compare/reference_image.h"
#include "lucarium/compare/reference_render.h"
#include "lucarium/compute/byte_size.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// Measured on one iteration.
struct Rate {
  std::string failure;
  double start_seconds = 0;      ///< of everything but iterating
  double iteration_seconds = 0;
};

Rate measure_rate(std::vector<std::string> command, const std::string& technique, int max_bounces) {
  command.insert(command.end(), {"--iterations", "1", "--max-bounces", std::to_string(max_bounces), "-t", technique, "--quiet"});
  const ChildResult child = run_child(command);
  Rate rate;
  if (child.exit_code != 0) {
    rate.failure = child.last_words.empty() ? describe_end(child) : child.last_words.back();
    return rate;
  }
  rate.iteration_seconds = json::parse(child.out).at("clocks").at("iterate_seconds");
  rate.start_seconds = child.seconds - rate.iteration_seconds;
  return rate;
}

/// Seconds of all runs of a variant on one scene.
double seconds_of_runs(const ComparisonSpec& spec, const Rate& rate) {
  double seconds = 0;
  for (const ComparisonBudget& budget : spec.budgets) {
    const double iterate = budget.seconds > 0      ? budget.seconds
                           : budget.iterations > 0 ? static_cast<double>(budget.iterations) * rate.iteration_seconds
                                                   : budget.limit_seconds;
    seconds += rate.start_seconds + iterate;
  }
  return seconds * spec.seeds;
}

/// Samples per pixel that the cache already holds.
uint64_t cached_samples(const fs::path& file) {
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return 0;
  try {
    return ReferenceImage(read_image(file), file.string()).samples();
  } catch (const Error&) {
    return 0;  // not usable: it will be rendered again
  }
}

/// "all", or what differs from all light paths, in words.
std::string describe_path_set(const std::string& text) {
  std::vector<std::string> parts;
  for (const std::string& line : PathSet::parse(text).differences(PathSet())) parts.push_back(line.substr(0, line.find(" against ")));
  return parts.empty() ? "all light paths" : fmt::format("light paths with {}", fmt::join(parts, ", "));
}

class DryRun {
 public:
  DryRun(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options)
      : spec_(spec), registry_(registry), options_(options) {}

  std::string describe() {
    for (const ComparisonScene& scene : spec_.scenes) add_scene(scene);
    std::vector<std::string> budgets;
    for (const ComparisonBudget& budget : spec_.budgets) budgets.push_back(budget.label());
    text_ += fmt::format("{} runs ({} at {}×{} pixels, {} seeds each), about {}{}\n", runs_, fmt::join(budgets, "; "), spec_.width,
                         spec_.height, spec_.seeds, format_duration(seconds_), open_ended_ ? " at most" : "");
    return text_;
  }

 private:
  void add_scene(const ComparisonScene& scene) {
    const ScenePlan plan = plan_scene(spec_, scene, registry_);
    const SceneResult& entry = plan.result;
    if (!entry.failure.empty()) {
      text_ += fmt::format("{}\n  cannot be used: {}\n", entry.name, entry.failure);
      return;
    }
    text_ += fmt::format("{}\n  {} triangles\n", entry.name, entry.triangles);
    for (const std::string& warning : entry.warnings) text_ += fmt::format("  warning: {}\n", warning);
    for (size_t i = 0; i < entry.references.size(); ++i) add_reference(scene, plan, i);
    for (size_t variant = 0; variant < spec_.variants.size(); ++variant) add_variant(scene, plan, variant);
  }

  std::vector<std::string> command(const ComparisonScene& scene, const ScenePlan& plan) const {
    return scene_command(spec_, plan, scene.source, options_.program, "render", 1);
  }

  void add_reference(const ComparisonScene& scene, const ScenePlan& plan, size_t index) {
    const std::string set = plan.result.references[index].path_set;
    text_ += fmt::format("  reference {}: {}; ", index + 1, describe_path_set(set));
    if (spec_.reference.file) {
      text_ += fmt::format("{}\n", spec_.reference.file->string());
      return;
    }
    const uint64_t have = cached_samples(options_.cache_dir / "references" / plan.reference_files[index]);
    const uint64_t missing = spec_.reference.samples > have ? spec_.reference.samples - have : 0;
    std::string technique = "path_tracing";
    for (const auto& [name, value] : reference_parameters(PathSet::parse(set))) {
      technique += fmt::format("{}{}={}", technique == "path_tracing" ? ":" : ",", name, value);
    }
    const Rate rate = missing > 0 ? measure_rate(command(scene, plan), technique, PathSet::parse(set).max_bounces) : Rate();
    const double seconds = rate.iteration_seconds * static_cast<double>(missing) / reference_batch;
    seconds_ += seconds;
    open_ended_ |= missing > 0 && spec_.reference.relmse > 0;
    text_ += fmt::format("{} samples per pixel, {} of them in the cache, about {} to render\n", spec_.reference.samples,
                         std::min(have, spec_.reference.samples), format_duration(seconds));
  }

  void add_variant(const ComparisonScene& scene, const ScenePlan& plan, size_t index) {
    const SceneVariant& variant = plan.result.variants[index];
    text_ += fmt::format("  {}: ", spec_.variants[index].label());
    if (!variant.refused.empty()) {
      text_ += fmt::format("does not run: {}\n", variant.refused);
      return;
    }
    const Rate rate = measure_rate(command(scene, plan), spec_.variants[index].words(), spec_.max_bounces);
    if (!rate.failure.empty()) {
      text_ += fmt::format("fails: {}\n", rate.failure);
      return;
    }
    runs_ += spec_.budgets.size() * spec_.seeds;
    seconds_ += seconds_of_runs(spec_, rate);
    for (const ComparisonBudget& budget : spec_.budgets) open_ended_ |= budget.relmse > 0;
    text_ += fmt::format("reference {}, {} of device memory, {:.3g} s to start, {:.3g} s per iteration\n", variant.reference + 1,
                         format_bytes(variant.device_bytes), rate.start_seconds, rate.iteration_seconds);
    for (const std::string& limitation : variant.limitations) text_ += fmt::format("    {}\n", limitation);
  }

  const ComparisonSpec& spec_;
  const TechniqueRegistry& registry_;
  const ComparisonOptions& options_;
  std::string text_;
  size_t runs_ = 0;
  double seconds_ = 0;
  bool open_ended_ = false;  ///< an error decides, and the estimate is a bound
};

}  // namespace

std::string describe_plan(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options) {
  check_comparison(spec);
  return DryRun(spec, registry, options).describe();
}

}  // namespace lucarium
