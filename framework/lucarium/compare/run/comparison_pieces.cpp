// SPDX-License-Identifier: Apache-2.0
// The pieces of a comparison: what is to run, and what has come back. Declared in comparison_runner.h.
#include <algorithm>
#include <set>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/results/piece.h"
#include "lucarium/compare/run/comparison_runner.h"
#include "lucarium/film/image_io.h"
#include "lucarium/job/run_job.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

// How often a piece may have others rendered again: two machines could go on for ever.
constexpr int max_drops = 3;

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

}  // namespace

bool ComparisonRunner::is_wanted(size_t scene, size_t variant) const {
  const SceneResult& entry = result_.scenes[scene];
  return entry.failure.empty() && entry.variants[variant].refused.empty() &&
         reference_of(scene, variant).failure.empty();
}

const ReferenceResult& ComparisonRunner::reference_of(size_t scene, size_t variant) const {
  return result_.scenes[scene].references.at(result_.scenes[scene].variants[variant].reference);
}

/// In the order in which they are to run: all variants of a seed before the next seed, so that a slow spell of the
/// machine hits all alike. `total`: with those that are finished.
std::vector<PieceResult> ComparisonRunner::missing_pieces(size_t& total) const {
  std::set<std::pair<SummaryKey, uint32_t>> finished;
  for (const PieceResult& piece : result_.pieces)
    finished.insert({{piece.scene, piece.variant, piece.budget}, piece.seed});
  std::vector<PieceResult> missing;
  total = 0;
  for (size_t scene = 0; scene < spec_.scenes.size(); ++scene) {
    for (size_t budget = 0; budget < spec_.budgets.size(); ++budget) {
      for (uint32_t seed = 1; seed <= spec_.seeds; ++seed) {
        for (size_t variant = 0; variant < spec_.variants.size(); ++variant) {
          if (!is_wanted(scene, variant)) continue;
          ++total;
          if (!finished.contains({{scene, variant, budget}, seed})) missing.push_back({scene, variant, budget, seed});
        }
      }
    }
  }
  return missing;
}

bool ComparisonRunner::run_missing_pieces() {
  size_t total = 0;
  for (;;) {  // a piece may show that others have to be rendered again
    std::vector<PieceResult> missing = missing_pieces(total);
    if (missing.empty()) return true;
    if (interrupt_requested()) return false;
    std::vector<PieceTask> tasks;
    for (const PieceResult& piece : missing) tasks.push_back(piece_task(piece));
    PieceEvents events;
    events.on_start = [](size_t) {};
    events.say = [this](const std::string& line) { say("  " + line); };
    events.progress = [this](double fraction, const std::string& text) { show_progress(fraction, text); };
    events.on_line = [&](size_t task, std::string_view line) {
      if (tasks[task].job.verbose && !line.starts_with(error_prefix)) say("  " + std::string(line));
    };
    events.on_end = [&](size_t task, const PieceEnd& end) {
      PieceResult& piece = missing[task];
      finish_piece(piece, end);
      if (interrupt_requested() && !piece.failure.empty()) return;  // its partial result does not count
      drop_unlike_pieces(piece);
      if (!executor_->shows_progress() || !piece.failure.empty()) log_result(piece, result_.pieces.size() + 1, total);
      add_piece(std::move(piece));
      save_when_due();
    };
    executor_->run(tasks, events);
    progress_.reset();
    if (interrupt_requested() && !missing_pieces(total).empty()) return false;
  }
}

