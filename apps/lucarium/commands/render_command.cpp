// SPDX-License-Identifier: Apache-2.0
// lucarium render: one technique, one scene, one or several pictures. Declared in commands.h.
#include <cmath>
#include <memory>

#include "budgets/curve_recorder.h"
#include "budgets/render_budget.h"
#include "commands/commands.h"
#include "commands/watch.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/film/exposure.h"
#include "lucarium/scene/animation.h"
#include "lucarium/scene/camera_path.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/session/session.h"
#include "lucarium/technique/technique_folders.h"
#include "options/options.h"
#include "options/state_arguments.h"
#include "outputs/output_files.h"
#include "outputs/render_output.h"
#include "outputs/render_summary.h"
#include "outputs/walk_summary.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct RenderArguments : RenderingArguments {
  std::vector<fs::path> files;
  BudgetArguments budget;
  fs::path reference;
  bool curve = false;
  std::string frames;
  double frames_per_second = 24;
  StateArguments state;
  Walk walk;  ///< of a job
  bool overwrite = false, half = false, watch = false;
  std::string profile;
};

/// "; exposure -3.2 stops (auto)" where a picture was written at an exposure that nobody stated.
std::string chosen_exposure(const RenderSession& session, float exposure, const std::vector<fs::path>& files) {
  if (!is_automatic(session.scene().exposure) || !any_of_kind(files, ".png")) return "";
  return fmt::format("; exposure {:g} stops (auto)", exposure);
}

std::string names_of(const std::vector<fs::path>& files) {
  std::string names;
  for (const fs::path& file : files) names += (names.empty() ? "" : ", ") + file.string();
  return names;
}

/// Whether what does not depend on the camera is finished before the first frame: it is the same for all frames, so
/// that each has the bits that it would have had alone.
bool is_walk(const std::optional<FrameRange>& frames, const RenderSession& session) {
  return frames && moves_only_cameras(session.scene());
}

/// Finishes the light and saves it.
void save_state(const RenderArguments& arguments, const Messages& messages, RenderSession& session) {
  if (finish_light(session, messages.quiet))
    throw_error(ErrorClass::interrupted, "interrupted before the light was finished; no state was written");
  session.save_state(arguments.state.save_file, arguments.state.compress);
  if (!messages.json)
    print_result("{}: state, {}\n", arguments.state.save_file.string(),
                 format_bytes(fs::file_size(arguments.state.save_file)));
}

/// Renders and writes every frame (one without --frames); returns whether it was interrupted.
bool render_frames(const RenderArguments& arguments, const Messages& messages, RenderSession& session,
                   const std::vector<std::vector<fs::path>>& outputs, const std::optional<FrameRange>& frames,
                   CurveRecorder* curve, double load_seconds, Stopwatch since_start, ordered_json& summaries) {
  float exposure = curve ? curve->exposure() : session.scene().exposure;
  const auto relmse = [curve](RenderSession& now) { return curve ? curve->sample(now) : std::nullopt; };
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (i > 0) since_start.restart();
    try {
      if (frames) session.set_time((frames->first + static_cast<int>(i)) / arguments.frames_per_second);
    } catch (const Error& error) {
      if (i == 0 || error.error_class() != ErrorClass::interrupted) throw;
      return true;  // frames that are done are reported
    }
    if (is_walk(frames, session) && finish_light(session, messages.quiet)) return true;
    if (i == 0 && !arguments.state.save_file.empty()) save_state(arguments, messages, session);
    const RenderEnd end = render_within_budget(arguments.budget, session, messages.quiet, relmse, since_start);
    if (end.interrupted && session.last().samples == 0 && !session.last().visible) return true;
    Film film = session.resolve();
    const std::string technique = film.metadata.at("technique");
    const bool first_unfinished = session.last().samples == 0 && session.last().visible;
    if (first_unfinished && !end.interrupted)
      log_warning("the budget ended within the first sample per pixel{}: a coarse picture, or one without all light",
                  session.last().phase.empty() ? "" : fmt::format(", in the stage '{}'", session.last().phase));
    const bool not_begun = session.last().progress == 0 && !session.last().phase.empty() && !session.last().converged;
    if (not_begun && !end.interrupted && !first_unfinished)
      log_warning("the budget ended in the stage '{}', before {} began to render: light is missing",
                  session.last().phase, technique);
    if (end.interrupted || first_unfinished || not_begun) film.metadata["partial"] = "yes";
    // One exposure for all frames: the first picture decides, else they would flicker.
    if (is_automatic(exposure)) exposure = automatic_exposure(film.image());
    write_outputs(outputs[i], film, exposure, arguments.half);
    const double seconds = since_start.seconds();
    summaries.push_back(frame_json(session, film, end, i == 0 ? load_seconds : 0, seconds, exposure, outputs[i]));
    if (curve) {
      curve->finish(session, film.image());
      summaries.back().update(curve->to_json());
    }
    if (!messages.json) {
      print_result(
          "{}: {} per pixel, {:.1f} s{}{}{}\n", names_of(outputs[i]), counted(session.last().samples, "sample"),
          seconds, chosen_exposure(session, exposure, outputs[i]),
          session.last().converged ? fmt::format("; ended by {}: {}", technique, end.by) : "",
          curve ? fmt::format("; relMSE {:.4g} against {}", curve->relmse(), arguments.reference.string()) : "");
    }
    if (arguments.walk.frames > 0 && !end.interrupted) summaries.back()["walk"] = walk_json(session, arguments.walk);
    if (end.interrupted) return true;
  }
  return false;
}

