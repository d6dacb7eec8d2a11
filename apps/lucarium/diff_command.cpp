// SPDX-License-Identifier: Apache-2.0
// lucarium diff: how different two images are, layer by layer.
#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "lucarium/base/error.h"
#include "lucarium/compare/error_map.h"
#include "lucarium/compare/metrics.h"
#include "lucarium/film/image_io.h"
#include "options.h"

namespace lucarium::app {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

struct DiffArguments {
  fs::path test, reference, map;
  double max_relmse = -1;
  float exposure = 0;
  bool json = false, overwrite = false;
};

ordered_json metrics_json(const ImageMetrics& metrics) {
  ordered_json json;
  for (const Metric& metric : metric_table()) {
    const double value = metrics.*metric.value;
    json[metric.name] = std::isinf(value) ? ordered_json("infinite") : std::isnan(value) ? ordered_json(nullptr) : ordered_json(value);
  }
  json["mean_test"] = metrics.mean_test;
  json["mean_reference"] = metrics.mean_reference;
  json["nonfinite_pixels"] = metrics.nonfinite;
  return json;
}

void print_table(const ordered_json& layers) {
  for (const auto& [layer, values] : layers.items()) {
    fmt::print("{}\n", layer);
    for (const Metric& metric : metric_table()) {
      const ordered_json& value = values[metric.name];
      fmt::print("  {:<15} {:<12} {}\n", metric.name,
                 value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : value.is_null() ? "none" : value.get<std::string>(),
                 metric.formula);
    }
    fmt::print("  {:<15} {:.6g} against {:.6g}\n", "mean", values["mean_test"].get<double>(), values["mean_reference"].get<double>());
    if (values["nonfinite_pixels"] != 0) fmt::print("  {} non-finite pixels left out\n", values["nonfinite_pixels"].get<uint64_t>());
  }
}

int diff(const DiffArguments& arguments) {
  if (!arguments.map.empty() && fs::exists(arguments.map) && !arguments.overwrite) {
    throw_error(ErrorClass::usage, "{} exists; choose another --map or give --overwrite", arguments.map.string());
  }
  const Film test = read_image(arguments.test), reference = read_image(arguments.reference);
  if (test.width() != reference.width() || test.height() != reference.height()) {
    throw_error(ErrorClass::input, "{} is {}×{}, {} is {}×{}: images of different size cannot be compared",
                arguments.test.string(), test.width(), test.height(), arguments.reference.string(), reference.width(),
                reference.height());
  }
  const ImageMetrics whole = compute_metrics(test.width(), test.height(), test.image(), reference.image(), arguments.exposure);
  ordered_json layers = {{"image", metrics_json(whole)}};
  for (const FilmLayer& layer : test.layers()) {
    const FilmLayer* other = reference.find(layer.name);
    if (!layer.additive || layer.name == "image" || !other || other->channels != layer.channels) continue;
    layers[layer.name] = metrics_json(compute_metrics(test.width(), test.height(), layer.pixels, other->pixels, arguments.exposure));
  }
  if (!arguments.map.empty()) {
    write_png(arguments.map, test.width(), test.height(), signed_error_map(test.image(), reference.image()));
  }
  if (arguments.json) {
    ordered_json formulas;
    for (const Metric& metric : metric_table()) formulas[metric.name] = metric.formula;
    fmt::print("{}\n", ordered_json({{"formulas", formulas}, {"layers", layers}}).dump(2));
  } else {
    print_table(layers);
  }
  if (arguments.max_relmse >= 0 && whole.nonfinite > 0) {
    throw_error(ErrorClass::check_failed, "{} pixels of {} are not finite", whole.nonfinite, arguments.test.string());
  }
  if (arguments.max_relmse >= 0 && whole.relmse > arguments.max_relmse) {
    throw_error(ErrorClass::check_failed, "relMSE {:.3g} is above {:.3g}", whole.relmse, arguments.max_relmse);
  }
  return 0;
}

}  // namespace

void add_diff_command(CLI::App& program, Action& action) {
  auto arguments = std::make_shared<DiffArguments>();
  CLI::App& command = *program.add_subcommand("diff", "metrics of a test image against a reference image");
  command.add_option("test", arguments->test, "image under test")->required();
  command.add_option("reference", arguments->reference, "reference image")->required();
  command.add_option("--map", arguments->map, "write the signed relative error as a .png");
  command.add_option("--max-relmse", arguments->max_relmse, "exit code 1 above this")->check(CLI::NonNegativeNumber);
  command.add_option("--exposure", arguments->exposure, "for PSNR and SSIM [stops]");
  command.add_flag("--json", arguments->json, "print JSON");
  command.add_flag("--overwrite", arguments->overwrite, "replace an existing --map");
  command.callback([arguments, &action] { action = [arguments] { return diff(*arguments); }; });
}

}  // namespace lucarium::app
