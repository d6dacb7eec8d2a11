// SPDX-License-Identifier: Apache-2.0
// lucarium reference: a reference image rendered to a wanted error, and extended later. Declared in commands.h.
#include <memory>
#include <set>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/file_lock.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/reference/reference_identity.h"
#include "lucarium/compare/reference/reference_render.h"
#include "lucarium/compare/run/shared_reference.h"
#include "lucarium/film/image_io.h"
#include "options/executor_arguments.h"
#include "options/options.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

constexpr uint64_t default_samples = 4096;

struct ReferenceArguments : RenderingArguments {
  ReferenceGoal goal;
  ExecutorArguments executor;
  std::string path_set;
  fs::path file;
  bool extend = false, overwrite = false;
};

/// A reference takes from a technique its light paths alone: what path_tracing would do otherwise is a mistake here.
void check_only_light_paths(const TechniqueArguments::Spec& spec, const PathSet& set) {
  if (spec.name != "path_tracing") return;
  std::vector<std::string> names;
  for (const auto& [name, value] : set.technique_parameters()) names.push_back(name);
  for (const auto& [name, value] : spec.parameters) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw_error(ErrorClass::usage,
                  "{}={} does nothing here: a reference takes parameters that choose light paths ({})", name, value,
                  fmt::join(names, ", "));
  }
}

/// The light paths asked for: those of a text, of a technique, or all up to --max-bounces.
PathSet wanted_path_set(const ReferenceArguments& arguments, const TechniqueRegistry& registry, const Scene& scene,
                        const RenderSettings& settings) {
  if (!arguments.path_set.empty()) return PathSet::parse(arguments.path_set);
  const TechniqueArguments& given = arguments.technique;
  if (given.specs.empty() && given.leading.empty()) {
    PathSet set;
    set.max_bounces = settings.max_bounces;
    return set;
  }
  const TechniqueArguments::Spec spec = given.single("reference", "path_tracing");
  const TechniqueType& type = registry.find(spec.name);
  const PathSet set = make_technique(type, spec)->path_set(scene, settings);
  check_only_light_paths(spec, set);
  return set;
}

/// What there is of the file, or an empty image.
ReferenceImage open_reference(const ReferenceArguments& arguments, const ReferenceIdentity& identity, uint32_t width,
                              uint32_t height) {
  if (!arguments.extend || !fs::exists(arguments.file)) return {width, height};
  Film film = read_image(arguments.file);
  const std::vector<std::string> differences = identity.differences(film);
  ReferenceImage image(std::move(film), arguments.file.string());
  if (differences.empty()) return image;
  std::string text;
  for (const std::string& line : differences) text += (text.empty() ? "" : "; ") + line;
  throw_error(ErrorClass::usage, "{} cannot be extended, it shows something else ({}); choose another --output",
              arguments.file.string(), text);
}

/// Numbers of the header are numbers in JSON, too; all else stays text, also a version that looks like a number.
nlohmann::ordered_json header_value(const std::string& key, const std::string& text) {
  static const std::set<std::string> numbers = {
      "seed",           "max_bounces",           "scene_time_seconds", "pixel_sampling", "half_a_samples",
      "half_b_samples", "round_samples_squared", "round_variance_dof", "variance_dof",   "own_mse",
      "own_relmse"};
  if (!numbers.contains(key)) return text;
  const nlohmann::ordered_json value = nlohmann::ordered_json::parse(text, nullptr, false);
  return value.is_number() ? value : nlohmann::ordered_json(text);
}

nlohmann::ordered_json reference_json(ReferenceImage& image, uint64_t rounds_before, const fs::path& file,
                                      bool goal_reached) {
  nlohmann::ordered_json json;
  json["schema"] = "lucarium-reference-1";
  for (const auto& [key, value] : image.film().metadata) json[key] = header_value(key, value);
  json["samples"] = image.samples();
  json["rounds"] = image.rounds();
  json["rounds_rendered"] = image.rounds() - rounds_before;
  json["seconds"] = std::stod(image.metadata().at("seconds"));
  if (image.error_known()) {
    json["own_mse"] = image.error().mse;
    json["own_relmse"] = image.error().relmse;
    json["halves_agree"] = image.test_halves().passed;
  }
  json["goal_reached"] = goal_reached;
  json["file"] = file.string();
  return json;
}

/// Grows the image and writes the file after every round.
class Growth {
 public:
  Growth(const ReferenceArguments& arguments, bool quiet, const RenderSettings& settings,
         const ReferenceIdentity& identity, ReferenceImage& image)
      : arguments_(arguments),
        settings_(settings),
        identity_(identity),
        image_(image),
        progress_("reference", quiet ? Progress::Style::quiet : Progress::Style::automatic),
        quiet_(quiet),
        samples_before_(image.samples()) {
    const auto earlier = image.metadata().find("seconds");
    if (earlier != image.metadata().end()) seconds_before_ = std::stod(earlier->second);
  }

