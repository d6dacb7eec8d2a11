// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/comparison_runner.h"

#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "lucarium/base/atomic_file.h"
#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/compare/file_lock.h"
#include "lucarium/compare/metrics.h"
#include "lucarium/compare/reference_identity.h"
#include "lucarium/compare/reference_image.h"
#include "lucarium/film/image_io.h"
#include "lucarium/version.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint64_t reference_seed = 0x5eed;  // not one of the pieces' seeds 1, 2, …

RenderSettings settings_of(const ComparisonSpec& spec, const Scene& scene) {
  RenderSettings settings;
  settings.width = spec.width;
  settings.height = spec.height;
  settings.max_bounces = spec.max_bounces;
  settings.pixel_sampling = spec.pixel_sampling;
  settings.camera = scene.cameras.front();
  return settings;
}

void check_spec(const ComparisonSpec& spec) {
  if (spec.scenes.empty()) throw_error(ErrorClass::usage, "no scene given; name a file or builtin:cornell");
  if (spec.variants.empty()) throw_error(ErrorClass::usage, "no technique given; add -t path_tracing");
  if ((spec.budget.seconds > 0) == (spec.budget.iterations > 0)) {
    throw_error(ErrorClass::usage, "give exactly one budget: --time SECONDS or --iterations N");
  }
  if (spec.seeds == 0) throw_error(ErrorClass::usage, "--seeds must be at least 1");
  if (spec.reference && spec.scenes.size() > 1) {
    throw_error(ErrorClass::usage, "--reference FILE goes with one scene; {} were given", spec.scenes.size());
  }
}

}  // namespace

ComparisonResult run_comparison(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                const ComparisonOptions& options) {
  return ComparisonRunner(spec, registry, options).run();
}

ComparisonRunner::ComparisonRunner(const ComparisonSpec& spec, const TechniqueRegistry& registry,
                                   const ComparisonOptions& options)
    : spec_(spec), registry_(registry), options_(options) {
  check_spec(spec_);
  result_.spec = spec_;
  result_.version = LUCARIUM_VERSION;
  result_.scenes.resize(spec_.scenes.size());
  scene_hashes_.resize(spec_.scenes.size());
  reference_files_.resize(spec_.scenes.size());
  path_sets_.resize(spec_.scenes.size());
  needs_fallback_.resize(spec_.scenes.size());
}

void ComparisonRunner::say(const std::string& line) const {
  if (options_.progress) options_.progress(line);
}

ComparisonResult ComparisonRunner::run() {
  const FolderLock lock(options_.folder);
  check_folder();
  for (size_t i = 0; i < spec_.scenes.size(); ++i) plan_scene(i);
  prepare_folder();  // only now, so that a mistake leaves nothing that stands in the way of the corrected command
  for (size_t i = 0; i < spec_.scenes.size() && !interrupt_requested(); ++i) {
    if (result_.scenes[i].failure.empty()) get_reference(i);
  }
  load_finished_pieces();
  // Interleaved: all variants of a seed before the next seed, so that a slow spell of the machine hits all alike.
  const size_t total = spec_.scenes.size() * spec_.variants.size() * spec_.seeds;
  size_t number = 0;
  for (size_t scene = 0; scene < spec_.scenes.size(); ++scene) {
    for (uint32_t seed = 1; seed <= spec_.seeds; ++seed) {
      for (size_t variant = 0; variant < spec_.variants.size(); ++variant) {
        ++number;
        if (interrupt_requested() || !result_.scenes[scene].failure.empty() || is_finished(scene, variant, seed)) continue;
        PieceResult piece = run_piece(scene, variant, seed);
        if (interrupt_requested() && !piece.failure.empty()) continue;  // its partial result does not count
        say(fmt::format("[{}/{}] {}  {}  seed {}: {}", number, total, spec_.scenes[scene],
                        spec_.variants[variant].label(), seed,
                        piece.failure.empty() ? fmt::format("relMSE {:.3g} after {:.1f} s, {} samples", piece.relmse,
                                                            piece.seconds, piece.samples)
                                              : piece.failure));
        result_.pieces.push_back(std::move(piece));
        save();
      }
    }
  }
  result_.interrupted = interrupt_requested();
  save();
  return result_;
}

