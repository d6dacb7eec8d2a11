// SPDX-License-Identifier: Apache-2.0
// Runs a comparison: plan, references, pieces, conclusions. Every result is saved as soon as it exists.
#include "lucarium/compare/run/comparison_runner.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <tuple>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/text/spelling.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/results/baseline.h"
#include "lucarium/compare/results/result_folder.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;

namespace {

// Between two reports while it runs: encoding pictures may take a tenth of the time at most.
constexpr double min_page_interval = 60;  // [s]
constexpr double interval_costs = 10;

VariantInfo describe(const TechniqueVariant& variant, const TechniqueRegistry& registry) {
  const TechniqueType& type = registry.find(variant.technique);
  const TechniqueInfo& info = type.info();
  const std::unique_ptr<Technique> technique = type.create();
  set_parameters(*technique, variant);
  VariantInfo result{info.summary, info.citation, info.version, {}, {}};
  for (const ParameterTable::Entry& entry : technique->parameters().entries())
    result.parameters.emplace_back(entry.info.name, entry.get());
  for (const auto& [name, value] : variant.parameters) result.given.push_back(american_spelling(name));
  return result;
}

}  // namespace

ComparisonResult run_comparison(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                const ComparisonOptions& options) {
  return ComparisonRunner(spec, registry, options).run();
}

ComparisonRunner::ComparisonRunner(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                   const ComparisonOptions& options)
    : spec_(spec), registry_(registry), options_(options), image_pairs_(options.folder) {
  // Nodes have their own working directory.
  if (options_.executor.kind == ExecutorOptions::Kind::slurm) options_.folder = fs::absolute(options_.folder);
  check_comparison(spec_);
  result_.spec = spec_;
  result_.version = LUCARIUM_VERSION;
  result_.machine = describe_machine();
  result_.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  for (const TechniqueVariant& variant : spec_.variants) result_.variants.push_back(describe(variant, registry_));
  // Mistakes in them must not wait until all is rendered.
  apply_gates(options_.gates, result_);
  if (!options_.baseline.empty()) compare_with_baseline(result_, options_.baseline);
}

/// Where earlier jobs may still be at work, on results that a run on this machine does not take.
void ComparisonRunner::say_left_jobs() const {
  if (options_.executor.kind == ExecutorOptions::Kind::slurm) return;
  for (const fs::path& folder : {options_.folder / slurm_folder, options_.folder / slurm_folder / slurm_references}) {
    const fs::path file = folder / "run.txt";
    if (!fs::exists(file)) continue;
    say(fmt::format("jobs of this comparison ({}) may still be with Slurm; --executor slurm takes what they did",
                    read_file(file)));
  }
}

void ComparisonRunner::say(const std::string& line) const {
  if (progress_) progress_->clear();
  if (options_.progress) options_.progress(line);
}

void ComparisonRunner::show_progress(double fraction, const std::string& text) {
  if (!options_.progress) return;
  if (!progress_) progress_ = std::make_unique<Progress>("slurm", Progress::Style::automatic);
  progress_->update(fraction, text);
}

ComparisonResult ComparisonRunner::run() {
  {
    const DelayInterrupt until_gone;  // the folder, if it was made for the lock
    const FolderLock asked(options_.folder);
    check_folder();
  }
  // Scenes take their time, and an interrupt ends the process at once: nothing is held meanwhile.
  for (const ComparisonScene& scene : spec_.scenes) {
    throw_if_interrupted("planning");
    plans_.push_back(plan_scene(spec_, scene, registry_));
    result_.scenes.push_back(plans_.back().result);
    if (!plans_.back().result.failure.empty()) say(fmt::format("{}: {}", scene.label(), plans_.back().result.failure));
  }
  check_reference_file();
  const KeepOnInterrupt keep_pieces;
  const FolderLock lock(options_.folder);
  check_folder();  // again: another run may have been quicker
  throw_if_interrupted("planning");
  prepare_folder();  // only now, so that a mistake leaves nothing that stands in the way of the corrected command
  executor_ = make_executor(options_.executor, options_.program, options_.folder / slurm_folder);
  say_left_jobs();
  // References have arrays of their own: what is left of pieces is for run_missing_pieces() to take up.
  const auto references =
      make_executor(options_.executor, options_.program, options_.folder / slurm_folder / slurm_references);
  if (!get_references(*references)) {  // without all references there are no conclusions; earlier ones stay
    result_.interrupted = true;
    return result_;
  }
  load_finished_pieces();
  try {
    result_.interrupted = !run_missing_pieces();
  } catch (const Error&) {  // of this machine, not of a piece
    if (result_.pieces.empty()) throw;
    say(fmt::format("kept: {}; continue with --resume", counted(result_.pieces.size(), "finished piece")));
    save();
    write_page();
    throw;
  }
  save();
  write_page();
  return result_;
}

