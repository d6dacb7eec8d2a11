// SPDX-License-Identifier: Apache-2.0
// lucarium compare and lucarium report.
#include <CLI/CLI.hpp>
#include <set>

#include "commands.h"
#include "lucarium/base/atomic_file.h"
#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/compare/comparison.h"
#include "lucarium/compute/program_cache.h"
#include "options.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

struct CompareArguments {
  ComparisonSpec spec;
  DeviceArguments device;
  SceneArguments overrides;
  ImageArguments image;
  TechniqueArguments technique;
  OutputArguments output;
  fs::path folder, reference;
  bool resume = false, overwrite = false;
};

int compare(CompareArguments arguments) {
  arguments.output.apply();
  ComparisonSpec& spec = arguments.spec;
  std::set<std::string> labels;
  for (const TechniqueArguments::Spec& technique : arguments.technique.specs) {
    spec.variants.push_back({technique.name, technique.parameters});
    if (!labels.insert(spec.variants.back().label()).second) {
      throw_error(ErrorClass::usage, "-t {} is given twice", spec.variants.back().label());
    }
  }
  const RenderSettings settings = arguments.image.settings();
  spec.width = settings.width;
  spec.height = settings.height;
  spec.max_bounces = settings.max_bounces;
  spec.pixel_sampling = settings.pixel_sampling;
  spec.overrides = arguments.overrides.resolved();
  spec.exposure = spec.overrides.exposure;
  spec.scene_arguments = arguments.overrides.words();
  spec.device_arguments = arguments.device.words();
  for (const fs::path& path : arguments.technique.folders) {
    spec.device_arguments.insert(spec.device_arguments.end(), {"--technique-path", fs::absolute(path).string()});
  }
  if (!arguments.reference.empty()) spec.reference = fs::absolute(arguments.reference);

  ComparisonOptions options;
  options.folder = arguments.folder;
  options.resume = arguments.resume;
  options.overwrite = arguments.overwrite;
  options.program = fs::read_symlink("/proc/self/exe");
  options.cache_dir = resolve_cache_dir(arguments.device.resolved());
  if (!arguments.output.quiet) options.progress = [](const std::string& line) { fmt::print(stderr, "{}\n", line); };
  const ComparisonResult result = run_comparison(spec, TechniqueRegistry(arguments.technique.folders), options);
  if (arguments.output.json) fmt::print("{}", result.to_json());
  if (!arguments.output.quiet) fmt::print(stderr, "report: {}\n", (options.folder / "report.html").string());
  if (result.interrupted) {
    log_warning("interrupted: finished pieces are kept; continue with --resume");
    return static_cast<int>(ErrorClass::interrupted);
  }
  bool failed = false;
  for (const SceneResult& scene : result.scenes) failed |= !scene.failure.empty();
  for (const PieceResult& piece : result.pieces) failed |= !piece.failure.empty();
  return failed ? static_cast<int>(ErrorClass::check_failed) : 0;
}

int report(const fs::path& folder) {
  const fs::path file = folder / "results.json";
  write_report(ComparisonResult::parse(read_file(file), file.string()), folder);
  fmt::print("{}\n", (folder / "report.html").string());
  return 0;
}

}  // namespace

void add_compare_command(CLI::App& program, Action& action) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App& command = *program.add_subcommand("compare", "compare technique variants on scenes against a reference");
  command.add_option("scenes", arguments->spec.scenes, ".gltf, .glb or builtin:NAME, one or more")->required();
  arguments->technique.add_to(command);
  command.add_option("-o,--output", arguments->folder, "folder of the results")->required();
  command.add_option("--time", arguments->spec.budget.seconds, "equal time: seconds of iterating")->check(CLI::PositiveNumber);
  command.add_option("--iterations", arguments->spec.budget.iterations, "equal iterations")->check(CLI::PositiveNumber);
  command.add_option("--seeds", arguments->spec.seeds, "independent runs of each variant")->check(CLI::Range(1, 1000))->capture_default_str();
  command.add_option("--reference", arguments->reference, "image to compare with, instead of a rendered reference");
  command.add_option("--reference-spp", arguments->spec.reference_samples, "samples per pixel of the rendered reference")
      ->check(CLI::Range(16, 1 << 24))->capture_default_str();
  command.add_option("--fallback-environment", arguments->spec.fallback_environment, "r,g,b of the sky of scenes without any light");
  arguments->image.add_to(command, false);
  arguments->overrides.add_to(command);
  command.add_flag("--resume", arguments->resume, "continue an interrupted comparison in the same folder");
  command.add_flag("--overwrite", arguments->overwrite, "replace the results in the folder");
  arguments->device.add_to(command);
  arguments->output.add_to(command);
  command.callback([arguments, &action] { action = [arguments] { return compare(*arguments); }; });
}

void add_report_command(CLI::App& program, Action& action) {
  auto folder = std::make_shared<fs::path>();
  CLI::App& command = *program.add_subcommand("report", "write report.html anew from the results in a folder");
  command.add_option("folder", *folder, "folder of the results")->required();
  command.callback([folder, &action] { action = [folder] { return report(*folder); }; });
}

}  // namespace lucarium::app
