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
#include "lucarium/job/run_job.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

void ComparisonRunner::get_references(size_t scene) {
  SceneResult& entry = result_.scenes[scene];
  for (size_t index = 0; index < entry.references.size(); ++index) {
    ReferenceResult& reference = entry.references[index];
    reference.image = fmt::format("references/scene{}-set{}.exr", scene + 1, index + 1);
    try {
      if (spec_.reference.file) {
        write_exr(options_.folder / reference.image, read_reference_file(spec_, entry, reference));
        reference.source = spec_.reference.file->filename().string();
      } else if (!render_reference(scene, index)) {
        return;
      }
      if (!render_walk_references(scene, index)) return;
      measure_reference(reference);
    } catch (const Error& error) {
      if (error.error_class() == ErrorClass::interrupted) throw;
      if (spec_.scenes.size() == 1 && entry.references.size() == 1) throw;
      reference.failure = error.what();
      say(fmt::format("{}: no reference: {}", entry.name, reference.failure));
    }
  }
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

Job ComparisonRunner::reference_job(size_t scene, size_t index) const {
  Job job = scene_job(spec_, spec_.scenes[scene], plans_[scene], options_, reference_seed);
  job.work = ReferenceWork{
      result_.scenes[scene].references[index].path_set, spec_.reference.samples, spec_.reference.relmse, {}};
  return job;
}

/// A cached file that suffices is left as it is; a smaller one, also of an interrupted run, is extended.
std::optional<ChildResult> ComparisonRunner::render_into_cache(const Job& job, const fs::path& cached) {
  std::error_code ignored;
  fs::create_directories(cached.parent_path(), ignored);
  const FileLock lock(cached.string() + ".lock", [&] { say("  waiting for another run that renders the same"); });
  Job whole = job;
  std::get<ReferenceWork>(whole.work).output = cached;
  const auto run = [&] {
    return run_job({options_.program.string()}, whole, [&](std::string_view line) {
      // Its error is reported when it has ended, and its advice how to go on is not that of a comparison.
      if (!interrupt_requested() && !line.starts_with(error_prefix)) say("  " + std::string(line));
    });
  };
  const bool was_cached = fs::exists(cached);
  ChildResult child = run();
  if (was_cached && child.exit_code == static_cast<int>(ErrorClass::input)) {
    say("  the cached reference is not usable; rendering it again");
    fs::remove(cached, ignored);
    child = run();
  }
  // The signal that reached this process may have reached the child before it could answer to it.
  if (child.exit_code == static_cast<int>(ErrorClass::interrupted) || (child.signal != 0 && interrupt_requested())) {
    set_interrupt_requested(true);
    return std::nullopt;
  }
  if (child.exit_code != 0)
    throw_error(class_of_end(child), "the reference was not rendered: {}", reason_of_end(child));
  return child;
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

/// The truth for frames of a walk; those of an earlier start stay. Returns false when interrupted.
bool ComparisonRunner::render_walk_references(size_t scene, size_t index) {
  const ScenePlan& plan = plans_[scene];
  ReferenceResult& reference = result_.scenes[scene].references[index];
  for (size_t i = 0; i < plan.walk_frames.size(); ++i) {
    ReferenceResult::Frame frame{plan.walk_frames[i], plan.walk_cameras[i], ""};
    frame.image = fmt::format("references/scene{}-set{}-frame{}.exr", scene + 1, index + 1, frame.frame);
    const fs::path file = options_.folder / frame.image;
    if (!options_.resume || !fs::exists(file)) {
      say(fmt::format("{}: reference of frame {} of the walk", result_.scenes[scene].name, frame.frame));
      Job job = reference_job(scene, index);
      job.overrides.camera_path = "none";
      job.overrides.camera = frame.camera;
      const fs::path cached = options_.cache_dir / "references" / plan.walk_files[index][i];
      if (!render_into_cache(job, cached)) return false;
      write_file_atomically(file, [&](const fs::path& part) { fs::copy_file(cached, part); });
    }
    reference.walk.push_back(std::move(frame));
  }
  return true;
}

/// Returns false when interrupted.
bool ComparisonRunner::render_reference(size_t scene, size_t index) {
  if (keep_reference(scene, index)) return true;
  ReferenceResult& reference = result_.scenes[scene].references[index];
  const fs::path cached = options_.cache_dir / "references" / plans_[scene].reference_files[index];
  say(fmt::format("{}: reference {} of {}", result_.scenes[scene].name, index + 1,
                  result_.scenes[scene].references.size()));
  const std::optional<ChildResult> child = render_into_cache(reference_job(scene, index), cached);
  if (!child) return false;
  const json summary = json::parse(child->out);
  result_.device = summary.at("device");
  result_.driver = summary.at("driver");
  reference.source = "path_tracing";
  reference.samples = summary.at("samples");
  reference.seconds = summary.at("seconds");
  reference.from_cache = summary.at("rounds_rendered") == 0;
  write_file_atomically(options_.folder / reference.image, [&](const fs::path& part) { fs::copy_file(cached, part); });
  return true;
}

}  // namespace lucarium
