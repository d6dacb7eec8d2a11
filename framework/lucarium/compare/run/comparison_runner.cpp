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
#include "lucarium/base/json.h"
#include "lucarium/base/text/spelling.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/results/baseline.h"
#include "lucarium/compare/results/piece.h"
#include "lucarium/compare/results/result_folder.h"
#include "lucarium/compare/results/summary.h"
#include "lucarium/film/image_io.h"
#include "lucarium/job/run_job.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// Between two reports while it runs: encoding pictures may take a tenth of the time at most.
constexpr double min_page_interval = 60;  // [s]
constexpr double page_interval_costs = 10;

/// Whether the budget ended before all light was in the picture.
bool is_unfinished(const PieceResult& piece) {
  return piece.failure.empty() && !piece.render_summary.empty() &&
         json::parse(piece.render_summary).value("partial", false);
}

/// What was lowered for a budget of time, "points_log2 18 -> 15"; empty: nothing.
std::string planned_changes(const PieceResult& piece) {
  if (!piece.failure.empty() || piece.render_summary.empty()) return "";
  return json::parse(piece.render_summary).value("planned", "");
}

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

void ComparisonRunner::say(const std::string& line) const {
  if (options_.progress) options_.progress(line);
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
  for (size_t scene = 0; scene < spec_.scenes.size() && !interrupt_requested(); ++scene) {
    if (!result_.scenes[scene].failure.empty()) continue;
    get_references(scene);
    choose_exposure(scene);
  }
  if (interrupt_requested()) {  // without all references there are no conclusions; earlier ones stay
    result_.interrupted = true;
    return result_;
  }
  load_finished_pieces();
  try {
    result_.interrupted = !run_missing_pieces();
  } catch (const Error&) {  // of this machine, not of a piece
    if (result_.pieces.empty()) throw;
    say(fmt::format("kept: {}; continue with --resume", counted(result_.pieces.size(), "finished piece")));
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
  std::sort(result_.pieces.begin(), result_.pieces.end(), [](const PieceResult& a, const PieceResult& b) {
    return std::tie(a.scene, a.budget, a.seed, a.variant) < std::tie(b.scene, b.budget, b.seed, b.variant);
  });
  update_conclusions();
  write_file_atomically(options_.folder / "results.json", result_.to_json());
  write_file_atomically(options_.folder / "results.csv", result_.pieces_csv());
  write_file_atomically(options_.folder / "curves.csv", result_.snapshots_csv());
}

void ComparisonRunner::write_page() {
  const Stopwatch writing;
  write_report(options_.folder, options_.report);
  page_seconds_ = writing.seconds();
  page_age_.emplace();
}

bool ComparisonRunner::page_is_due() const {
  return !page_age_ || page_age_->seconds() > std::max(min_page_interval, page_interval_costs * page_seconds_);
}

void ComparisonRunner::update_conclusions() {
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

// ---- pieces

bool ComparisonRunner::is_wanted(size_t scene, size_t variant) const {
  const SceneResult& entry = result_.scenes[scene];
  return entry.failure.empty() && entry.variants[variant].refused.empty() &&
         reference_of(scene, variant).failure.empty();
}

const ReferenceResult& ComparisonRunner::reference_of(size_t scene, size_t variant) const {
  return result_.scenes[scene].references.at(result_.scenes[scene].variants[variant].reference);
}

bool ComparisonRunner::is_finished(const SummaryKey& key, uint32_t seed) const {
  return std::any_of(result_.pieces.begin(), result_.pieces.end(), [&](const PieceResult& piece) {
    return SummaryKey{piece.scene, piece.variant, piece.budget} == key && piece.seed == seed;
  });
}

/// Returns false when interrupted before all is done.
bool ComparisonRunner::run_missing_pieces() {
  size_t total = 0, number = 0;
  bool complete = true;  // no piece was dropped that was passed before
  for (const ScenePlan& plan : plans_) total += plan.pieces * spec_.budgets.size() * spec_.seeds;
  for (size_t scene = 0; scene < spec_.scenes.size(); ++scene) {
    for (size_t budget = 0; budget < spec_.budgets.size(); ++budget) {
      // Interleaved: all variants of a seed before the next seed, so that a slow spell of the machine hits all alike.
      for (uint32_t seed = 1; seed <= spec_.seeds; ++seed) {
        for (size_t variant = 0; variant < spec_.variants.size(); ++variant) {
          if (!is_wanted(scene, variant)) continue;
          ++number;
          if (is_finished({scene, variant, budget}, seed)) continue;
          if (interrupt_requested()) return false;
          PieceResult piece = run_piece(scene, variant, budget, seed);
          if (interrupt_requested() && !piece.failure.empty()) return false;  // its partial result does not count
          log_result(piece, number, total);
          if (drop_unlike_pieces(piece)) complete = false;
          add_piece(std::move(piece));
          save();
          if (page_is_due()) write_page();
        }
      }
    }
  }
  return complete || run_missing_pieces();
}

/// Removes pieces of other seeds that were rendered with other parameters than this one, by another machine or version
/// that planned otherwise for the budget: means of unlike pictures say nothing. Returns whether there were any.
bool ComparisonRunner::drop_unlike_pieces(const PieceResult& piece) {
  if (!piece.failure.empty()) return false;
  const auto unlike = [&](const PieceResult& other) {
    return other.failure.empty() && other.scene == piece.scene && other.variant == piece.variant &&
           other.budget == piece.budget && other.parameters != piece.parameters;
  };
  for (const PieceResult& other : result_.pieces) {
    if (!unlike(other)) continue;
    say(fmt::format(
        "{}: rendered with other parameters ({}) than seed {} ({}); again",
        (options_.folder / (piece_stem(other.scene, other.variant, other.budget, other.seed) + ".json")).string(),
        other.parameters, piece.seed, piece.parameters));
  }
  if (std::erase_if(result_.pieces, unlike) == 0) return false;
  result_.scenes[piece.scene].warnings = plans_[piece.scene].result.warnings;
  for (const PieceResult& other : result_.pieces)
    if (other.scene == piece.scene) add_warnings(other);
  return true;
}

void ComparisonRunner::log_result(const PieceResult& piece, size_t number, size_t total) const {
  std::string outcome = piece.failure;
  if (outcome.empty()) {
    outcome = fmt::format("relMSE {:.3g} after {:.1f} s, {} per pixel", piece.metrics.at("relMSE"), piece.seconds(),
                          counted(piece.samples, "sample"));
    if (piece.walk) {
      outcome += fmt::format(", walk {:.3g} s per frame", piece.walk->median_seconds);
      if (piece.walk->relmse) outcome += fmt::format(" with relMSE {:.3g}", *piece.walk->relmse);
    }
    if (is_unfinished(piece)) outcome += ", unfinished: light is missing, or the picture is coarse";
    if (spec_.budgets[piece.budget].relmse > 0) {
      outcome += piece.reached_seconds ? fmt::format(", reached after {:.1f} s", *piece.reached_seconds)
                                       : ", not reached in time";
    }
  }
  say(fmt::format("[{}/{}] {}  {}  {}  seed {}: {}", number, total, result_.scenes[piece.scene].name,
                  spec_.variants[piece.variant].label(), spec_.budgets[piece.budget].label(), piece.seed, outcome));
}

void ComparisonRunner::add_piece(PieceResult piece) {
  changed_.push_back({piece.scene, piece.variant, piece.budget});
  add_warnings(piece);
  result_.pieces.push_back(std::move(piece));
}

void ComparisonRunner::add_warnings(const PieceResult& piece) {
  if (is_unfinished(piece)) {
    result_.scenes[piece.scene].warnings.push_back(
        fmt::format("{}, {}, seed {}: the budget ended too early; light is missing, or the picture is coarse",
                    spec_.variants[piece.variant].label(), spec_.budgets[piece.budget].label(), piece.seed));
  }
  if (const std::string changes = planned_changes(piece); !changes.empty()) {
    std::vector<std::string>& warnings = result_.scenes[piece.scene].warnings;
    const std::string line = fmt::format("{}, {}: lowered for the budget: {}", spec_.variants[piece.variant].label(),
                                         spec_.budgets[piece.budget].label(), changes);
    if (std::find(warnings.begin(), warnings.end(), line) == warnings.end()) warnings.push_back(line);
  }
}

PieceResult ComparisonRunner::run_piece(size_t scene, size_t variant, size_t budget, uint32_t seed) {
  PieceResult piece{scene, variant, budget, seed};
  const std::string stem = piece_stem(scene, variant, budget, seed);
  const fs::path image = options_.folder / (stem + ".exr");
  Job job = scene_job(spec_, spec_.scenes[scene], plans_[scene], options_, seed);
  job.overrides.exposure = result_.scenes[scene].exposure;
  RenderWork work = work_within(spec_.budgets[budget]);
  work.technique = spec_.variants[variant].technique;
  work.parameters = spec_.variants[variant].parameters;
  work.reference = options_.folder / reference_of(scene, variant).image;
  work.output = image;
  if (spec_.walk) {
    work.walk.frames = spec_.walk->frames;
    work.walk.samples = spec_.walk->samples;
    for (const ReferenceResult::Frame& frame : reference_of(scene, variant).walk) {
      work.walk.reference_frames.push_back(frame.frame);
      work.walk.references.push_back(options_.folder / frame.image);
    }
  }
  job.work = work;
  const ChildResult child = run_job({options_.program.string()}, job, [&](std::string_view line) {
    if (job.verbose && !line.starts_with(error_prefix)) say("  " + std::string(line));
  });
  if (child.exit_code == static_cast<int>(ErrorClass::interrupted)) set_interrupt_requested(true);
  if (child.exit_code != 0) {
    std::error_code ignored;
    fs::remove(image, ignored);
    piece.failure =
        fmt::format("{}: {}", describe_end(child), child.last_words.empty() ? "no message" : child.last_words.back());
    return piece;
  }
  try {
    json summary = frame_of(child);
    summary["peak_host_bytes"] = child.peak_memory_bytes;
    piece.render_summary = summary.dump(1);
    read_summary(piece, spec_.budgets[budget]);
    piece.image = stem + ".exr";
    result_.device = summary.at("device");
    result_.driver = summary.at("driver");
  } catch (const std::exception& error) {
    piece.failure = error.what();
    return piece;
  }
  write_file_atomically(options_.folder / (stem + ".json"), piece.render_summary);
  return piece;
}

void ComparisonRunner::load_finished_pieces() {
  if (!options_.resume) return;
  for (size_t scene = 0; scene < spec_.scenes.size(); ++scene) {
    for (size_t variant = 0; variant < spec_.variants.size(); ++variant) {
      if (!is_wanted(scene, variant)) continue;
      for (size_t budget = 0; budget < spec_.budgets.size(); ++budget) {
        for (uint32_t seed = 1; seed <= spec_.seeds; ++seed) {
          PieceResult piece{scene, variant, budget, seed};
          if (!load_finished_piece(piece)) continue;
          drop_unlike_pieces(piece);  // those of the last seeds are the newest
          add_piece(std::move(piece));
        }
      }
    }
  }
  if (!result_.pieces.empty()) say(fmt::format("finished already: {}", counted(result_.pieces.size(), "piece")));
}

bool ComparisonRunner::load_finished_piece(PieceResult& piece) {
  // The summary is written after the image, so its presence means that the piece is whole. What is damaged, or was
  // rendered from another state of the scene, the reference or the program, is rendered again.
  const std::string stem = piece_stem(piece.scene, piece.variant, piece.budget, piece.seed);
  const fs::path file = options_.folder / (stem + ".json");
  if (!fs::exists(file)) return false;
  try {
    piece.render_summary = read_file(file);
    piece.image = stem + ".exr";
    const json summary = json::parse(piece.render_summary);
    if (summary.at("scene_hash") != result_.scenes[piece.scene].hash || summary.at("version") != LUCARIUM_VERSION ||
        summary.at("path_set") != reference_of(piece.scene, piece.variant).path_set) {
      say(fmt::format("{}: rendered from another scene or by another version; rendering it again", file.string()));
      return false;
    }
    read_image(options_.folder / piece.image);  // throws when it is damaged
    read_summary(piece, spec_.budgets[piece.budget]);
    result_.device = summary.at("device");
    result_.driver = summary.at("driver");
    return true;
  } catch (const std::exception& error) {
    say(fmt::format("{}: not usable, rendering it again: {}", file.string(), error.what()));
    return false;
  }
}

}  // namespace lucarium