/// Removes pieces of other seeds that were rendered with other parameters than this one, by another machine or version
/// that planned otherwise for the budget: means of unlike pictures say nothing.
void ComparisonRunner::drop_unlike_pieces(const PieceResult& piece) {
  if (!piece.failure.empty()) return;
  int& drops = drops_[{piece.scene, piece.variant, piece.budget}];
  const auto unlike = [&](const PieceResult& other) {
    return other.failure.empty() && other.scene == piece.scene && other.variant == piece.variant &&
           other.budget == piece.budget && other.parameters != piece.parameters;
  };
  if (std::none_of(result_.pieces.begin(), result_.pieces.end(), unlike)) return;
  if (++drops > max_drops) {
    const std::string line = fmt::format("{}, {}: unlike machines planned unlike parameters; give them all",
                                         spec_.variants[piece.variant].label(), spec_.budgets[piece.budget].label());
    std::vector<std::string>& warnings = result_.scenes[piece.scene].warnings;
    if (std::find(warnings.begin(), warnings.end(), line) == warnings.end()) warnings.push_back(line);
    return;
  }
  for (const PieceResult& other : result_.pieces) {
    if (!unlike(other)) continue;
    say(fmt::format(
        "{}: rendered with other parameters ({}) than seed {} ({}); again",
        (options_.folder / (piece_stem(other.scene, other.variant, other.budget, other.seed) + ".json")).string(),
        other.parameters, piece.seed, piece.parameters));
  }
  std::erase_if(result_.pieces, unlike);
  result_.scenes[piece.scene].warnings = plans_[piece.scene].result.warnings;
  for (const PieceResult& other : result_.pieces)
    if (other.scene == piece.scene) add_warnings(other);
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

PieceTask ComparisonRunner::piece_task(const PieceResult& piece) const {
  const ComparisonBudget& budget = spec_.budgets[piece.budget];
  const std::string stem = piece_stem(piece.scene, piece.variant, piece.budget, piece.seed);
  PieceTask task;
  task.name = fs::path(stem).filename().string();
  if (budget.seconds > 0 || budget.relmse > 0)
    task.like = fmt::format("scene{}-budget{}-seed{}", piece.scene + 1, piece.budget + 1, piece.seed);
  task.job = scene_job(spec_, spec_.scenes[piece.scene], plans_[piece.scene], options_, piece.seed);
  task.job.overrides.exposure = result_.scenes[piece.scene].exposure;
  const ReferenceResult& reference = reference_of(piece.scene, piece.variant);
  RenderWork work = work_within(budget);
  work.technique = spec_.variants[piece.variant].technique;
  work.parameters = spec_.variants[piece.variant].parameters;
  work.reference = options_.folder / reference.image;
  work.output = options_.folder / (stem + ".exr");
  if (spec_.walk) {
    work.walk.frames = spec_.walk->frames;
    work.walk.samples = spec_.walk->samples;
    for (const ReferenceResult::Frame& frame : reference.walk) {
      work.walk.reference_frames.push_back(frame.frame);
      work.walk.references.push_back(options_.folder / frame.image);
    }
  }
  task.job.work = work;
  return task;
}

void ComparisonRunner::finish_piece(PieceResult& piece, const PieceEnd& end) {
  const std::string stem = piece_stem(piece.scene, piece.variant, piece.budget, piece.seed);
  if (end.child.exit_code == static_cast<int>(ErrorClass::interrupted)) set_interrupt_requested(true);
  piece.failure = end.failure;
  if (!piece.failure.empty()) {
    std::error_code ignored;
    fs::remove(options_.folder / (stem + ".exr"), ignored);
    return;
  }
  try {
    json summary = frame_of(end.child);
    if (!fits(summary, piece))
      throw_error(ErrorClass::input,
                  "rendered from another state of the scene or by another version, while the "
                  "comparison ran; continue with --resume");
    summary["peak_host_bytes"] = end.child.peak_memory_bytes;
    summary["machine"] = piece_machine_json(end.machine);
    piece.render_summary = summary.dump(1);
    read_summary(piece, spec_.budgets[piece.budget]);
    piece.image = stem + ".exr";
    result_.device = summary.at("device");
    result_.driver = summary.at("driver");
  } catch (const std::exception& error) {
    piece.failure = error.what();
    return;
  }
  write_file_atomically(options_.folder / (stem + ".json"), piece.render_summary);
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

bool ComparisonRunner::fits(const json& summary, const PieceResult& piece) const {
  return summary.at("scene_hash") == result_.scenes[piece.scene].hash && summary.at("version") == LUCARIUM_VERSION &&
         reference_of(piece.scene, piece.variant).is_for(summary.at("path_set").get<std::string>());
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
    if (!fits(summary, piece)) {
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
