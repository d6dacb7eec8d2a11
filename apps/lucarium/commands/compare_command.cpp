// SPDX-License-Identifier: Apache-2.0
// lucarium compare. Declared in commands.h.
#include <cmath>

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compare/results/winners.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/compare/run/dry_run.h"
#include "options/executor_arguments.h"
#include "options/options.h"
#include "outputs/plan_text.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

struct CompareArguments {
  std::vector<std::string> scenes;
  fs::path comparison;  ///< a file that defines everything instead
  std::vector<double> seconds, relmse;
  std::vector<uint64_t> iterations, samples;
  double limit_seconds = 600;
  ComparisonSpec spec;  ///< seeds, reference and fallback go there directly
  DeviceArguments device;
  ExecutorArguments executor;
  SceneArguments overrides;
  ImageArguments image;
  TechniqueArguments technique;
  std::vector<std::string> gates;
  ComparisonOptions options;
  fs::path reference;
  bool dry_run = false;
};

/// A scene as given; files are named absolutely, so that the comparison can be resumed from anywhere.
ComparisonScene make_scene(const std::string& source, const SceneArguments& overrides) {
  ComparisonScene scene;
  scene.source = source;
  if (!source.starts_with("builtin:") && fs::exists(source)) {
    scene.source = fs::absolute(source).lexically_normal().string();
    scene.name = source;
  }
  scene.overrides = overrides.resolved();
  scene.import = overrides.import;
  return scene;
}

ComparisonSpec spec_of(const CompareArguments& arguments) {
  ComparisonSpec spec = arguments.spec;
  for (const std::string& source : arguments.scenes) spec.scenes.push_back(make_scene(source, arguments.overrides));
  for (const TechniqueArguments::Spec& technique : arguments.technique.all())
    spec.variants.push_back({technique.name, technique.parameters, ""});
  for (const double seconds : arguments.seconds) spec.budgets.push_back({seconds, 0, 0, 0});
  for (const uint64_t iterations : arguments.iterations) spec.budgets.push_back({0, iterations, 0, 0});
  for (const uint64_t samples : arguments.samples) spec.budgets.push_back({0, 0, 0, 0, samples});
  for (const double error : arguments.relmse) spec.budgets.push_back({0, 0, error, arguments.limit_seconds});
  const RenderSettings settings = arguments.image.settings();
  spec.width = settings.width;
  spec.height = settings.height;
  spec.max_bounces = settings.max_bounces;
  spec.pixel_sampling = settings.pixel_sampling;
  if (!arguments.reference.empty()) spec.reference.file = fs::absolute(arguments.reference).lexically_normal();
  return spec;
}

/// From the file, or from the arguments; which device runs it is always the arguments' to say.
ComparisonSpec wanted_comparison(const CompareArguments& arguments) {
  ComparisonSpec spec = arguments.comparison.empty() ? spec_of(arguments) : read_comparison(arguments.comparison);
  const std::vector<std::string> device = arguments.device.in_comparison();
  spec.device_arguments.insert(spec.device_arguments.end(), device.begin(), device.end());
  return spec;
}

/// Whether everything that was asked for is there and clears its bars; says what does not.
bool succeeded(const ComparisonResult& result) {
  bool fine = true;
  for (const SceneResult& scene : result.scenes) {
    fine &= scene.failure.empty() || scene.left_out;
    for (const ReferenceResult& reference : scene.references) fine &= reference.failure.empty();
  }
  for (const PieceResult& piece : result.pieces) fine &= piece.failure.empty();
  for (const GateResult& gate : result.gates) {
    if (gate.passed) continue;
    fine = false;
    log_message(LogLevel::error,
                fmt::format("gate {} {}: {} with {} on {}", gate.gate, gate.unlike_machines ? "unknown" : "missed",
                            gate.unlike_machines     ? "the machines differ"
                            : std::isnan(gate.value) ? "no result"
                                                     : fmt::format("{:.4g}", gate.value),
                            result.spec.variants[gate.variant].label(), result.scenes[gate.scene].name));
  }
  return fine;
}

