// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/dry_run.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/reference/reference_image.h"
#include "lucarium/compare/reference/reference_render.h"
#include "lucarium/compare/run/comparison_plan.h"
#include "lucarium/compare/run/reference_file.h"
#include "lucarium/film/image_io.h"
#include "lucarium/job/run_job.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint64_t max_first_iterations = 64;

/// Measured on the first iterations.
struct Rate {
  std::string failure;
  double start_seconds = 0;    ///< of everything but iterating
  double counted_seconds = 0;  ///< of them, those that a budget of seconds counts
  double iteration_seconds = 0;
  double samples_per_iteration = 0;  ///< per pixel
  double own_seconds = INFINITY;     ///< of iterating until the technique ends by itself, by its own account
  std::string planned;               ///< what was lowered for the budget
};

/// On one iteration, or on as many as lead to the work whose amount the technique knows.
Rate measure_rate(const std::filesystem::path& program, Job job, const TechniqueVariant& variant, double seconds) {
  RenderWork work;
  work.technique = variant.technique;
  work.parameters = variant.parameters;
  work.iterations = max_first_iterations;
  work.work_iterations = 1;
  work.seconds = seconds;
  job.work = work;
  const ChildResult child = run_job({program.string()}, job);
  Rate rate;
  if (child.exit_code != 0) {
    rate.failure = reason_of_end(child);
    return rate;
  }
  const json summary = frame_of(child);
  const json& clocks = summary.at("clocks");
  const double iterate_seconds = clocks.at("iterate_seconds");
  rate.iteration_seconds = iterate_seconds / summary.at("iterations").get<double>();
  rate.samples_per_iteration = summary.at("samples").get<double>() / summary.at("iterations").get<double>();
  rate.start_seconds = child.seconds - iterate_seconds;
  for (const char* clock : {"upload_seconds", "bvh_seconds", "prepare_seconds"})
    rate.counted_seconds += clocks.at(clock).get<double>();
  rate.planned = summary.value("planned", "");
  const json& left = summary.at("seconds_left");
  if (summary.at("converged")) rate.own_seconds = iterate_seconds;
  if (left.is_number()) rate.own_seconds = iterate_seconds + left.get<double>();
  return rate;
}

/// Iterations that a budget of iterations or samples asks for; 0: it is one of time.
double iterations_of(const ComparisonBudget& budget, const Rate& rate) {
  if (budget.samples == 0) return static_cast<double>(budget.iterations);
  if (rate.samples_per_iteration <= 0) return 1;  // none was complete: at least one
  return std::ceil(static_cast<double>(budget.samples) / rate.samples_per_iteration);
}

/// Seconds of a run of a variant on one scene; `bound`: it may take less.
double seconds_of_run(const ComparisonBudget& budget, const Rate& rate, bool& bound) {
  const double seconds = budget.seconds > 0 ? budget.seconds : budget.limit_seconds;
  const double iterations = iterations_of(budget, rate);
  const double iterate = iterations > 0 ? iterations * rate.iteration_seconds
                                        : std::max(rate.iteration_seconds, seconds - rate.counted_seconds);
  bound = budget.relmse > 0 || rate.own_seconds < iterate;
  return rate.start_seconds + std::min(iterate, rate.own_seconds);
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
  for (const std::string& line : PathSet::parse(text).differences(PathSet()))
    parts.push_back(line.substr(0, line.find(" against ")));
  return parts.empty() ? "all light paths" : fmt::format("light paths with {}", fmt::join(parts, ", "));
}

class DryRun {
 public:
  DryRun(const ComparisonSpec& spec, const TechniqueRegistry& registry, const ComparisonOptions& options)
      : spec_(spec), registry_(registry), options_(options) {}

  std::string describe() {
    for (const ComparisonScene& scene : spec_.scenes) {
      say(scene.label(), "planning");
      add_scene(scene);
    }
    std::vector<std::string> budgets;
    for (const ComparisonBudget& budget : spec_.budgets) budgets.push_back(budget.label());
    text_ += fmt::format("{} ({} {}, {} each), about {}{}\n", counted(runs_, "run"), fmt::join(budgets, "; "), sizes(),
                         counted(spec_.seeds, "seed"), format_duration(seconds_), open_ended_ ? " at most" : "");
    return text_;
  }

 private:
  /// What takes its time, before it does.
  void say(const std::string& scene, const std::string& what) const {
    if (options_.progress) options_.progress(fmt::format("{}: {}", scene, what));
  }