CurveSchedule curve_schedule(const RenderArguments& arguments) {
  using Work = CurveSchedule::Work;
  const BudgetArguments& budget = arguments.budget;
  if (budget.relmse > 0) return CurveSchedule::open_ended();
  if (!arguments.curve) return CurveSchedule::at_the_end();
  if (budget.seconds > 0) return CurveSchedule::up_to_seconds(budget.seconds);
  if (budget.iterations > 0) return CurveSchedule::up_to_count(Work::iterations, budget.iterations);
  if (budget.samples > 0) return CurveSchedule::up_to_count(Work::samples, budget.samples);
  return CurveSchedule::open_ended();
}

WatchedInputs watched_inputs(const RenderArguments& arguments) {
  return {scene_files(arguments.scene, arguments.overrides.overrides.environment.value_or("")),
          technique_folders(arguments.technique.folders), kernel_path_roots()};
}

bool has_profile_file(const RenderArguments& arguments) {
  return !arguments.profile.empty() && arguments.profile != "-";
}

/// What no rule about pairs of options finds: options that do nothing for the files that are asked for.
void check_outputs(const RenderArguments& arguments, const Messages& messages) {
  const bool saves_state = !arguments.state.save_file.empty();
  if (arguments.files.empty() && !messages.json && !saves_state)
    throw_error(ErrorClass::usage, "no output file given; add --output FILE.exr or FILE.png");
  if (arguments.overwrite && arguments.files.empty() && !has_profile_file(arguments) && !saves_state)
    throw_error(ErrorClass::usage, "--overwrite does nothing without --output, --save-state or --profile=FILE");
  if (arguments.half && !any_of_kind(arguments.files, ".exr"))
    throw_error(ErrorClass::usage, "--half does nothing without an --output FILE.exr");
  if (arguments.overrides.overrides.exposure && !any_of_kind(arguments.files, ".png") && !messages.json)
    throw_error(ErrorClass::usage, "--exposure does nothing without an --output FILE.png");
  if (has_profile_file(arguments) && !arguments.profile.ends_with(".json"))
    throw_error(ErrorClass::usage, "--profile={}: the name must end in .json", arguments.profile);
  std::vector<fs::path> outputs = arguments.files;  // a profile's name ends in .json, that of a picture does not
  if (saves_state) outputs.push_back(arguments.state.save_file);
  check_distinct(outputs);
}

int render_picture(const RenderArguments& arguments, const Messages& messages) {
  const Stopwatch since_start;
  check_outputs(arguments, messages);
  std::unique_ptr<StateFile> state = arguments.state.open();
  const std::optional<FrameRange> frames = parse_frames(arguments.frames);
  const std::vector<std::vector<fs::path>> outputs = plan_outputs(arguments.files, frames, arguments.overwrite);
  if (has_profile_file(arguments)) check_output(arguments.profile, arguments.overwrite);
  if (!arguments.state.save_file.empty()) check_output(arguments.state.save_file, arguments.overwrite);
  if (arguments.watch) {
    state.reset();
    return render_and_watch(watched_inputs(arguments), !arguments.files.empty() || !arguments.profile.empty());
  }
  UsedInputs used;
  const TechniqueRegistry registry(arguments.technique.folders);
  const TechniqueArguments::Spec spec = state ? spec_of_state(arguments.technique, registry, *state)
                                              : arguments.technique.single("render", "path_tracing");
  const TechniqueType& type = registry.find(spec.name);
  used.set_plugin(type.file(), registry.searched());
  const std::unique_ptr<Technique> technique = make_technique(type, spec);
  if (arguments.state.any()) check_state(type, spec);

  const Stopwatch loading;
  Scene scene = arguments.load(technique.get());
  const double load_seconds = loading.seconds();
  if (frames && scene.animations.empty() && !scene.camera_path)
    log_warning("{} has no animation: all frames show the same", arguments.scene);
  // A path that has no view at one of the frames is refused before the first is rendered.
  if (frames && scene.camera_path)
    for (int frame = frames->first; frame <= frames->last; ++frame)
      camera_on_path(*scene.camera_path, frame / arguments.frames_per_second);
  RenderSettings settings = arguments.settings;
  settings.camera = scene.cameras.front();
  if (state) arguments.state.apply_to(settings, *state);
  std::unique_ptr<CurveRecorder> curve;
  if (!arguments.reference.empty())
    curve = std::make_unique<CurveRecorder>(arguments.reference, settings, scene.exposure, curve_schedule(arguments));
  const std::shared_ptr<Device> device = Device::open(arguments.device.resolved());
  TimeBudget time = planned_time(arguments.budget);
  // Light that is finished before the first frame, or saved, must have an end.
  if (!arguments.state.save_file.empty() || (frames && moves_only_cameras(scene))) time.to_the_end = false;
  auto preparing =
      std::make_unique<Progress>("preparing", messages.quiet ? Progress::Style::quiet : Progress::Style::automatic);
  RenderSession session(
      device, std::move(scene), type, settings, spec.parameters,
      [&preparing](double fraction, const std::string& stage) {
        if (preparing) preparing->update(fraction, stage);
      },
      state ? TimeBudget() : time, state.get());
  state.reset();
  preparing.reset();
  const KeepOnInterrupt keep_pictures;
  tell_plan(arguments.budget, session.plan(), spec.name);
  for (const std::string& limitation : session.limitations()) log_warning("{}: {}", spec.name, limitation);

  if (arguments.files.empty() && !messages.json) {
    save_state(arguments, messages, session);
    write_profile(arguments.profile, session, messages.json);
    return 0;
  }
  ordered_json summaries = ordered_json::array();
  const bool interrupted =
      render_frames(arguments, messages, session, outputs, frames, curve.get(), load_seconds, since_start, summaries);
  if (summaries.empty()) {
    throw_error(ErrorClass::interrupted, "interrupted before the first iteration was done; nothing was written");
  }
  write_profile(arguments.profile, session, messages.json);
  if (messages.json) print_result("{}\n", summary_json(summaries).dump(2));
  if (!interrupted) return 0;
  log_warning("interrupted: {} ({} per pixel)",
              arguments.files.empty() ? "no file was asked for" : "the partial result is kept",
              counted(session.last().samples, "sample"));
  return static_cast<int>(ErrorClass::interrupted);
}

}  // namespace