void ComparisonRunner::check_folder() const {
  const fs::path file = options_.folder / "comparison.json";
  if (!fs::exists(file)) return;
  if (!options_.resume) {
    if (options_.overwrite) return;
    throw_error(ErrorClass::usage, "{} already holds results; continue them with --resume or replace them with --overwrite",
                options_.folder.string());
  }
  if (read_file(file) != spec_.to_json()) {
    throw_error(ErrorClass::usage,
                "{} holds another comparison than the one asked for; give the same arguments to resume it, or choose "
                "another --output",
                options_.folder.string());
  }
}

void ComparisonRunner::prepare_folder() {
  const fs::path file = options_.folder / "comparison.json";
  if (fs::exists(file)) {
    if (options_.resume) return;
    for (const char* name : {"pieces", "references"}) fs::remove_all(options_.folder / name);
    for (const char* name : {"results.json", "results.csv", "report.html"}) fs::remove(options_.folder / name);
  }
  fs::create_directories(options_.folder / "pieces");
  fs::create_directories(options_.folder / "references");
  write_file_atomically(file, spec_.to_json());
}

void ComparisonRunner::plan_scene(size_t index) {
  SceneResult& entry = result_.scenes[index];
  entry.name = spec_.scenes[index];
  try {
    SceneOverrides overrides = spec_.overrides;
    Scene scene = load_scene(entry.name, overrides);
    if (!scene.has_light() && !spec_.fallback_environment.empty()) {
      needs_fallback_[index] = true;
      overrides.environment = spec_.fallback_environment;
      scene = load_scene(entry.name, overrides);
      scene.warnings.push_back("no light in the file: lit by a uniform environment of " + spec_.fallback_environment);
    }
    require_light(scene);
    entry.triangles = scene.triangle_count();
    entry.hash = scene.hash().hex();
    entry.exposure = spec_.exposure.value_or(scene.exposure);
    entry.warnings = scene.warnings;

    RenderSettings settings = settings_of(spec_, scene);
    std::string first_label;
    for (const TechniqueVariant& variant : spec_.variants) {
      const std::unique_ptr<Technique> technique = registry_.find(variant.technique).create();
      for (const auto& [name, value] : variant.parameters) technique->parameters().set(name, value);
      entry.limitations.push_back(technique->limitations(scene, settings));
      const std::string path_set = technique->path_set(scene, settings).to_string();
      if (path_sets_[index].empty()) {
        path_sets_[index] = path_set;
        first_label = variant.label();
      } else if (path_sets_[index] != path_set) {
        std::string text;
        for (const std::string& line : PathSet::parse(path_set).differences(PathSet::parse(path_sets_[index]))) {
          text += (text.empty() ? "" : "; ") + line;
        }
        throw_error(ErrorClass::usage, "{} and {} compute different light paths and have no common truth: {}", variant.label(),
                    first_label, text);
      }
    }
    const PathSet path_set = PathSet::parse(path_sets_[index]);
    settings.max_bounces = path_set.max_bounces;
    settings.seed = reference_seed;
    reference_files_[index] = ReferenceIdentity(scene, settings, path_set, registry_).hash() + ".exr";
  } catch (const Error& error) {
    // A mistake in the comparison itself ends it; a scene that cannot be used is reported and the others go on.
    if (error.error_class() != ErrorClass::input || spec_.scenes.size() == 1) throw;
    entry.failure = error.what();
    say(fmt::format("{}: {}", entry.name, entry.failure));
  }
}

std::vector<std::string> ComparisonRunner::program_command(const char* name, size_t scene, uint64_t seed) const {
  std::vector<std::string> command = {options_.program.string(), name, spec_.scenes[scene], "--json",
                                      "--seed", std::to_string(seed), "--size",
                                      fmt::format("{}x{}", spec_.width, spec_.height)};
  if (spec_.pixel_sampling != 0) {
    command.insert(command.end(), {"--pixel-sampling", spec_.pixel_sampling == 1 ? "centre" : std::to_string(spec_.pixel_sampling)});
  }
  command.insert(command.end(), spec_.scene_arguments.begin(), spec_.scene_arguments.end());
  if (needs_fallback_[scene]) command.insert(command.end(), {"--environment", spec_.fallback_environment});
  command.insert(command.end(), spec_.device_arguments.begin(), spec_.device_arguments.end());
  return command;
}

