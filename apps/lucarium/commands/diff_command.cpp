// SPDX-License-Identifier: Apache-2.0
// lucarium diff: how different two images are, layer by layer. Declared in commands.h.
#include <cmath>
#include <optional>

#include "commands/commands.h"
#include "grammar/option_texts.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/reference/reference_image.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/error_map.h"
#include "lucarium/metrics/metrics.h"
#include "lucarium/statistics/image_comparison.h"
#include "lucarium/statistics/statistics.h"
#include "options/options.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct DiffArguments {
  fs::path test, reference, map;
  std::string map_kind = "signed";
  std::optional<double> max_relmse;
  float exposure = 0;
  bool formulas = false, overwrite = false, statistical = false;
};

struct LayerMetrics {
  std::string layer;
  ImageMetrics metrics;
};

/// As .exr the values themselves, in R, G and B; as .png colours.
void write_map(const DiffArguments& arguments, const Film& test, const std::vector<float>& reference,
               const MetricReference& prepared) {
  const bool is_signed = arguments.map_kind == "signed";
  const std::vector<float> map = is_signed                          ? signed_relative_error(test.image(), reference)
                                 : arguments.map_kind == "ldr_flip" ? prepared.ldr_flip_map(test.image())
                                                                    : prepared.hdr_flip_map(test.image());
  if (arguments.map.extension() == ".png") {
    return write_png(arguments.map, test.width(), test.height(),
                     is_signed ? color_signed_error(map) : color_error(map));
  }
  Film film(test.width(), test.height());
  FilmLayer& image = film.layer("image", {"R", "G", "B"}, true);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = map[i / 3];
  film.metadata["error_map"] = arguments.map_kind;
  write_exr(arguments.map, film);
}

/// The image and the radiance layers that both images have.
std::vector<LayerMetrics> measure_layers(const DiffArguments& arguments, const Film& test, const Film& reference,
                                         const MetricReference& prepared) {
  std::vector<LayerMetrics> layers = {{"image", prepared.measure(test.image())}};
  for (const FilmLayer& layer : test.layers()) {
    const FilmLayer* other = reference.find(layer.name);
    if (!layer.additive || layer.name == "image" || !other || other->channels != layer.channels) continue;
    layers.push_back(
        {layer.name, compute_metrics(test.width(), test.height(), layer.pixels, other->pixels, arguments.exposure)});
  }
  return layers;
}

ordered_json json_number(double value) {
  return std::isnan(value) ? ordered_json(nullptr) : std::isinf(value) ? ordered_json("infinite") : ordered_json(value);
}

ordered_json metrics_json(const ImageMetrics& metrics) {
  ordered_json json;
  for (const Metric& metric : metric_table()) json[metric.name] = json_number(metrics.*metric.value);
  json["mean_test"] = metrics.mean_test;
  json["mean_reference"] = metrics.mean_reference;
  json["nonfinite_pixels"] = metrics.nonfinite;
  return json;
}

/// The reference's own error, where its file states it, and the measured error without it.
ordered_json reference_json(const Film& reference, const ImageMetrics& whole) {
  ReferenceError own;
  if (!estimate_reference_error(reference, own)) return nullptr;
  const DebiasedError mse = debiased_error(whole.mse, own.mse), relmse = debiased_error(whole.relmse, own.relmse);
  return {{"own_mse", own.mse},           {"own_relmse", own.relmse},        {"debiased_mse", mse.value},
          {"mse_resolved", mse.resolved}, {"debiased_relmse", relmse.value}, {"relmse_resolved", relmse.resolved}};
}

ordered_json diff_json(const DiffArguments& arguments, const std::vector<LayerMetrics>& layers,
                       const HdrFlipExposures& exposures, const ordered_json& reference) {
  ordered_json metrics, values;
  for (const Metric& metric : metric_table()) {
    metrics[metric.name] = {
        {"formula", metric.formula}, {"unit", metric.unit}, {"lower_is_better", metric.lower_is_better}};
  }
  for (const LayerMetrics& layer : layers) values[layer.layer] = metrics_json(layer.metrics);
  return {{"schema", "lucarium-diff-1"},
          {"exposure_stops", arguments.exposure},
          {"hdr_flip_exposures", {{"start", exposures.start}, {"stop", exposures.stop}, {"count", exposures.count}}},
          {"metrics", metrics},
          {"layers", values},
          {"reference", reference}};
}

