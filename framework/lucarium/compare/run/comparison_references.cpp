// SPDX-License-Identifier: Apache-2.0
// The references of a comparison: from a file, from the cache, or rendered into the cache. Declared in
// comparison_runner.h.
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/reference/reference_image.h"
#include "lucarium/compare/run/comparison_runner.h"
#include "lucarium/compare/run/reference_file.h"
#include "lucarium/film/exposure.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

bool ComparisonRunner::get_references(PieceExecutor& executor) {
  std::vector<MissingImage> missing;
  for (size_t scene = 0; scene < result_.scenes.size(); ++scene) {
    if (!result_.scenes[scene].failure.empty()) continue;
    for (size_t index = 0; index < result_.scenes[scene].references.size(); ++index) {
      try {
        read_reference(scene, index);
        find_missing(scene, index, missing);
      } catch (const Error& error) {
        fail_reference(scene, index, error);
      }
    }
  }
  render_missing(missing, executor);
  if (interrupt_requested()) return false;
  for (size_t scene = 0; scene < result_.scenes.size(); ++scene) choose_exposure(scene);
  return true;
}

/// Of several references the others go on without one.
void ComparisonRunner::fail_reference(size_t scene, size_t index, const Error& error) {
  if (error.error_class() == ErrorClass::interrupted) throw error;
  SceneResult& entry = result_.scenes[scene];
  if (spec_.scenes.size() == 1 && entry.references.size() == 1) throw error;
  entry.references[index].failure = error.what();
  say(fmt::format("{}: no reference: {}", entry.name, error.what()));
}

/// What is there of a reference before anything is rendered: a file of the user's, or that of an earlier start.
void ComparisonRunner::read_reference(size_t scene, size_t index) {
  ReferenceResult& reference = result_.scenes[scene].references[index];
  reference.image = fmt::format("references/scene{}-set{}.exr", scene + 1, index + 1);
  for (size_t i = 0; i < plans_[scene].walk_frames.size(); ++i) {
    const uint32_t frame = plans_[scene].walk_frames[i];
    reference.walk.push_back({frame, plans_[scene].walk_cameras[i],
                              fmt::format("references/scene{}-set{}-frame{}.exr", scene + 1, index + 1, frame)});
  }
  if (!spec_.reference.file) return;
  write_exr(options_.folder / reference.image, read_reference_file(spec_, result_.scenes[scene], reference));
  reference.source = spec_.reference.file->filename().string();
}

void ComparisonRunner::find_missing(size_t scene, size_t index, std::vector<MissingImage>& missing) {
  const ScenePlan& plan = plans_[scene];
  const ReferenceResult& reference = result_.scenes[scene].references[index];
  const fs::path cache = options_.cache_dir / "references";
  const size_t before = missing.size();
  if (!spec_.reference.file && !keep_reference(scene, index)) {
    missing.push_back({scene, index, {}, cache / plan.reference_files[index], options_.folder / reference.image});
  }
  for (size_t i = 0; i < reference.walk.size(); ++i) {
    const fs::path file = options_.folder / reference.walk[i].image;
    if (options_.resume && fs::exists(file)) continue;
    missing.push_back({scene, index, i, cache / plan.walk_files[index][i], file});
  }
  if (missing.size() == before) finish_reference(scene, index);
}

/// One exposure for all pictures of a scene: the first reference decides where none is stated.
void ComparisonRunner::choose_exposure(size_t scene) {
  SceneResult& entry = result_.scenes[scene];
  if (!plans_[scene].automatic_exposure) return;
  for (const ReferenceResult& reference : entry.references) {
    const fs::path file = options_.folder / reference.image;
    if (reference.image.empty() || !reference.failure.empty() || !fs::exists(file)) continue;
    entry.exposure = automatic_exposure(read_image(file).image());
    return;
  }
}

void ComparisonRunner::check_reference_file() const {
  if (!spec_.reference.file) return;
  for (const SceneResult& scene : result_.scenes) check_one_reference(scene);
  // Of several scenes the others go on without it.
  if (result_.scenes.size() == 1 && !result_.scenes[0].references.empty())
    read_reference_file(spec_, result_.scenes[0], result_.scenes[0].references[0]);
}

void ComparisonRunner::measure_reference(ReferenceResult& reference) {
  ReferenceError own;
  reference.error_known = estimate_reference_error(read_image(options_.folder / reference.image), own);
  reference.mse = own.mse;
  reference.relmse = own.relmse;
  const std::string how =
      spec_.reference.file ? reference.source
      : reference.from_cache
          ? fmt::format("from the cache, {} per pixel", counted(reference.samples, "sample"))
          : fmt::format("{} per pixel, {:.1f} s", counted(reference.samples, "sample"), reference.seconds);
  say(fmt::format("  reference: {}{}", how,
                  reference.error_known ? fmt::format(", error of the reference: relMSE {:.2g}", own.relmse) : ""));
}

/// A cached file that suffices is left as it is; a smaller one, also of an interrupted run, is extended.
PieceTask ComparisonRunner::reference_task(const MissingImage& image) const {
  const ReferenceResult& reference = result_.scenes[image.scene].references[image.index];
  PieceTask task;
  task.name = image.image.stem().string();
  task.job = scene_job(spec_, spec_.scenes[image.scene], plans_[image.scene], options_, reference_seed);
  if (image.walk_frame) {
    task.job.overrides.camera_path = "none";
    task.job.overrides.camera = reference.walk[*image.walk_frame].camera;
  }
  task.job.work = ReferenceWork{reference.path_set, spec_.reference.samples, spec_.reference.relmse, image.cached};
  task.lock = image.cached.string() + ".lock";
  return task;
}

