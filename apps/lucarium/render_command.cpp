// SPDX-License-Identifier: Apache-2.0
// lucarium render: one technique, one scene, one or several pictures.
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "curve_recorder.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/log.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/film/exposure.h"
#include "lucarium/film/image_io.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/session/session.h"
#include "lucarium/technique/technique_folders.h"
#include "lucarium/version.h"
#include "options.h"
#include "output_files.h"
#include "render_budget.h"
#include "watch.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr int max_frames = 100000;

struct RenderArguments {
  std::string scene;
  DeviceArguments device;
  SceneArguments overrides;
  ImageArguments image;
  RenderSettings settings;  ///< of `image`, or of a job
  TechniqueArguments technique;
  OutputArguments output;
  std::vector<fs::path> files;
  BudgetArguments budget;
  fs::path reference;
  bool curve = false;
  std::string frames;
  double frames_per_second = 24;
  bool overwrite = false, half = false, watch = false;
  std::string profile;
};

struct FrameRange {
  int first = 0, last = 0;
};

std::optional<FrameRange> parse_frames(const std::string& text) {
  if (text.empty()) return std::nullopt;
  FrameRange range;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%7d:%7d%c", &range.first, &range.last, &rest) != 2 || range.first < 0 ||
      range.last < range.first || range.last - range.first >= max_frames) {
    throw_error(ErrorClass::usage, "--frames {} is not FIRST:LAST with at most {} frames", text, max_frames);
  }
  return range;
}

/// "out.exr" → "out.0007.exr".
fs::path frame_file(const fs::path& file, int frame) {
  return file.parent_path() / fmt::format("{}.{:04}{}", file.stem().string(), frame, file.extension().string());
}

/// The files of every frame, checked; one entry without --frames.
std::vector<std::vector<fs::path>> plan_outputs(const RenderArguments& arguments,
                                                const std::optional<FrameRange>& frames) {
  for (const fs::path& file : arguments.files) {
    const std::string extension = file.extension().string();
    if (extension != ".exr" && extension != ".png") {
      throw_error(ErrorClass::usage, "{}: the name must end in .exr or .png", file.string());
    }
  }
  std::vector<std::vector<fs::path>> outputs;
  for (int frame = frames ? frames->first : 0; frame <= (frames ? frames->last : 0); ++frame) {
    outputs.push_back(arguments.files);
    for (fs::path& file : outputs.back()) {
      if (frames) file = frame_file(file, frame);
      check_output(file, arguments.overwrite);
    }
  }
  if (!arguments.profile.empty() && arguments.profile != "-") check_output(arguments.profile, arguments.overwrite);
  return outputs;
}

void write_outputs(const std::vector<fs::path>& files, const Film& film, float exposure, bool half) {
  for (const fs::path& file : files) {
    if (file.extension() == ".png") {
      write_png(file, film, exposure);
    } else {
      write_exr(file, film, {half});
    }
  }
}

/// What the technique counts (rays, paths, …) and pixel samples, per second of iterating.
std::string rates(RenderSession& session) {
  const double seconds = session.clocks().iterate;
  const RenderSettings& settings = session.settings();
  const double samples = static_cast<double>(session.last().samples) * settings.width * settings.height;
  std::string text = fmt::format("{:.3f} Msamples/s", samples / 1e6 / seconds);
  for (const auto& [name, value] : session.technique().counters()) {
    if (value > 0) text += fmt::format(", {} {:.3f} M/s", name, value / 1e6 / seconds);
  }
  return text + "\n";
}

void write_profile(const RenderArguments& arguments, RenderSession& session) {
  if (arguments.profile.empty()) return;
  session.scheduler().finish();
  const Profile& profile = session.scheduler().profile();
  if (arguments.profile == "-") {
    print_note("{}{}", profile.table(), rates(session));
  } else if (arguments.profile.ends_with(".trace.json")) {
    write_file_atomically(arguments.profile, profile.chrome_trace());
  } else {
    write_file_atomically(arguments.profile, profile.json());
  }
}

/// Where the time went, longest first.
ordered_json passes_json(RenderSession& session) {
  session.scheduler().finish();
  std::vector<PassProfile> passes = session.scheduler().profile().passes;
  std::stable_sort(passes.begin(), passes.end(),
                   [](const PassProfile& a, const PassProfile& b) { return a.device_seconds > b.device_seconds; });
  ordered_json json = ordered_json::array();
  for (const PassProfile& pass : passes) {
    if (pass.count == 0) continue;
    json.push_back({{"schedule", pass.schedule},
                    {"name", pass.name},
                    {"device_seconds", pass.device_seconds},
                    {"count", pass.count}});
  }
  return json;
}