void print_table(const DiffArguments& arguments, const std::vector<LayerMetrics>& layers) {
  const auto print_row = [&](const std::string& name, const std::string& unit, auto&& text_of) {
    print_result("{:<15} {:<11}", name, unit);
    for (const LayerMetrics& layer : layers) print_result(" {:>12}", text_of(layer));
    print_result("\n");
  };
  const auto number = [](double value) {
    return std::isnan(value) ? std::string("none") : fmt::format("{:.6g}", value);
  };
  print_row("", "", [](const LayerMetrics& layer) { return layer.layer; });
  for (const Metric& metric : metric_table()) {
    print_row(metric.name, metric.unit, [&](const LayerMetrics& layer) { return number(layer.metrics.*metric.value); });
  }
  print_row("mean of test", "cd/m^2", [&](const LayerMetrics& layer) { return number(layer.metrics.mean_test); });
  print_row("of reference", "cd/m^2", [&](const LayerMetrics& layer) { return number(layer.metrics.mean_reference); });
  for (const LayerMetrics& layer : layers) {
    if (layer.metrics.nonfinite)
      print_result("{}: left out as not finite: {}\n", layer.layer, counted(layer.metrics.nonfinite, "pixel"));
  }
  std::string higher;
  for (const Metric& metric : metric_table()) {
    if (!metric.lower_is_better) higher += (higher.empty() ? "" : ", ") + metric.name;
  }
  print_result("Less is better, more of {}. Exposure of PSNR, SSIM, LDR_FLIP: {} stops.{}\n", higher,
               arguments.exposure, arguments.formulas ? "" : " What they mean: --formulas");
}

void print_reference(const ordered_json& reference) {
  if (reference.is_null()) return;
  for (const auto& [name, key] : {std::pair{"MSE", "mse"}, std::pair{"relMSE", "relmse"}}) {
    print_result("The reference's own {} is {:.3g}; without it, that of the image is {:.6g}{}\n", name,
                 reference[std::string("own_") + key].get<double>(),
                 reference[std::string("debiased_") + key].get<double>(),
                 reference[std::string(key) + "_resolved"].get<bool>()
                     ? "."
                     : ": the reference is too noisy to decide (above a tenth).");
  }
}

void print_formulas() {
  print_result("x: image under test, r: reference, mean: over pixels and channels.\n");
  for (const Metric& metric : metric_table()) print_result("{:<15} {}\n", metric.name, metric.formula);
}

void print_formulas(const HdrFlipExposures& exposures) {
  print_result("\n");
  print_formulas();
  print_result("Exposures of HDR_FLIP: {} from {:.4f} to {:.4f} stops.\n", exposures.count, exposures.start,
               exposures.stop);
}

void check_limit(const DiffArguments& arguments, const ImageMetrics& whole) {
  if (!arguments.max_relmse) return;
  if (whole.nonfinite > 0) {
    throw_error(ErrorClass::check_failed, "{}: not finite: {}", arguments.test.string(),
                counted(whole.nonfinite, "pixel"));
  }
  if (!(whole.relmse <= *arguments.max_relmse)) {  // also where it is not a number
    throw_error(ErrorClass::check_failed, "relMSE {:.3g} is above {:.3g}", whole.relmse, *arguments.max_relmse);
  }
}

ordered_json image_test_json(const ImageTest& outcome) {
  ordered_json levels = ordered_json::array();
  for (const ImageTestLevel& level : outcome.levels) {
    levels.push_back({{"name", level.name},
                      {"tests", level.tests},
                      {"constant", level.constant},
                      {"failures", level.failures},
                      {"level", level.level},
                      {"smallest_p", level.smallest_p},
                      {"worst_t", json_number(level.worst_t)},
                      {"worst_x", level.worst_x},
                      {"worst_y", level.worst_y},
                      {"ks_p", level.ks_p}});
  }
  return {{"schema", "lucarium-image-test-1"},
          {"passed", outcome.passed},
          {"mean_test", outcome.mean_a},
          {"mean_reference", outcome.mean_b},
          {"levels", levels}};
}