int render(const Job& job, const RenderWork& work) {
  RenderArguments arguments;
  arguments.take(job);
  arguments.technique.specs = {{work.technique, work.parameters}};
  if (!work.output.empty()) arguments.files = {work.output};
  arguments.overwrite = !work.output.empty();
  arguments.budget.seconds = work.seconds;
  arguments.budget.iterations = work.iterations;
  arguments.budget.samples = work.samples;
  arguments.budget.relmse = work.relmse;
  arguments.budget.work_iterations = work.work_iterations;
  arguments.reference = work.reference;
  arguments.curve = work.curve;
  arguments.walk = work.walk;
  Messages messages;
  messages.json = messages.quiet = true;
  messages.apply();
  if (job.verbose) set_log_level(LogLevel::info);
  return render_picture(arguments, messages);
}

void add_render_command(Command program, Action& action) {
  auto arguments = std::make_shared<RenderArguments>();
  Command command = program.add_subcommand("render", "render a scene with one technique");
  command.option("scene", arguments->scene).required();
  command.option("--output", arguments->files)
      .repeatable()
      .value_name("FILE.exr|.png")
      .default_text("none; needed without --json");
  command.flag("--overwrite", arguments->overwrite);
  command.flag("--half", arguments->half);
  command.flag("--profile", arguments->profile);
  command.flag("--watch", arguments->watch);
  BudgetArguments& budget = arguments->budget;
  command.option("--spp", budget.samples).check(whole_number(1)).default_text("64 without another budget");
  command.option("--iterations", budget.iterations).check(whole_number(1)).default_text("no limit");
  command.option("--time", budget.seconds).check(positive_number()).default_text("no limit");
  command.option("--wall-time", budget.wall_seconds).check(positive_number()).default_text("no limit");
  command.option("--relmse", budget.relmse).check(positive_number()).default_text("no limit");
  command.option("--reference", arguments->reference).default_text("none");
  command.flag("--curve", arguments->curve);
  arguments->image.add_to(command, true);
  arguments->overrides.add_exposure_to(command);
  arguments->overrides.add_to(command);
  command.option("--frames", arguments->frames).default_text("one, at --at");
  command.option("--fps", arguments->frames_per_second).check(positive_number()).capture_default_str();
  arguments->technique.add_to(command, "path_tracing");
  arguments->state.add_to(command);
  arguments->device.add_to(command);
  command.needs({"--fps"}, {"--frames"});
  command.needs({"--relmse", "--curve"}, {"--reference"});
  command.needs({"--curve"}, {"--json"});
  command.excludes({"--frames"}, {"--at", "--reference"});
  command.examples({"lucarium render builtin:cornell -o cornell.png",
                    "lucarium render builtin:cornell -t bundle_exchange --time 10 -o cornell.exr -o cornell.png"},
                   "docs/rendering.md");
  command.callback([arguments, command, &action] {
    arguments->state.has_seed = command.given("--seed");
    arguments->state.has_bounces = command.given("--max-bounces");
    action = [arguments](const Messages& messages) {
      arguments->settings = arguments->image.settings();
      return render_picture(*arguments, messages);
    };
  });
}

}  // namespace lucarium::app