/// What was planned for a budget of time, or null.
ordered_json plan_json(const BudgetPlan& plan) {
  if (plan.budget_seconds <= 0) return nullptr;
  ordered_json json = {{"budget_seconds", plan.budget_seconds},
                       {"default_seconds", plan.default_seconds},
                       {"expected_seconds", plan.expected_seconds},
                       {"sufficient_seconds", plan.sufficient_seconds},
                       {"changes", ordered_json::array()}};
  for (const BudgetPlan::Change& change : plan.changes)
    json["changes"].push_back({{"parameter", change.parameter}, {"from", change.from}, {"to", change.to}});
  return json;
}

ordered_json summary_json(RenderSession& session, const Film& film, const RenderEnd& end, double load_seconds,
                          double total_seconds, float exposure, const std::vector<fs::path>& files) {
  const MemoryAccount& memory = session.scheduler().device().memory();
  const RenderSession::Clocks& clocks = session.clocks();
  ordered_json json;
  json["schema"] = "lucarium-render-1";
  for (const auto& [key, value] : film.metadata) json[key] = value;
  json["width"] = film.width();
  json["height"] = film.height();
  json["samples"] = session.last().samples;
  json["iterations"] = session.iterations();
  json["seed"] = session.settings().seed;
  json["max_bounces"] = session.settings().max_bounces;
  json["pixel_sampling"] = session.settings().pixel_sampling;
  json["scene_time_seconds"] = session.scene().time;
  json["exposure_stops"] = exposure;
  json["exposure_automatic"] = is_automatic(session.scene().exposure);
  json["partial"] = film.metadata.count("partial") > 0;
  json["converged"] = session.last().converged;
  json["progress"] = session.last().progress < 0 ? ordered_json(nullptr) : ordered_json(session.last().progress);
  json["ended_by"] = end.by;
  json["seconds_left"] = end.seconds_left ? ordered_json(*end.seconds_left) : ordered_json(nullptr);
  json["seconds"] = total_seconds;
  json["clocks"] = {{"load_seconds", load_seconds},      {"upload_seconds", clocks.upload},
                    {"bvh_seconds", clocks.bvh},         {"compile_seconds", clocks.compile},
                    {"prepare_seconds", clocks.prepare}, {"warm_up_seconds", clocks.warm_up},
                    {"iterate_seconds", clocks.iterate}};
  json["device_memory_bytes"] = memory.by_owner();
  json["peak_device_memory_bytes"] = memory.peak_bytes();
  json["passes"] = passes_json(session);
  json["plan"] = plan_json(session.plan());
  json["counters"] = session.technique().counters();
  json["limitations"] = session.limitations();
  json["warnings"] = session.scene().warnings;
  json["files"] = ordered_json::array();
  for (const fs::path& file : files) json["files"].push_back(file.string());
  return json;
}

/// "; exposure -3.2 stops (auto)" where a picture was written at an exposure that nobody stated.
std::string chosen_exposure(const RenderSession& session, float exposure, const std::vector<fs::path>& files) {
  const auto is_picture = [](const fs::path& file) { return file.extension() == ".png"; };
  if (!is_automatic(session.scene().exposure) || std::none_of(files.begin(), files.end(), is_picture)) return "";
  return fmt::format("; exposure {:g} stops (auto)", exposure);
}

/// Renders and writes every frame (one without --frames); returns whether it was interrupted.
bool render_frames(const RenderArguments& arguments, RenderSession& session,
                   const std::vector<std::vector<fs::path>>& outputs, const std::optional<FrameRange>& frames,
                   CurveRecorder* curve, double load_seconds, std::chrono::steady_clock::time_point start,
                   ordered_json& summaries) {
  float exposure = curve ? curve->exposure() : session.scene().exposure;
  const auto relmse = [curve](RenderSession& now) { return curve ? curve->sample(now) : std::nullopt; };
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (i > 0) start = std::chrono::steady_clock::now();
    try {
      if (frames) session.set_time((frames->first + static_cast<int>(i)) / arguments.frames_per_second);
    } catch (const Error& error) {
      if (i == 0 || error.error_class() != ErrorClass::interrupted) throw;
      return true;  // frames that are done are reported
    }
    const RenderEnd end = render_within_budget(arguments.budget, session, arguments.output.quiet, relmse, start);
    if (end.interrupted && session.last().samples == 0 && !session.last().visible) return true;
    Film film = session.resolve();
    const bool first_unfinished = session.last().samples == 0 && session.last().visible;
    if (first_unfinished && !end.interrupted)
      log_warning("the budget ended within the first sample per pixel{}: a coarse picture, or one without all light",
                  session.last().phase.empty() ? "" : fmt::format(", in the stage '{}'", session.last().phase));
    const bool not_begun = session.last().progress == 0 && !session.last().phase.empty() && !session.last().converged;
    if (not_begun && !end.interrupted && !first_unfinished)
      log_warning("the budget ended in the stage '{}', before {} had begun its work proper: light is missing",
                  session.last().phase, arguments.technique.specs.front().name);
    if (end.interrupted || first_unfinished || not_begun) film.metadata["partial"] = "yes";
    // One exposure for all frames: the first picture decides, else they would flicker.
    if (is_automatic(exposure)) exposure = automatic_exposure(film.image());
    write_outputs(outputs[i], film, exposure, arguments.half);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summaries.push_back(summary_json(session, film, end, i == 0 ? load_seconds : 0, seconds, exposure, outputs[i]));
    if (!arguments.output.quiet && !arguments.output.json) {
      print_result("{}: {} samples per pixel, {:.1f} s{}{}\n", outputs[i].front().string(), session.last().samples,
                   seconds, chosen_exposure(session, exposure, outputs[i]),
                   session.last().converged
                       ? fmt::format("; ended by {}: {}", arguments.technique.specs.front().name, end.by)
                       : "");
    }
    if (curve) {
      curve->finish(session, film.image());
      summaries.back().update(curve->to_json());
    }
    if (end.interrupted) return true;
  }
  return false;
}