/// Two independent renders with replicates: the same up to noise?
int test_statistically(const DiffArguments& arguments, const Film& test, const Film& reference, bool json) {
  const ImageTest outcome = test_images(ImageEstimate::from_film(test, arguments.test.string()),
                                        ImageEstimate::from_film(reference, arguments.reference.string()));
  if (json) {
    print_result("{}\n", image_test_json(outcome).dump(2));
  } else {
    print_result("{}", to_text(outcome));
  }
  if (!outcome.passed) {
    throw_error(ErrorClass::check_failed, "{} and {} differ by more than their noise", arguments.test.string(),
                arguments.reference.string());
  }
  return 0;
}

int diff(const DiffArguments& arguments, const Messages& messages) {
  if (!arguments.map.empty()) {
    check_image_name(arguments.map);
    check_output(arguments.map, arguments.overwrite);
  }
  if (arguments.test.empty()) {  // --formulas alone
    print_formulas();
    return 0;
  }
  const Film test = read_image(arguments.test), reference = read_image(arguments.reference);
  if (arguments.statistical) return test_statistically(arguments, test, reference, messages.json);
  if (test.width() != reference.width() || test.height() != reference.height()) {
    throw_error(ErrorClass::input, "{} is {}×{}, {} is {}×{}: images of different size cannot be compared",
                arguments.test.string(), test.width(), test.height(), arguments.reference.string(), reference.width(),
                reference.height());
  }
  const MetricReference prepared(test.width(), test.height(), reference.image(), {arguments.exposure});
  const std::vector<LayerMetrics> layers = measure_layers(arguments, test, reference, prepared);
  const ordered_json own = reference_json(reference, layers[0].metrics);
  if (!arguments.map.empty()) write_map(arguments, test, reference.image(), prepared);
  if (messages.json) {
    print_result("{}\n", diff_json(arguments, layers, prepared.hdr_exposures(), own).dump(2));
  } else {
    print_table(arguments, layers);
    print_reference(own);
    if (arguments.formulas) print_formulas(prepared.hdr_exposures());
  }
  check_limit(arguments, layers[0].metrics);
  return 0;
}

}  // namespace

void add_diff_command(Command program, Action& action) {
  auto arguments = std::make_shared<DiffArguments>();
  Command command = program.add_subcommand("diff", "metrics of a test image against a reference image");
  command.option("test", arguments->test);
  command.option("reference", arguments->reference);
  command.option("--output", arguments->map).value_name("MAP.exr|.png").default_text("none");
  command.option("--map-of", arguments->map_kind).check(one_of(option_words("--map-of"))).capture_default_str();
  command.flag("--overwrite", arguments->overwrite);
  command.option("--max-relmse", arguments->max_relmse).check(not_negative_number()).default_text("no limit");
  command.flag("--statistical", arguments->statistical);
  command.flag("--formulas", arguments->formulas);
  command.option("--exposure", arguments->exposure).check(finite_number()).capture_default_str();
  command.required_without("--formulas", {"test", "reference"});
  command.needs({"--output", "--max-relmse", "--exposure"}, {"test"});
  command.needs({"--map-of", "--overwrite"}, {"--output"});
  command.excludes({"--statistical"}, {"--output", "--max-relmse", "--exposure", "--formulas"});
  command.excludes({"--formulas"}, {"--json"});
  command.examples({"lucarium diff test.exr reference.exr -o map.png --map-of hdr_flip",
                    "lucarium diff test.exr reference.exr --max-relmse 0.01 --json"},
                   "docs/metrics.md");
  command.callback(
      [arguments, &action] { action = [arguments](const Messages& messages) { return diff(*arguments, messages); }; });
}

}  // namespace lucarium::app