int compare(CompareArguments arguments, const Messages& messages) {
  const ComparisonSpec spec = wanted_comparison(arguments);
  ComparisonOptions& options = arguments.options;
  for (const std::string& gate : arguments.gates) options.gates.push_back(parse_gate(gate));
  arguments.device.apply_to(options, arguments.technique.folders);
  options.executor = arguments.executor.resolved(arguments.device);
  if (!messages.quiet) options.progress = [](const std::string& line) { print_note("{}\n", line); };
  const TechniqueRegistry registry(arguments.technique.folders);
  if (arguments.dry_run) {
    print_plans({{"comparison", describe_plan(spec, registry, options)}}, messages.json);
    return 0;
  }
  if (options.folder.empty()) throw_error(ErrorClass::usage, "no output folder given; add --output FOLDER");
  const ComparisonResult result = run_comparison(spec, registry, options);
  if (messages.json) {
    print_result("{}", result.to_json());
  } else {
    print_result("{}", describe_winners(result));
    if (result.baseline) print_result("{}", result.baseline->table(result));
    if (fs::path page = options.folder / "report.html"; fs::exists(page)) print_result("report: {}\n", page.string());
  }
  if (result.interrupted) {
    log_warning("interrupted: finished pieces are kept; continue with --resume");
    return static_cast<int>(ErrorClass::interrupted);
  }
  return succeeded(result) ? 0 : static_cast<int>(ErrorClass::check_failed);
}

/// What --comparison says: options that would do nothing beside it.
const std::vector<std::string>& stated_in_file() {
  static const std::vector<std::string> names = {"scene",
                                                 "--technique",
                                                 "--parameter",
                                                 "--time",
                                                 "--iterations",
                                                 "--spp",
                                                 "--relmse",
                                                 "--limit",
                                                 "--seeds",
                                                 "--reference",
                                                 "--reference-spp",
                                                 "--reference-relmse",
                                                 "--fallback-environment",
                                                 "--size",
                                                 "--max-bounces",
                                                 "--pixel-sampling",
                                                 "--exposure",
                                                 "--camera",
                                                 "--camera-path",
                                                 "--environment",
                                                 "--light",
                                                 "--material",
                                                 "--no-sidecar",
                                                 "--texture-size",
                                                 "--at",
                                                 "--animation"};
  return names;
}

void add_options(Command command, const std::shared_ptr<CompareArguments>& arguments) {
  command.option("scene", arguments->scenes);
  command.option("--comparison", arguments->comparison).default_text("none");
  command.option("--output", arguments->options.folder).value_name("FOLDER").default_text("none, with --dry-run");
  command.flag("--overwrite", arguments->options.overwrite);
  command.flag("--resume", arguments->options.resume);
  command.flag("--dry-run", arguments->dry_run);
  command.flag("--link-images", arguments->options.report.link_images);
  command.option("--gate", arguments->gates).repeatable().default_text("none");
  command.option("--baseline", arguments->options.baseline).default_text("none");
  command.option("--time", arguments->seconds).check(positive_number()).repeatable().default_text("none");
  command.option("--spp", arguments->samples).check(whole_number(1)).repeatable().default_text("none");
  command.option("--iterations", arguments->iterations).check(whole_number(1)).repeatable().default_text("none");
  command.option("--relmse", arguments->relmse).check(positive_number()).repeatable().default_text("none");
  command.option("--limit", arguments->limit_seconds).check(positive_number()).capture_default_str();
  command.option("--seeds", arguments->spec.seeds).check(in_range(1, 1000)).capture_default_str();
  command.option("--reference", arguments->reference).default_text("rendered");
  ReferenceRequest& reference = arguments->spec.reference;
  command.option("--reference-spp", reference.samples).check(in_range(32, 1 << 24)).capture_default_str();
  command.option("--reference-relmse", reference.relmse).check(positive_number()).default_text("no limit");
  arguments->image.add_to(command, false);
  arguments->overrides.add_exposure_to(command);
  arguments->overrides.add_to(command);
  command.option("--fallback-environment", arguments->spec.fallback_environment).default_text("none");
  arguments->technique.add_to(command, "none", true);
  arguments->device.add_to(command, true);
  arguments->executor.add_to(command);
}

}  // namespace

void add_compare_command(Command program, Action& action) {
  auto arguments = std::make_shared<CompareArguments>();
  Command command = program.add_subcommand("compare", "compare techniques on scenes against references");
  add_options(command, arguments);
  command.needs({"--limit"}, {"--relmse"});
  command.excludes({"--comparison"}, stated_in_file());
  command.excludes({"--reference"}, {"--reference-spp", "--reference-relmse"});
  command.excludes({"--resume"}, {"--overwrite"});
  command.excludes({"--dry-run"},
                   {"--gate", "--baseline", "--link-images", "--resume", "--overwrite", "--executor", "--slurm"});
  command.examples({"lucarium compare builtin:cornell -t path_tracing -t bundle_exchange --time 10 -o results",
                    "lucarium compare --comparison study.json -o results"},
                   "docs/comparisons.md");
  command.callback([arguments, &action] {
    action = [arguments](const Messages& messages) { return compare(*arguments, messages); };
  });
}

}  // namespace lucarium::app