/// Loads the scene, requires a light, logs warnings.
Scene load(const RenderArguments& arguments) {
  Scene scene = arguments.overrides.load(arguments.scene);
  require_light(scene);
  for (const std::string& warning : scene.warnings) log_warning("{}", warning);
  return scene;
}

/// The curve that --reference asks for, or none.
std::unique_ptr<CurveRecorder> make_curve(const RenderArguments& arguments, const RenderSettings& settings,
                                          float exposure) {
  if (arguments.reference.empty()) {
    if (arguments.curve || arguments.budget.relmse > 0) {
      throw_error(ErrorClass::usage, "{} needs --reference FILE", arguments.curve ? "--curve" : "--until-relmse");
    }
    return nullptr;
  }
  if (!arguments.frames.empty()) throw_error(ErrorClass::usage, "give --frames or --reference, not both");
  CurveSchedule schedule{false, INFINITY, INFINITY};  // the end alone
  if (arguments.budget.relmse > 0) {
    schedule = CurveSchedule::open_ended();
  } else if (arguments.curve && arguments.budget.compute_seconds > 0) {
    schedule = CurveSchedule::up_to_seconds(arguments.budget.compute_seconds);
  } else if (arguments.curve && arguments.budget.iterations > 0) {
    schedule = CurveSchedule::up_to_iterations(arguments.budget.iterations);
  } else if (arguments.curve) {
    schedule = CurveSchedule::open_ended();
  }
  return std::make_unique<CurveRecorder>(arguments.reference, settings, exposure, schedule);
}

WatchedInputs watched_inputs(const RenderArguments& arguments) {
  return {scene_files(arguments.scene, arguments.overrides.overrides.environment.value_or("")),
          technique_folders(arguments.technique.folders), kernel_path_roots()};
}

int render_picture(RenderArguments arguments) {
  const auto start = std::chrono::steady_clock::now();
  arguments.output.apply();
  if (arguments.files.empty() && !arguments.output.json) {
    throw_error(ErrorClass::usage, "where to? add --output FILE.exr or FILE.png");
  }
  if (arguments.technique.specs.empty()) arguments.technique.specs.push_back({"path_tracing", {}});
  if (arguments.technique.specs.size() > 1)
    throw_error(ErrorClass::usage, "render takes one -t; to compare several use lucarium compare");
  const std::optional<FrameRange> frames = parse_frames(arguments.frames);
  if (frames && arguments.overrides.overrides.at_seconds)
    throw_error(ErrorClass::usage, "give --at or --frames, not both");
  const std::vector<std::vector<fs::path>> outputs = plan_outputs(arguments, frames);
  if (arguments.watch) return render_and_watch(watched_inputs(arguments));
  RenderSettings settings = arguments.settings;
  const TechniqueRegistry registry(arguments.technique.folders);
  const TechniqueArguments::Spec& spec = arguments.technique.specs.front();
  const TechniqueType& type = registry.find(spec.name);
  check_parameters(type, spec);

  const auto load_start = std::chrono::steady_clock::now();
  Scene scene = load(arguments);
  const double load_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - load_start).count();
  if (frames && scene.animations.empty()) log_warning("{} has no animation: all frames show the same", arguments.scene);
  settings.camera = scene.cameras.front();
  const std::unique_ptr<CurveRecorder> curve = make_curve(arguments, settings, scene.exposure);
  const std::shared_ptr<Device> device = Device::open(arguments.device.resolved());
  auto preparing = std::make_unique<Progress>(
      "preparing", arguments.output.quiet ? Progress::Style::quiet : Progress::Style::automatic);
  RenderSession session(
      device, std::move(scene), type, settings, spec.parameters,
      [&preparing](double fraction, const std::string& stage) {
        if (preparing) preparing->update(fraction, stage);
      },
      planned_seconds(arguments.budget));
  preparing.reset();
  const KeepOnInterrupt keep_pictures;
  tell_plan(arguments.budget, session.plan(), spec.name);
  for (const std::string& limitation : session.limitations()) log_warning("{}: {}", spec.name, limitation);

  ordered_json summaries = ordered_json::array();
  const bool interrupted =
      render_frames(arguments, session, outputs, frames, curve.get(), load_seconds, start, summaries);
  if (summaries.empty()) {
    throw_error(ErrorClass::interrupted, "interrupted before the first iteration was done; nothing was written");
  }
  write_profile(arguments, session);
  if (arguments.output.json) print_result("{}\n", (frames ? summaries : summaries.front()).dump(2));
  if (!interrupted) return 0;
  log_warning("interrupted: {} ({} samples per pixel)",
              arguments.files.empty() ? "no file was asked for" : "the partial result is kept", session.last().samples);
  return static_cast<int>(ErrorClass::interrupted);
}

}  // namespace