  void add_scene(const ComparisonScene& scene) {
    const ScenePlan plan = plan_scene(spec_, scene, registry_);
    const SceneResult& entry = plan.result;
    if (!entry.failure.empty()) {
      text_ += fmt::format("{}\n  cannot be used: {}\n", entry.name, entry.failure);
      return;
    }
    const SceneSettings own = spec_.settings_of(scene);
    text_ += fmt::format("{}\n  {}{}\n", entry.name, counted(entry.triangles, "triangle"),
                         scene.size ? fmt::format(", {}×{} pixels", own.width, own.height) : "");
    for (const std::string& warning : entry.warnings) text_ += fmt::format("  warning: {}\n", warning);
    if (spec_.reference.file && !entry.references.empty()) {
      check_one_reference(entry);
      read_reference_file(spec_, entry, entry.references[0]);
    }
    for (size_t i = 0; i < entry.references.size(); ++i) add_reference(scene, plan, i);
    for (size_t variant = 0; variant < spec_.variants.size(); ++variant) add_variant(scene, plan, variant);
  }

  std::string sizes() const {
    const auto own = [](const ComparisonScene& scene) { return scene.size.has_value(); };
    if (std::any_of(spec_.scenes.begin(), spec_.scenes.end(), own)) return "in the scenes' sizes";
    return fmt::format("at {}×{} pixels", spec_.width, spec_.height);
  }

  /// The longest budget of time, for which parameters are planned as in a run; 0: none.
  double longest_seconds() const {
    double longest = 0;
    for (const ComparisonBudget& budget : spec_.budgets)
      longest = std::max({longest, budget.seconds, budget.limit_seconds});
    return longest;
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
    Job job = scene_job(spec_, scene, plan, options_, 1);
    job.max_bounces = PathSet::parse(set).max_bounces;
    const TechniqueVariant path_tracing{"path_tracing", reference_parameters(PathSet::parse(set)), ""};
    if (missing > 0) say(scene.label(), fmt::format("first iteration of reference {}", index + 1));
    const Rate rate = missing > 0 ? measure_rate(options_.program, job, path_tracing, 0) : Rate();
    const double seconds = rate.iteration_seconds * static_cast<double>(missing) / reference_batch;
    seconds_ += seconds;
    open_ended_ |= missing > 0 && spec_.reference.relmse > 0;
    text_ += fmt::format("{} per pixel, {} of them in the cache, about {} to render\n",
                         counted(spec_.reference.samples, "sample"), std::min(have, spec_.reference.samples),
                         format_duration(seconds));
  }

  void add_variant(const ComparisonScene& scene, const ScenePlan& plan, size_t index) {
    const SceneVariant& variant = plan.result.variants[index];
    text_ += fmt::format("  {}: ", spec_.variants[index].label());
    if (!variant.refused.empty()) {
      text_ += fmt::format("does not run: {}\n", variant.refused);
      return;
    }
    say(scene.label(), fmt::format("first iterations of {}", spec_.variants[index].label()));
    const Rate rate = measure_rate(options_.program, scene_job(spec_, scene, plan, options_, 1), spec_.variants[index],
                                   longest_seconds());
    if (!rate.failure.empty()) {
      text_ += fmt::format("fails: {}\n", rate.failure);
      return;
    }
    runs_ += spec_.budgets.size() * spec_.seeds;
    for (const ComparisonBudget& budget : spec_.budgets) {
      bool bound = false;
      seconds_ += spec_.seeds * seconds_of_run(budget, rate, bound);
      open_ended_ |= bound;
    }
    text_ += fmt::format(
        "reference {}, {} of device memory, {:.3g} s to start, {:.3g} s per iteration{}\n", variant.reference + 1,
        format_bytes(variant.device_bytes), rate.start_seconds, rate.iteration_seconds,
        std::isfinite(rate.own_seconds) ? fmt::format(", at most {:.3g} s until it ends by itself", rate.own_seconds)
                                        : "");
    if (!rate.planned.empty()) text_ += fmt::format("    lowered for the budget: {}\n", rate.planned);
    for (const std::string& limitation : variant.limitations) text_ += fmt::format("    {}\n", limitation);
  }

  const ComparisonSpec& spec_;
  const TechniqueRegistry& registry_;
  const ComparisonOptions& options_;
  std::string text_;
  size_t runs_ = 0;
  double seconds_ = 0;
  bool open_ended_ = false;  ///< some run may end before, and the estimate is a bound
};

}  // namespace

std::string describe_plan(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                          const ComparisonOptions& options) {
  check_comparison(spec);
  return DryRun(spec, registry, options).describe();
}

}  // namespace lucarium
