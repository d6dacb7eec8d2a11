// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include <charconv>

#include "lucarium/base/byte_size.h"
#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/base/request_limits.h"
#include "lucarium/compare/request/device_arguments.h"
#include "lucarium/compute/device/cache_folder.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/services/path_set.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

uint32_t parse_uint(const std::string& text, const std::string& whole, const std::string& what) {
  uint32_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size())
    throw_error(ErrorClass::usage, "'{}' is not {}", whole, what);
  return value;
}

std::pair<std::string, std::string> parse_assignment(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw_error(ErrorClass::usage, "'{}' is not key=value", text);
  return {text.substr(0, equals), text.substr(equals + 1)};
}

}  // namespace

void add_technique_path(Command command, std::vector<std::filesystem::path>& folders) {
  command.add_option("--technique-path", folders, "folder of plug-ins, searched first; may be given several times")
      ->check(existing_folder())
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

void DeviceArguments::add_to(Command command) {
  command.add_option("--device", options.selector,
                     "index, part of a name, or cpu|gpu|accelerator (see lucarium devices)");
  command.add_option("--threads", options.threads, "worker threads of a CPU device; 0: all")
      ->check(in_range(0, max_threads));
  command.add_option("--cache-dir", options.cache_dir, "folder of compiled kernels and references");
  command.add_flag("--no-cache", no_cache, "compile every kernel again");
  command.add_option("--memory-limit", memory_limit, "most device memory to use, as 500M or 2G");
  command.add_option("--allocation-limit", allocation_limit, "most device memory of one buffer");
}

void DeviceArguments::take(const DeviceOptions& given) {
  options = given;
  no_cache = !given.use_cache;
}

DeviceOptions DeviceArguments::resolved() const {
  DeviceOptions result = options;
  result.use_cache = !no_cache;
  if (!memory_limit.empty()) result.memory_limit_bytes = parse_bytes(memory_limit, "--memory-limit");
  if (!allocation_limit.empty()) result.allocation_limit_bytes = parse_bytes(allocation_limit, "--allocation-limit");
  return result;
}

std::vector<std::string> DeviceArguments::in_comparison() const {
  return write_device_arguments(options.selector, options.threads, memory_limit, allocation_limit);
}

void DeviceArguments::apply_to(ComparisonOptions& comparison, const std::vector<fs::path>& technique_folders) const {
  comparison.program = fs::read_symlink("/proc/self/exe");
  comparison.cache_dir = resolve_cache_dir(resolved());  // which refuses wrong limits, before anything is replaced
  comparison.use_cache = !no_cache;
  for (const fs::path& folder : technique_folders) comparison.technique_folders.push_back(fs::absolute(folder));
}

void SceneArguments::add_to(Command command) {
  command.add_option("--camera", overrides.camera, "NAME, INDEX, or EYE:TARGET[:VFOV] as x,y,z:x,y,z:degrees");
  command.add_option("--environment", overrides.environment,
                     "equirectangular .hdr/.exr, or r,g,b; *FACTOR and @DEGREES may follow");
  command
      .add_option("--light", overrides.lights,
                  "point:x,y,z:r,g,b, spot:…, directional:dx,dy,dz:r,g,b, or none (docs/scenes.md)")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option_function(
      "--exposure", [this](const std::string& text) { overrides.exposure = parse_exposure(text); },
      "of pictures (.png) [stops], or auto (default): chosen from the image");
  command.add_option("--material", overrides.materials, "NAME:key=value[,…]; NAME may hold *")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_option("--at", overrides.at_seconds, "time of the animation [s]")->check(finite_number());
  command.add_option("--animation", overrides.animation, "name or index");
  command.add_flag("--no-sidecar", no_sidecar, "ignore FILE.lucarium.json beside the scene");
  command.add_option("--texture-size", import.max_texture_size, "larger textures are halved until they fit [pixels]")
      ->check(in_range(1u, largest_texture_size));
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

Scene SceneArguments::load(const std::string& source) const { return load_scene(source, resolved(), import); }

void ImageArguments::add_to(Command command, bool with_seed) {
  command.add_option("--size", size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  command.add_option("--max-bounces", max_bounces, "indirect bounces; 0: direct light only, -1: unlimited")
      ->check(in_range(-1, PathSet::kMaxBounces))
      ->capture_default_str();
  command.add_option("--pixel-sampling", pixel_sampling, "jitter, centre, or n for a grid of n×n")
      ->capture_default_str();
  if (with_seed)
    command.add_option("--seed", seed, "same seed, same image")->check(whole_number(0))->capture_default_str();
}

RenderSettings ImageArguments::settings() const {
  RenderSettings result;
  std::tie(result.width, result.height) = parse_size(size);
  result.max_bounces = max_bounces;
  result.seed = seed;
  if (pixel_sampling == "jitter") {
    result.pixel_sampling = 0;
  } else if (pixel_sampling == "centre") {
    result.pixel_sampling = 1;
  } else {
    const std::string modes = fmt::format("jitter, centre, or n from 2 to {}", finest_pixel_grid);
    result.pixel_sampling = parse_uint(pixel_sampling, pixel_sampling, "a pixel sampling: " + modes);
    if (result.pixel_sampling < 2 || result.pixel_sampling > finest_pixel_grid)
      throw_error(ErrorClass::usage, "--pixel-sampling {} is not {}", pixel_sampling, modes);
  }
  return result;
}

TechniqueArguments::Spec TechniqueArguments::parse(const std::string& text) {
  const size_t colon = text.find(':');
  Spec spec{text.substr(0, colon), {}};
  if (spec.name.empty()) throw_error(ErrorClass::usage, "'{}' names no technique", text);
  for (size_t begin = colon == std::string::npos ? text.size() : colon + 1; begin < text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    spec.parameters.push_back(parse_assignment(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return spec;
}

void TechniqueArguments::add_to(Command command) {
  command
      .add_option_function(
          "-t,--technique", [this](const std::string& text) { specs.push_back(parse(text)); },
          "NAME[:key=value,…] (see lucarium techniques)")
      ->trigger_on_parse()
      ->take_last();
  command
      .add_option_function(
          "-p,--parameter",
          [this](const std::string& text) {
            if (specs.empty())
              throw_error(ErrorClass::usage,
                          "-p {}: name the technique it belongs to first, as in -t path_tracing -p {}", text, text);
            specs.back().parameters.push_back(parse_assignment(text));
          },
          "key=value for the -t before it")
      ->trigger_on_parse()
      ->take_last();
  add_technique_path(command, folders);
}

void check_parameters(const TechniqueType& type, const TechniqueArguments::Spec& spec) {
  const std::unique_ptr<Technique> technique = type.create();
  try {
    technique->parameters().set_all(spec.parameters);
  } catch (const Error& error) {
    throw error.with_context(type.info().name);
  }
}

void OutputArguments::add_to(Command command, bool with_json) {
  if (with_json) command.add_flag("--json", json, "print the result as JSON on standard output");
  command.add_flag("--quiet", quiet, "no progress, no warnings");
  command.add_flag("-v,--verbose", verbose, "details of errors, and what is being done");
}

void OutputArguments::apply() const {
  set_log_level(quiet ? LogLevel::error : verbose ? LogLevel::info : LogLevel::warning);
}

RenderSettings settings_of(const Job& job) {
  RenderSettings settings;
  settings.width = job.width;
  settings.height = job.height;
  settings.max_bounces = job.max_bounces;
  settings.pixel_sampling = job.pixel_sampling;
  settings.seed = job.seed;
  return settings;
}

std::pair<uint32_t, uint32_t> parse_size(const std::string& text) {
  const std::string what = fmt::format("a --size: pixels as WIDTHxHEIGHT, from 1 to {} each", largest_image_side);
  const size_t x = text.find('x');
  if (x == std::string::npos) throw_error(ErrorClass::usage, "'{}' is not {}", text, what);
  const uint32_t width = parse_uint(text.substr(0, x), text, what), height = parse_uint(text.substr(x + 1), text, what);
  if (width == 0 || height == 0 || width > largest_image_side || height > largest_image_side)
    throw_error(ErrorClass::usage, "'{}' is not {}", text, what);
  return {width, height};
}

}  // namespace lucarium::app