  /// Both return whether the goal was reached.
  bool run(RenderSession& session) {
    const double clock_before = session.clocks().iterate;
    return extend_reference(
        session, image_, arguments_.goal, settings_.seed,
        [&](ReferenceImage& grown) {
          keep(grown, session.resolve().metadata, session.clocks().iterate - clock_before);
        },
        [&](const ReferenceProgress& now) { show(now); });
  }
  bool run_shared(const Job& job, const ExecutorOptions& options) {
    const fs::path program = fs::read_symlink("/proc/self/exe");
    SharedReferenceEvents events;
    events.keep = [&](ReferenceImage& grown, const Film& round, double seconds) {
      keep(grown, round.metadata, seconds);
    };
    events.progress = [&](const ReferenceProgress& now) { show(now); };
    events.say = [&](const std::string& line) {
      if (!quiet_) print_note("{}\n", line);
    };
    const fs::path rounds = fs::absolute(arguments_.file).string() + ".rounds";
    const fs::path folder = rounds / identity_.hash();  // rounds of another scene are never taken for these
    bool done = false;
    {
      const FolderLock lock(rounds);
      done = extend_shared_reference(*make_executor(options, program, folder / "slurm"), job, image_, arguments_.goal,
                                     folder, events);
    }
    std::error_code ignored;
    if (done) fs::remove(rounds, ignored);  // an earlier start may have made it; with something in it it stays
    return done;
  }

 private:
  void keep(ReferenceImage& grown, std::map<std::string, std::string> metadata, double seconds) {
    metadata.erase("iterations");
    metadata["seconds"] = fmt::format("{:.3f}", seconds_before_ + seconds);
    grown.metadata() = std::move(metadata);
    identity_.write_to(grown.metadata());
    write_exr(arguments_.file, grown.film());
  }

  void show(const ReferenceProgress& now) {
    const double pixels = static_cast<double>(settings_.width) * settings_.height;
    const double rate = static_cast<double>(now.samples - samples_before_) * pixels / 1e6 / std::max(1e-9, now.seconds);
    progress_.update(now.fraction,
                     fmt::format("{} per pixel, {:.2f} Msamples/s", counted(now.samples, "sample"), rate));
  }

  const ReferenceArguments& arguments_;
  const RenderSettings& settings_;
  const ReferenceIdentity& identity_;
  ReferenceImage& image_;
  Progress progress_;
  bool quiet_;
  uint64_t samples_before_;
  double seconds_before_ = 0;
};

/// Scene, image and device of the rounds that others render.
Job job_of(const ReferenceArguments& arguments, const RenderSettings& settings, const PathSet& path_set) {
  Job job;
  job.scene = arguments.scene;
  if (!job.scene.starts_with("builtin:")) job.scene = fs::absolute(job.scene).string();
  job.overrides = arguments.overrides.resolved();
  job.import = arguments.overrides.import;
  job.width = settings.width;
  job.height = settings.height;
  job.max_bounces = settings.max_bounces;
  job.pixel_sampling = settings.pixel_sampling;
  job.seed = settings.seed;
  job.device = arguments.device.limits();
  for (const fs::path& folder : arguments.technique.folders) job.technique_folders.push_back(fs::absolute(folder));
  job.work = ReferenceWork{path_set.to_string(), 0, 0, {}};
  return job;
}

/// One device, or several that share the rounds. Returns whether the goal was reached.
bool extend(const ReferenceArguments& arguments, bool quiet, Scene scene, const TechniqueRegistry& registry,
            const RenderSettings& settings, const PathSet& path_set, ReferenceImage& image) {
  const ReferenceIdentity identity(scene, settings, path_set, registry);
  const ExecutorOptions options = arguments.executor.resolved(arguments.device);
  if (!options.devices.empty() || options.kind == ExecutorOptions::Kind::slurm) {
    const KeepOnInterrupt keep_rounds;
    return Growth(arguments, quiet, settings, identity, image)
        .run_shared(job_of(arguments, settings, path_set), options);
  }
  RenderSession session(Device::open(arguments.device.resolved()), std::move(scene), registry.find("path_tracing"),
                        settings, reference_parameters(path_set));
  for (const std::string& limitation : session.limitations()) log_warning("path_tracing: {}", limitation);
  const KeepOnInterrupt keep_rounds;
  return Growth(arguments, quiet, settings, identity, image).run(session);
}