void ComparisonRunner::get_reference(size_t index) {
  SceneResult& scene = result_.scenes[index];
  ReferenceResult& reference = scene.reference;
  reference.path_set = path_sets_[index];
  reference.image = fmt::format("references/scene{}.exr", index + 1);
  const fs::path target = options_.folder / reference.image;
  try {
    if (spec_.reference) {
      const Film film = read_image(*spec_.reference);
      if (film.width() != spec_.width || film.height() != spec_.height) {
        throw_error(ErrorClass::input, "{} is {}×{}, the comparison {}×{}; give --size {}x{}", spec_.reference->string(),
                    film.width(), film.height(), spec_.width, spec_.height, film.width(), film.height());
      }
      write_exr(target, film);
      reference.source = spec_.reference->filename().string();
    } else if (!render_reference(index, target)) {
      return;
    }
    ReferenceError own;
    reference.error_known = estimate_reference_error(read_image(target), own);
    reference.mse = own.mse;
    reference.relmse = own.relmse;
    say(fmt::format("{}: reference {}{}", scene.name,
                    spec_.reference          ? reference.source
                    : reference.from_cache ? "from the cache"
                                           : fmt::format("rendered in {:.1f} s", reference.seconds),
                    own.relmse > 0 ? fmt::format(", its own relMSE {:.2g}", own.relmse) : ""));
  } catch (const Error& error) {
    if (spec_.scenes.size() == 1) throw;
    scene.failure = fmt::format("no reference: {}", error.what());
    say(fmt::format("{}: {}", scene.name, scene.failure));
  }
}

bool ComparisonRunner::render_reference(size_t index, const fs::path& target) {
  ReferenceResult& reference = result_.scenes[index].reference;
  const fs::path cached = options_.cache_dir / "references" / reference_files_[index];
  std::error_code ignored;
  fs::create_directories(cached.parent_path(), ignored);
  const FileLock lock(cached.string() + ".lock", [&] {
    say(fmt::format("{}: waiting for another run that renders the same reference", spec_.scenes[index]));
  });
  std::vector<std::string> command = program_command("reference", index, reference_seed);
  command.insert(command.end(), {"--path-set", path_sets_[index], "--extend", "--spp", std::to_string(spec_.reference_samples),
                                 "--output", cached.string()});
  // A cached file that suffices is left as it is; a smaller one, also of an interrupted run, is extended.
  const auto render = [&] { return run_child(command, [&](std::string_view line) { say("  " + std::string(line)); }); };
  const bool was_cached = fs::exists(cached);
  ChildResult child = render();
  if (was_cached && child.exit_code == static_cast<int>(ErrorClass::input)) {
    say(fmt::format("{}: the reference in the cache is not usable, rendering it again", spec_.scenes[index]));
    fs::remove(cached, ignored);
    child = render();
  }
  if (child.exit_code == static_cast<int>(ErrorClass::interrupted)) {
    set_interrupt_requested(true);
    return false;
  }
  if (child.exit_code != 0) {
    throw_error(ErrorClass::technique, "rendering it ended with {}: {}", describe_end(child),
                child.last_words.empty() ? "no message" : child.last_words.back());
  }
  const json summary = json::parse(child.out);
  reference.seconds = summary.at("seconds");
  reference.from_cache = summary.at("rounds_rendered") == 0;
  reference.source = fmt::format("path_tracing, {} samples per pixel", summary.at("samples").get<uint64_t>());
  write_file_atomically(target, [&](const fs::path& part) { fs::copy_file(cached, part); });
  return true;
}

fs::path ComparisonRunner::piece_file(const PieceResult& piece, const char* extension) const {
  return fs::path("pieces") / fmt::format("scene{}-variant{}-seed{}{}", piece.scene + 1, piece.variant + 1, piece.seed, extension);
}

bool ComparisonRunner::is_finished(size_t scene, size_t variant, uint32_t seed) const {
  return std::any_of(result_.pieces.begin(), result_.pieces.end(), [&](const PieceResult& piece) {
    return piece.scene == scene && piece.variant == variant && piece.seed == seed;
  });
}

void ComparisonRunner::load_finished_pieces() {
  if (!options_.resume) return;
  for (size_t scene = 0; scene < spec_.scenes.size(); ++scene) {
    if (!result_.scenes[scene].failure.empty()) continue;
    for (uint32_t seed = 1; seed <= spec_.seeds; ++seed) {
      for (size_t variant = 0; variant < spec_.variants.size(); ++variant) {
        PieceResult piece{scene, variant, seed};
        if (load_finished_piece(piece)) result_.pieces.push_back(std::move(piece));
      }
    }
  }
  if (!result_.pieces.empty()) say(fmt::format("{} pieces were finished before", result_.pieces.size()));
}

