// SPDX-License-Identifier: Apache-2.0
// lucarium compare and lucarium report.
#include <cmath>

#include "commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compare/run/comparison.h"
#include "lucarium/compare/run/dry_run.h"
#include "options.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

struct CompareArguments {
  std::vector<std::string> scenes;
  fs::path comparison;  ///< a file that defines everything instead
  std::vector<double> seconds, equal_error;
  std::vector<uint64_t> iterations;
  double limit_seconds = 600;
  ComparisonSpec spec;  ///< seeds, reference and fallback go there directly
  DeviceArguments device;
  SceneArguments overrides;
  ImageArguments image;
  TechniqueArguments technique;
  OutputArguments output;
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
  for (const TechniqueArguments::Spec& technique : arguments.technique.specs) {
    spec.variants.push_back({technique.name, technique.parameters, ""});
  }
  for (const double seconds : arguments.seconds) spec.budgets.push_back({seconds, 0, 0, 0});
  for (const uint64_t iterations : arguments.iterations) spec.budgets.push_back({0, iterations, 0, 0});
  for (const double error : arguments.equal_error) spec.budgets.push_back({0, 0, error, arguments.limit_seconds});
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
  if (!arguments.comparison.empty() && (!arguments.scenes.empty() || !arguments.technique.specs.empty())) {
    throw_error(ErrorClass::usage, "--comparison {} defines the whole comparison; leave out scenes and -t",
                arguments.comparison.string());
  }
  ComparisonSpec spec = arguments.comparison.empty() ? spec_of(arguments) : read_comparison(arguments.comparison);
  const std::vector<std::string> device = arguments.device.in_comparison();
  spec.device_arguments.insert(spec.device_arguments.end(), device.begin(), device.end());
  return spec;
}

/// Whether everything that was asked for is there and clears its bars; says what does not.
bool succeeded(const ComparisonResult& result) {
  bool fine = true;
  for (const SceneResult& scene : result.scenes) {
    fine &= scene.failure.empty();
    for (const ReferenceResult& reference : scene.references) fine &= reference.failure.empty();
  }
  for (const PieceResult& piece : result.pieces) fine &= piece.failure.empty();
  for (const GateResult& gate : result.gates) {
    if (gate.passed) continue;
    fine = false;
    log_message(LogLevel::error,
                fmt::format("gate {} missed: {} with {} on {}", gate.gate,
                            std::isnan(gate.value) ? "no result" : fmt::format("{:.4g}", gate.value),
                            result.spec.variants[gate.variant].label(), result.scenes[gate.scene].name));
  }
  return fine;
}

int compare(CompareArguments arguments) {
  arguments.output.apply();
  const ComparisonSpec spec = wanted_comparison(arguments);
  ComparisonOptions& options = arguments.options;
  for (const std::string& gate : arguments.gates) options.gates.push_back(parse_gate(gate));
  arguments.device.apply_to(options, arguments.technique.folders);
  if (!arguments.output.quiet) options.progress = [](const std::string& line) { print_note("{}\n", line); };
  const TechniqueRegistry registry(arguments.technique.folders);
  if (arguments.dry_run) {
    print_result("{}", describe_plan(spec, registry, options));
    return 0;
  }
  if (options.folder.empty()) throw_error(ErrorClass::usage, "where to? add --output FOLDER");
  const ComparisonResult result = run_comparison(spec, registry, options);
  if (arguments.output.json) print_result("{}", result.to_json());
  if (!arguments.output.quiet) {
    if (result.baseline) print_note("{}", result.baseline->table(result));
    if (fs::path page = options.folder / "report.html"; fs::exists(page)) print_note("report: {}\n", page.string());
  }
  if (result.interrupted) {
    log_warning("interrupted: finished pieces are kept; continue with --resume");
    return static_cast<int>(ErrorClass::interrupted);
  }
  return succeeded(result) ? 0 : static_cast<int>(ErrorClass::check_failed);
}

int report(const fs::path& folder, const ReportOptions& options) {
  write_report(folder, options);
  print_result("{}\n", (folder / "report.html").string());
  return 0;
}

}  // namespace

void add_compare_command(Command program, Action& action) {
  auto arguments = std::make_shared<CompareArguments>();
  Command command = program.add_subcommand("compare", "compare technique variants on scenes against a reference");
  command.add_option("scenes", arguments->scenes, ".gltf, .glb or builtin:NAME, one or more");
  command.add_option("--comparison", arguments->comparison,
                     "JSON file that defines scenes, techniques, budgets (docs/comparisons.md)");
  arguments->technique.add_to(command);
  command.add_option("-o,--output", arguments->options.folder, "folder of the results");
  const auto add_budget = [&command](const char* name, auto& values, const char* text) {
    using Value = typename std::decay_t<decltype(values)>::value_type;
    const Check valid = std::is_integral_v<Value> ? whole_number(1) : positive_number();
    command.add_option(name, values, text)->check(valid)->take_all()->expected(1)->allow_extra_args(false);
  };
  add_budget("--time", arguments->seconds,
             "equal time: seconds of preparing and iterating; may be given several times");
  add_budget("--iterations", arguments->iterations, "equal iterations; may be given several times");
  add_budget("--equal-error", arguments->equal_error, "equal error: time to this relMSE; may be given several times");
  command.add_option("--limit", arguments->limit_seconds, "seconds after which --equal-error gives up")
      ->check(positive_number())
      ->capture_default_str();
  command.add_option("--seeds", arguments->spec.seeds, "independent runs of each variant")
      ->check(in_range(1, 1000))
      ->capture_default_str();
  command.add_option("--reference", arguments->reference, "image to compare with, instead of a rendered reference");
  command
      .add_option("--reference-spp", arguments->spec.reference.samples,
                  "samples per pixel of rendered references, at most")
      ->check(in_range(32, 1 << 24))
      ->capture_default_str();
  command
      .add_option("--reference-error", arguments->spec.reference.relmse,
                  "stop a reference when its own relMSE is at most this")
      ->check(positive_number());
  command.add_option("--fallback-environment", arguments->spec.fallback_environment,
                     "r,g,b of the sky of scenes without any light");
  command
      .add_option("--gate", arguments->gates,
                  "METRIC<VALUE, METRIC>VALUE or LABEL:METRIC<VALUE: exit code 1 when it is missed")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--baseline", arguments->options.baseline, "folder of an earlier comparison: say what changed");
  command.add_flag("--dry-run", arguments->dry_run,
                   "print the plan, with light paths, memory and time, and render nothing but first iterations");
  command.add_flag("--link-images", arguments->options.report.link_images,
                   "report with images beside it, in full precision");
  arguments->image.add_to(command, false);
  arguments->overrides.add_to(command);
  command.add_flag("--resume", arguments->options.resume, "continue an interrupted comparison in the same folder");
  command.add_flag("--overwrite", arguments->options.overwrite, "replace the results in the folder")
      ->excludes("--resume");
  arguments->device.add_to(command);
  arguments->output.add_to(command);
  command.callback([arguments, &action] { action = [arguments] { return compare(*arguments); }; });
}

void add_report_command(Command program, Action& action) {
  struct ReportArguments {
    fs::path folder;
    ReportOptions options;
  };
  auto arguments = std::make_shared<ReportArguments>();
  Command command = program.add_subcommand("report", "write report.html again from the results in a folder");
  command.add_option("folder", arguments->folder, "folder of the results")->required();
  command.add_flag("--link-images", arguments->options.link_images, "images beside the page, in full precision");
  command.callback(
      [arguments, &action] { action = [arguments] { return report(arguments->folder, arguments->options); }; });
}

}  // namespace lucarium::app