int render_reference(ReferenceArguments arguments, const Messages& messages) {
  if (arguments.file.extension() != ".exr")
    throw_error(ErrorClass::usage, "{}: the name must end in .exr", arguments.file.string());
  check_output(arguments.file, arguments.overwrite || arguments.extend);
  ReferenceGoal& goal = arguments.goal;
  if (goal.relmse <= 0 && goal.samples == 0 && goal.seconds <= 0) goal.samples = default_samples;

  Scene scene = arguments.load();
  RenderSettings settings = arguments.settings;
  settings.camera = scene.cameras.front();
  const TechniqueRegistry registry(arguments.technique.folders);
  const PathSet path_set = wanted_path_set(arguments, registry, scene, settings).simplified(scene);
  settings.max_bounces = path_set.max_bounces;
  const ReferenceIdentity identity(scene, settings, path_set, registry);
  ReferenceImage image = open_reference(arguments, identity, settings.width, settings.height);

  const uint64_t rounds_before = image.rounds();
  const bool done = extend(arguments, messages.quiet, std::move(scene), registry, settings, path_set, image);
  if (image.samples() == 0) {
    throw_error(ErrorClass::interrupted, "interrupted before the first iteration was done; nothing was written");
  }
  const ImageTest halves = image.test_halves();
  if (!halves.passed) {
    log_warning(
        "the halves of {} differ by more than noise; small samples of rare bright paths (fireflies) do that, or an "
        "error:",
        arguments.file.string());
    if (log_level() >= LogLevel::warning) print_note("{}", to_text(halves));
  }
  if (messages.json) {
    print_result("{}\n", reference_json(image, rounds_before, arguments.file, done).dump(2));
  } else {
    print_result("{}: {} per pixel, its own relMSE {}\n", arguments.file.string(), counted(image.samples(), "sample"),
                 image.error_known() ? fmt::format("{:.3g}", image.error().relmse)
                                     : "not known from so few samples; give --spp 32 or more");
  }
  if (done) return 0;
  log_warning("interrupted after {} per pixel; continue with --extend", counted(image.samples(), "sample"));
  return static_cast<int>(ErrorClass::interrupted);
}

/// One round by itself: the picture of so many samples with this seed.
int render_round(const ReferenceArguments& arguments, const ReferenceWork& work) {
  Scene scene = arguments.load();
  RenderSettings settings = arguments.settings;
  settings.camera = scene.cameras.front();
  const TechniqueRegistry registry(arguments.technique.folders);
  const PathSet path_set = PathSet::parse(work.path_set);
  RenderSession session(Device::open(arguments.device.resolved()), std::move(scene), registry.find("path_tracing"),
                        settings, reference_parameters(path_set));
  const KeepOnInterrupt end_by_itself;
  session.restart(settings.seed);
  RenderBudget budget;
  budget.samples = work.round_samples;
  if (session.run(budget)) throw_error(ErrorClass::interrupted, "interrupted; the round is not kept");
  write_exr(work.output, session.resolve());
  print_result("{}\n", nlohmann::ordered_json{{"schema", "lucarium-reference-round-1"},
                                              {"samples", session.last().samples},
                                              {"seconds", session.clocks().iterate}}
                           .dump(2));
  return 0;
}

}  // namespace

int reference(const Job& job, const ReferenceWork& work) {
  ReferenceArguments arguments;
  arguments.take(job);
  arguments.goal.relmse = work.relmse;
  arguments.goal.samples = work.samples;
  arguments.path_set = work.path_set;
  arguments.file = work.output;
  arguments.extend = true;
  Messages messages;
  messages.json = true;
  messages.verbose = job.verbose;
  messages.apply();
  if (work.round_samples > 0) return render_round(arguments, work);
  return render_reference(std::move(arguments), messages);
}

void add_reference_command(Command program, Action& action) {
  auto arguments = std::make_shared<ReferenceArguments>();
  arguments->image.seed = 0x5eed;  // not one of the small numbers that the runs it is compared with use
  Command command = program.add_subcommand("reference", "render a reference image to a wanted error, or extend one");
  command.option("scene", arguments->scene).required();
  command.option("--output", arguments->file).required().value_name("FILE.exr");
  command.flag("--extend", arguments->extend);
  command.flag("--overwrite", arguments->overwrite);
  ReferenceGoal& goal = arguments->goal;
  command.option("--relmse", goal.relmse).check(positive_number()).default_text("no limit");
  command.option("--spp", goal.samples)
      .check(whole_number(1))
      .default_text(fmt::format("{} without another budget", default_samples));
  command.option("--time", goal.seconds).check(positive_number()).default_text("no limit");
  arguments->image.add_to(command, true);
  arguments->overrides.add_to(command);
  arguments->technique.add_to(command, "all light paths");
  command.option("--path-set", arguments->path_set).default_text("all light paths");
  arguments->device.add_to(command);
  arguments->executor.add_to(command);
  command.excludes({"--path-set"}, {"--technique", "--parameter", "--max-bounces"});
  command.excludes({"--extend"}, {"--overwrite"});
  command.examples({"lucarium reference builtin:cornell --relmse 1e-4 -o reference.exr",
                    "lucarium reference builtin:cornell -t bundle_exchange --spp 1024 -o reference.exr"},
                   "docs/references.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) {
      arguments->settings = arguments->image.settings();
      return render_reference(*arguments, messages);
    };
  });
}

}  // namespace lucarium::app
