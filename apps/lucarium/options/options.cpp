// SPDX-License-Identifier: Apache-2.0
#include "options/options.h"

#include <algorithm>
#include <charconv>

#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/request_limits.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/base/text/spelling.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/base/utf8.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/compute/device/cache_folder.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/services/path_set.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

std::optional<uint32_t> parse_uint(std::string_view text) {
  uint32_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

/// At both ends: a list that is written in quotes has blanks behind its commas.
std::string without_blanks(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

std::pair<std::string, std::string> parse_assignment(const std::string& text) {
  const size_t equals = text.find('=');
  const std::string key = without_blanks(text.substr(0, equals));
  if (equals == std::string::npos || key.empty()) throw_error(ErrorClass::usage, "'{}' is not key=value", text);
  return {key, without_blanks(text.substr(equals + 1))};
}

/// Devices that share the work, which is not the comparison's to say.
bool names_several(const std::string& selector) { return selector == "all" || selector.find(',') != std::string::npos; }

}  // namespace

void add_technique_path(Command command, std::vector<std::filesystem::path>& folders) {
  command.option("--technique-path", folders)
      .check(existing_folder())
      .repeatable()
      .default_text("LUCARIUM_TECHNIQUE_PATH");
}

void DeviceArguments::add_to(Command command, bool caches_references) {
  command.option("--device", options.selector).default_text("first GPU, else first");
  command.option("--threads", options.threads).check(in_range(0, max_threads)).capture_default_str();
  command.option("--cache-dir", options.cache_dir).default_text("~/.cache/lucarium");
  command.flag("--no-cache", no_cache);
  if (!caches_references) command.excludes({"--no-cache"}, {"--cache-dir"});
  command.option("--memory-limit", memory_limit).default_text("the device's");
  command.option("--allocation-limit", allocation_limit).default_text("the device's");
}

const std::vector<std::string>& device_option_names() {
  static const std::vector<std::string> names = {"--device",   "--threads",      "--cache-dir",
                                                 "--no-cache", "--memory-limit", "--allocation-limit"};
  return names;
}

void DeviceArguments::take(const DeviceOptions& given) {
  options = given;
  no_cache = !given.use_cache;
}

DeviceOptions DeviceArguments::resolved() const {
  if (names_several(options.selector))
    throw_error(ErrorClass::usage,
                "--device {}: one device does this; several share what compare, reproduce and reference do",
                options.selector);
  return limits();
}

DeviceOptions DeviceArguments::limits() const {
  DeviceOptions result = options;
  if (names_several(options.selector)) result.selector.clear();
  result.use_cache = !no_cache;
  if (!memory_limit.empty()) result.memory_limit_bytes = parse_bytes(memory_limit, "--memory-limit");
  if (!allocation_limit.empty()) result.allocation_limit_bytes = parse_bytes(allocation_limit, "--allocation-limit");
  return result;
}

std::vector<std::string> DeviceArguments::shared() const {
  if (!names_several(options.selector)) return {};
  std::vector<std::string> known, chosen;
  for (const DeviceInfo& device : list_devices(limits())) known.push_back(std::to_string(device.index));
  if (options.selector == "all") return known;
  for (const std::string& device : split(options.selector, ',')) {
    const bool index = std::all_of(device.begin(), device.end(), [](unsigned char c) { return std::isdigit(c); });
    if (index && std::find(known.begin(), known.end(), device) == known.end())
      throw_error(ErrorClass::usage, "--devices {}: there is no device '{}'; `lucarium devices` lists {}",
                  options.selector, device, counted(known.size(), "device"));
    if (std::find(chosen.begin(), chosen.end(), device) != chosen.end())
      throw_error(ErrorClass::usage, "--devices {}: device {} is named twice", options.selector, device);
    chosen.push_back(device);
  }
  return chosen;
}

std::vector<std::string> DeviceArguments::in_comparison() const {
  return write_device_arguments(names_several(options.selector) ? "" : options.selector, options.threads, memory_limit,
                                allocation_limit);
}

void DeviceArguments::apply_to(ComparisonOptions& comparison, const std::vector<fs::path>& technique_folders) const {
  comparison.program = fs::read_symlink("/proc/self/exe");
  comparison.cache_dir = resolve_cache_dir(limits());  // which refuses wrong limits, before anything is replaced
  comparison.use_cache = !no_cache;
  for (const fs::path& folder : technique_folders) comparison.technique_folders.push_back(fs::absolute(folder));
  // They go into the jobs of a comparison, which are JSON: refused before its references are rendered.
  std::vector<fs::path> named = comparison.technique_folders;
  named.insert(named.end(), {comparison.program, comparison.cache_dir});
  if (!comparison.folder.empty()) named.push_back(fs::absolute(comparison.folder));
  for (const fs::path& path : named) {
    if (!is_utf8(path.string()))
      throw_error(ErrorClass::usage, "'{}' is not UTF-8; give the folder another name", path.string());
  }
}

void SceneArguments::add_to(Command command) {
  command.option("--camera", overrides.camera).default_text("the first");
  command.option("--camera-path", overrides.camera_path).default_text("the scene's");
  command.excludes({"--camera"}, {"--camera-path"});
  command.option("--environment", overrides.environment).default_text("the scene's");
  command.option("--light", overrides.lights).repeatable().default_text("the scene's");
  command.option("--material", overrides.materials).repeatable().default_text("the scene's");
  command.flag("--no-sidecar", no_sidecar);
  command.option("--texture-size", import.max_texture_size)
      .check(in_range(1, largest_texture_size))
      .capture_default_str();
  command.option("--at", overrides.at_seconds).check(finite_number()).default_text("0");
  command.option("--animation", overrides.animation).default_text("the first");
}

void SceneArguments::add_exposure_to(Command command) {
  command.option_function("--exposure", [this](const std::string& text) { overrides.exposure = parse_exposure(text); })
      .default_text("auto");
}

void SceneArguments::take(const Job& job) {
  overrides = job.overrides;
  import = job.import;
  no_sidecar = !job.overrides.use_sidecar;
}

SceneOverrides SceneArguments::resolved() const {
  SceneOverrides result = overrides;
  result.use_sidecar = !no_sidecar;
  return result;
}

Scene SceneArguments::load(const std::string& source) const {
  if (no_sidecar && source.starts_with("builtin:"))
    throw_error(ErrorClass::usage, "--no-sidecar does nothing: {} has no sidecar", source);
  return load_scene(source, resolved(), import);
}

void ImageArguments::add_to(Command command, bool with_seed) {
  command.option("--size", size).capture_default_str();
  command.option("--max-bounces", max_bounces).check(in_range(-1, PathSet::kMaxBounces)).capture_default_str();
  command.option("--pixel-sampling", pixel_sampling).capture_default_str();
  if (with_seed) command.option("--seed", seed).check(whole_number(0)).capture_default_str();
}

RenderSettings ImageArguments::settings() const {
  RenderSettings result;
  std::tie(result.width, result.height) = parse_size(size);
  result.max_bounces = max_bounces;
  result.seed = seed;
  if (pixel_sampling == "jitter") {
    result.pixel_sampling = 0;
  } else if (american_spelling(pixel_sampling) == "center") {
    result.pixel_sampling = 1;
  } else {
    const std::optional<uint32_t> grid = parse_uint(pixel_sampling);
    if (!grid || *grid < 2 || *grid > finest_pixel_grid) {
      throw_error(ErrorClass::usage, "--pixel-sampling: '{}' is not jitter, center, or n from 2 to {}", pixel_sampling,
                  finest_pixel_grid);
    }
    result.pixel_sampling = *grid;
  }
  return result;
}

TechniqueArguments::Spec TechniqueArguments::parse(const std::string& text) {
  const size_t colon = text.find(':');
  Spec spec{text.substr(0, colon), {}};
  if (spec.name.empty()) throw_error(ErrorClass::usage, "'{}' names no technique", text);
  if (colon != std::string::npos) spec.parameters = parse_parameters(text.substr(colon + 1));
  return spec;
}

TechniqueArguments::Parameters TechniqueArguments::parse_parameters(const std::string& text) {
  Parameters parameters;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    parameters.push_back(parse_assignment(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parameters;
}

TechniqueArguments::Spec TechniqueArguments::single(const std::string& command, const std::string& otherwise) const {
  if (specs.empty()) return {otherwise, leading};
  if (specs.size() > 1)
    throw_error(ErrorClass::usage, "{} takes one -t; to compare several use lucarium compare", command);
  return all().front();
}

const std::vector<TechniqueArguments::Spec>& TechniqueArguments::all() const {
  if (!leading.empty()) {
    const std::string text = leading.front().first + "=" + leading.front().second;
    throw_error(ErrorClass::usage, "-p {}: name the technique it belongs to first, as in -t path_tracing -p {}", text,
                text);
  }
  return specs;
}

void TechniqueArguments::add_to(Command command, const std::string& default_technique, bool several) {
  Option technique =
      command.option_function("--technique", [this](const std::string& text) { specs.push_back(parse(text)); })
          .trigger_on_parse()
          .default_text(default_technique);
  if (several) technique.repeatable();
  command
      .option_function("--parameter",
                       [this](const std::string& text) {
                         Parameters& all = specs.empty() ? leading : specs.back().parameters;
                         for (auto& parameter : parse_parameters(text)) all.push_back(std::move(parameter));
                       })
      .trigger_on_parse()
      .repeatable()
      .default_text("the technique's");
  add_technique_path(command, folders);
}

std::unique_ptr<Technique> make_technique(const TechniqueType& type, const TechniqueArguments::Spec& spec) {
  std::unique_ptr<Technique> technique = type.create();
  try {
    technique->parameters().set_all(spec.parameters);
  } catch (const Error& error) {
    throw error.with_context(type.info().name);
  }
  return technique;
}

void RenderingArguments::take(const Job& job) {
  scene = job.scene;
  device.take(job.device);
  overrides.take(job);
  settings.width = job.width;
  settings.height = job.height;
  settings.max_bounces = job.max_bounces;
  settings.pixel_sampling = job.pixel_sampling;
  settings.seed = job.seed;
  technique.folders = job.technique_folders;
}

Scene RenderingArguments::load(const Technique* technique) const {
  Scene loaded = overrides.load(scene);
  RenderSettings seen = settings;
  seen.camera = loaded.cameras.front();
  if (!technique || technique->path_set(loaded, seen).light_transport()) require_light(loaded);
  for (const std::string& warning : loaded.warnings) log_warning("{}", warning);
  return loaded;
}

std::pair<uint32_t, uint32_t> parse_size(const std::string& text) {
  const std::string_view view = text;
  const size_t x = std::min(view.find('x'), view.size());
  const uint32_t width = parse_uint(view.substr(0, x)).value_or(0),
                 height = x < view.size() ? parse_uint(view.substr(x + 1)).value_or(0) : 0;
  const auto fits = [](uint32_t side) { return side > 0 && side <= largest_image_side; };
  if (!fits(width) || !fits(height)) {
    throw_error(ErrorClass::usage, "--size: '{}' is not WIDTHxHEIGHT, each from 1 to {} pixels", text,
                largest_image_side);
  }
  return {width, height};
}

}  // namespace lucarium::app