int render(const Job& job, const RenderWork& work) {
  RenderArguments arguments;
  arguments.scene = job.scene;
  arguments.device.take(job.device);
  arguments.overrides.take(job);
  arguments.settings = settings_of(job);
  arguments.technique.specs = {{work.technique, work.parameters}};
  arguments.technique.folders = job.technique_folders;
  arguments.output.json = arguments.output.quiet = true;
  if (!work.output.empty()) arguments.files = {work.output};
  arguments.overwrite = true;
  arguments.budget.compute_seconds = work.compute_seconds;
  arguments.budget.iterations = work.iterations;
  arguments.budget.relmse = work.relmse;
  arguments.reference = work.reference;
  arguments.curve = work.curve;
  return render_picture(std::move(arguments));
}

void add_render_command(Command program, Action& action) {
  auto arguments = std::make_shared<RenderArguments>();
  Command command = program.add_subcommand("render", "render a scene with one technique");
  command.add_option("scene", arguments->scene, ".gltf, .glb or builtin:NAME")->required();
  arguments->technique.add_to(command);
  command.add_option("-o,--output", arguments->files, ".exr (layers, metadata) or .png (picture); may be given twice")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command
      .add_option("--spp", arguments->budget.samples, "samples per pixel (default 64 when no other budget is given)")
      ->check(whole_number(1));
  command.add_option("--iterations", arguments->budget.iterations, "iterations of the technique")
      ->check(whole_number(1));
  command
      .add_option("--time", arguments->budget.seconds,
                  "seconds from the start of the program: loading, kernels and preparing count; of a later frame, from "
                  "the one before; parameters that are not given are lowered where that is too short")
      ->check(positive_number());
  command
      .add_option("--compute-time", arguments->budget.compute_seconds,
                  "seconds of preparing and iterating, without loading and compiling; lowers parameters too")
      ->check(positive_number());
  command.add_option("--reference", arguments->reference, "image to measure the error against; for --json");
  command.add_flag("--curve", arguments->curve, "with --reference: the error also at times t*2^(i/2)");
  command
      .add_option("--until-relmse", arguments->budget.relmse, "with --reference: stop when the error is at most this")
      ->check(positive_number());
  arguments->image.add_to(command, true);
  arguments->overrides.add_to(command);
  command.add_option("--frames", arguments->frames,
                     "FIRST:LAST of the animation; out.exr becomes out.0000.exr and so on, by the frame's number");
  command.add_option("--fps", arguments->frames_per_second, "frames per second of --frames")
      ->check(positive_number())
      ->capture_default_str();
  command.add_flag("--half", arguments->half, "16-bit floats in EXR");
  command.add_flag("--overwrite", arguments->overwrite, "replace existing files");
  command.add_flag("--watch", arguments->watch,
                   "render again whenever scene, plug-in or a kernel in LUCARIUM_KERNEL_PATH changes");
  command.add_flag("--profile{-}", arguments->profile,
                   "time per pass: a table, or --profile=FILE.json, FILE.trace.json (Perfetto)");
  arguments->device.add_to(command);
  arguments->output.add_to(command);
  command.callback([arguments, &action] {
    action = [arguments] {
      arguments->settings = arguments->image.settings();
      return render_picture(*arguments);
    };
  });
}

}  // namespace lucarium::app