bool ComparisonRunner::load_finished_piece(PieceResult& piece) {
  // The summary is written after the image, so its presence means that the piece is whole. What is damaged, or was
  // rendered from another state of the scene or the program, is rendered again.
  const fs::path file = options_.folder / piece_file(piece, ".json");
  if (!fs::exists(file)) return false;
  try {
    piece.render_summary = read_file(file);
    piece.image = piece_file(piece, ".exr").string();
    const json summary = json::parse(piece.render_summary);
    if (summary.at("scene_hash") != result_.scenes[piece.scene].hash || summary.at("version") != LUCARIUM_VERSION ||
        summary.at("path_set") != path_sets_[piece.scene]) {
      say(fmt::format("{}: rendered from another scene or by another version; again", file.string()));
      return false;
    }
    measure(piece);
    return true;
  } catch (const std::exception& error) {
    say(fmt::format("{}: not usable, rendering it again: {}", file.string(), error.what()));
    return false;
  }
}

PieceResult ComparisonRunner::run_piece(size_t scene, size_t variant, uint32_t seed) {
  PieceResult piece{scene, variant, seed};
  const fs::path image = options_.folder / piece_file(piece, ".exr");
  std::vector<std::string> command = program_command("render", scene, seed);
  command.insert(command.end(), {"--overwrite", "--max-bounces", std::to_string(spec_.max_bounces), "-t", spec_.variants[variant].label(),
                                 "--output", image.string(), "--quiet"});
  if (spec_.budget.seconds > 0) {
    command.insert(command.end(), {"--iterate-time", fmt::format("{}", spec_.budget.seconds)});
  } else {
    command.insert(command.end(), {"--iterations", std::to_string(spec_.budget.iterations)});
  }
  const ChildResult child = run_child(command);
  if (child.exit_code == static_cast<int>(ErrorClass::interrupted)) set_interrupt_requested(true);
  if (child.exit_code != 0) {
    std::error_code ignored;
    fs::remove(image, ignored);
    piece.failure = fmt::format("{}: {}", describe_end(child), child.last_words.empty() ? "no message" : child.last_words.back());
    return piece;
  }
  try {
    json summary = json::parse(child.out);
    summary["peak_host_memory_bytes"] = child.peak_memory_bytes;
    piece.render_summary = summary.dump(2);
    piece.image = piece_file(piece, ".exr").string();
    measure(piece);
  } catch (const std::exception& error) {
    piece.failure = fmt::format("its result cannot be read: {}", error.what());
    return piece;
  }
  write_file_atomically(options_.folder / piece_file(piece, ".json"), piece.render_summary);
  return piece;
}

void ComparisonRunner::measure(PieceResult& piece) {
  const json summary = json::parse(piece.render_summary);
  const json& clocks = summary.at("clocks");
  piece.seconds = clocks.at("iterate_seconds");
  piece.prepare_seconds = clocks.at("upload_seconds").get<double>() + clocks.at("bvh_seconds").get<double>() +
                          clocks.at("prepare_seconds").get<double>();
  piece.compile_seconds = clocks.at("compile_seconds").get<double>() + clocks.at("warm_up_seconds").get<double>();
  piece.samples = summary.at("samples");
  piece.peak_memory_bytes = summary.at("peak_host_memory_bytes");
  result_.device = summary.at("device");
  result_.driver = summary.at("driver");
  const Film test = read_image(options_.folder / piece.image);
  const Film reference = read_image(options_.folder / result_.scenes[piece.scene].reference.image);
  const ImageMetrics metrics = compute_metrics(test.width(), test.height(), test.image(), reference.image());
  piece.rmse = metrics.rmse;
  piece.relmse = metrics.relmse;
}

void ComparisonRunner::save() {
  std::sort(result_.pieces.begin(), result_.pieces.end(), [](const PieceResult& a, const PieceResult& b) {
    return std::tie(a.scene, a.seed, a.variant) < std::tie(b.scene, b.seed, b.variant);
  });
  write_file_atomically(options_.folder / "results.json", result_.to_json());
  write_file_atomically(options_.folder / "results.csv", result_.to_csv());
  write_report(result_, options_.folder);
}

}  // namespace lucarium