/// Unless another process has replaced it since, or is about to.
void ComparisonRunner::remove_unusable(const MissingImage& image) const {
  const FileLock lock(image.cached.string() + ".lock",
                      [this] { say("  waiting for another run that renders the same"); });
  std::error_code ignored;
  if (FileState(image.cached) == image.was_cached) fs::remove(image.cached, ignored);
}

/// A reference is finished when its last image has come.
void ComparisonRunner::render_missing(std::vector<MissingImage>& missing, PieceExecutor& executor) {
  std::vector<MissingImage> again;  // what was cached is damaged
  std::map<std::pair<size_t, size_t>, size_t> left;
  std::vector<PieceTask> tasks;
  for (MissingImage& image : missing) {
    image.was_cached = FileState(image.cached);
    ++left[{image.scene, image.index}];
    tasks.push_back(reference_task(image));
  }
  PieceEvents events;
  events.on_start = [&](size_t task) {
    const SceneResult& scene = result_.scenes[missing[task].scene];
    const auto& [index, frame] = std::pair(missing[task].index, missing[task].walk_frame);
    say(frame ? fmt::format("{}: reference of frame {} of the walk", scene.name,
                            scene.references[index].walk[*frame].frame)
              : fmt::format("{}: reference {} of {}", scene.name, index + 1, scene.references.size()));
  };
  events.say = [this](const std::string& line) { say("  " + line); };
  events.progress = [this](double fraction, const std::string& text) { show_progress(fraction, text); };
  events.on_line = [&](size_t, std::string_view line) {
    // Its error is reported when it has ended, and its advice how to go on is not that of a comparison.
    if (!interrupt_requested() && !line.starts_with(error_prefix)) say("  " + std::string(line));
  };
  events.on_end = [&](size_t task, const PieceEnd& end) {
    MissingImage& image = missing[task];
    const ChildResult& child = end.child;
    // The signal that reached this process may have reached the child before it could answer to it.
    if (child.exit_code == static_cast<int>(ErrorClass::interrupted) || (child.signal != 0 && interrupt_requested())) {
      set_interrupt_requested(true);
      return;
    }
    if (image.was_cached.exists() && child.exit_code == static_cast<int>(ErrorClass::input)) {
      say("  the cached reference is not usable; rendering it again");
      again.push_back(image);
      return;
    }
    if (!result_.scenes[image.scene].references[image.index].failure.empty()) return;  // for another image of it
    try {
      if (child.exit_code != 0)
        throw_error(class_of_end(child), "the reference was not rendered: {}", reason_of_end(child));
      keep_rendered(image, child);
      if (--left[{image.scene, image.index}] == 0) finish_reference(image.scene, image.index);
    } catch (const Error& error) {
      fail_reference(image.scene, image.index, error);
    }
  };
  if (!tasks.empty()) executor.run(tasks, events);
  progress_.reset();
  if (again.empty() || interrupt_requested()) return;
  try {
    for (const MissingImage& image : again) remove_unusable(image);  // now, as nothing that runs has to wait for it
  } catch (const Error& error) {
    if (error.error_class() != ErrorClass::interrupted) throw;
    set_interrupt_requested(true);
    return;
  }
  render_missing(again, executor);
}

void ComparisonRunner::keep_rendered(const MissingImage& image, const ChildResult& child) {
  ReferenceResult& reference = result_.scenes[image.scene].references[image.index];
  if (!image.walk_frame) {
    const json summary = json::parse(child.out);
    result_.device = summary.at("device");
    result_.driver = summary.at("driver");
    reference.source = "path_tracing";
    reference.samples = summary.at("samples");
    reference.seconds = summary.at("seconds");
    reference.from_cache = summary.at("rounds_rendered") == 0;
  }
  write_file_atomically(image.image, [&](const fs::path& part) { fs::copy_file(image.cached, part); });
}

void ComparisonRunner::finish_reference(size_t scene, size_t index) {
  measure_reference(result_.scenes[scene].references[index]);
}

/// Whether the result folder holds the reference from an earlier start of this comparison. It stays, even when the
/// cache has grown a better one since: the finished pieces were measured against it.
bool ComparisonRunner::keep_reference(size_t scene, size_t index) {
  ReferenceResult& reference = result_.scenes[scene].references[index];
  const fs::path file = options_.folder / reference.image;
  if (!options_.resume || !fs::exists(file)) return false;
  try {
    const Film film = read_image(file);
    if (film.metadata.at("identity") + ".exr" != plans_[scene].reference_files[index]) return false;
    reference.samples = std::stoull(film.metadata.at("samples"));
    reference.seconds = std::stod(film.metadata.at("seconds"));
    result_.device = film.metadata.at("device");
    result_.driver = film.metadata.at("driver");
  } catch (const std::exception&) {
    return false;  // damaged, or no reference: rendered again
  }
  reference.source = "path_tracing";
  reference.from_cache = true;
  return true;
}

}  // namespace lucarium