// ---- the result folder

void ComparisonRunner::check_folder() const {
  if (const fs::path foreign = find_foreign_file(options_.folder); !foreign.empty()) {
    throw_error(ErrorClass::usage,
                "{} exists, but no comparison wrote it ({} has no comparison.json); choose another --output",
                foreign.string(), options_.folder.string());
  }
  const fs::path file = options_.folder / "comparison.json";
  if (!fs::exists(file)) return;
  if (!options_.resume) {
    // Without results it was stopped by a mistake before the first run: nothing is lost.
    if (options_.overwrite || !fs::exists(options_.folder / "results.json")) return;
    throw_error(ErrorClass::usage,
                "{} already holds results; continue them with --resume or replace them with --overwrite",
                options_.folder.string());
  }
  if (read_file(file) != spec_.to_json()) {
    throw_error(ErrorClass::usage,
                "{} holds a different comparison; give the same arguments to resume it, or choose another --output",
                options_.folder.string());
  }
}

void ComparisonRunner::prepare_folder() {
  const fs::path file = options_.folder / "comparison.json";
  if (!options_.resume && fs::exists(file)) remove_results(options_.folder);
  if (!fs::exists(file)) write_file_atomically(file, spec_.to_json());
  for (const char* name : {"pieces", "references", "means"}) fs::create_directories(options_.folder / name);
}

void ComparisonRunner::save() {
  const Stopwatch saving;
  std::sort(result_.pieces.begin(), result_.pieces.end(), [](const PieceResult& a, const PieceResult& b) {
    return std::tie(a.scene, a.budget, a.seed, a.variant) < std::tie(b.scene, b.budget, b.seed, b.variant);
  });
  update_conclusions();
  write_file_atomically(options_.folder / "results.json", result_.to_json());
  write_file_atomically(options_.folder / "results.csv", result_.pieces_csv());
  write_file_atomically(options_.folder / "curves.csv", result_.snapshots_csv());
  save_seconds_ = saving.seconds();
  save_age_.emplace();
}

void ComparisonRunner::write_page() {
  const Stopwatch writing;
  write_report(options_.folder, options_.report);
  page_seconds_ = writing.seconds();
  page_age_.emplace();
}

void ComparisonRunner::save_when_due() {
  if (save_age_ && save_age_->seconds() < interval_costs * save_seconds_) return;
  save();
  if (page_age_ && page_age_->seconds() < std::max(min_page_interval, interval_costs * page_seconds_)) return;
  write_page();
}

void ComparisonRunner::warn_of_unlike_machines(size_t scene) {
  static const std::string line =
      "its pieces ran on machines of several kinds: nothing is ranked by wall time; compare errors at the same "
      "iterations or samples, or over processor seconds";
  std::vector<std::string>& warnings = result_.scenes[scene].warnings;
  const bool known = std::find(warnings.begin(), warnings.end(), line) != warnings.end();
  const bool unlike = mark_unlike_machines(result_, scene);
  if (unlike == known) return;
  if (unlike) {
    warnings.push_back(line);
  } else {
    std::erase(warnings, line);
  }
  for (size_t budget = 0; budget < spec_.budgets.size(); ++budget)
    add_times_to_error(result_, scene, budget, result_.summaries);
}

void ComparisonRunner::update_conclusions() {
  for (size_t scene = 0; scene < result_.scenes.size(); ++scene) warn_of_unlike_machines(scene);
  std::sort(changed_.begin(), changed_.end());  // each once, however many seeds are new: a bias reads all their images
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  for (const SummaryKey& key : changed_) {
    const auto [scene, variant, budget] = key;
    const std::vector<const PieceResult*> pieces = pieces_of(result_, key);
    if (pieces.empty()) continue;
    const ReferenceResult& reference = reference_of(scene, variant);
    Summary summary = summarize(pieces, reference, spec_.budgets[budget]);
    if (pieces.size() > 1) summary.bias = measure_bias(pieces, reference, options_.folder);
    result_.summaries[key] = std::move(summary);
    add_times_to_error(result_, scene, budget, result_.summaries);
  }
  changed_.clear();
  result_.gates = apply_gates(options_.gates, result_);
  if (!options_.baseline.empty()) result_.baseline = compare_with_baseline(result_, options_.baseline);
  if (options_.experiment) result_.reproduction = reproduce(*options_.experiment, result_, image_pairs_);
}

}  // namespace lucarium
