// SPDX-License-Identifier: Apache-2.0
#include "outputs/repeat_commands.h"

#include <algorithm>

#include "lucarium/base/json.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/scene/load/scene_overrides.h"

namespace lucarium::app {

namespace {

using Words = std::vector<std::string>;

void add(Words& words, const std::string& option, const std::string& value) {
  // A value that begins with a sign would be read as an option.
  if (value.starts_with('-')) {
    words.push_back(option + "=" + value);
  } else {
    words.insert(words.end(), {option, value});
  }
}

/// What was said about the scene, without its camera.
Words scene_words(const SceneArguments& scene, const SceneOverrides& o) {
  Words words;
  if (o.environment) add(words, "--environment", *o.environment);
  for (const std::string& light : o.lights) add(words, "--light", light);
  for (const std::string& material : o.materials) add(words, "--material", material);
  if (o.at_seconds) add(words, "--at", fmt::format("{}", *o.at_seconds));
  if (o.animation) add(words, "--animation", *o.animation);
  if (scene.no_sidecar) words.emplace_back("--no-sidecar");
  if (scene.import.max_texture_size != ImportOptions{}.max_texture_size)
    add(words, "--texture-size", fmt::format("{}", scene.import.max_texture_size));
  return words;
}

Words image_words(const ImageArguments& image) {
  Words words;
  add(words, "--size", image.size);
  if (image.max_bounces != ImageArguments{}.max_bounces) add(words, "--max-bounces", std::to_string(image.max_bounces));
  if (image.pixel_sampling != ImageArguments{}.pixel_sampling) add(words, "--pixel-sampling", image.pixel_sampling);
  return words;
}

Words device_words(const RenderingArguments& arguments) {
  Words words;
  if (!arguments.device.options.selector.empty()) add(words, "--device", arguments.device.options.selector);
  for (const auto& folder : arguments.technique.folders) add(words, "--technique-path", folder.string());
  return words;
}

std::string technique_word(const ViewTechnique& technique) {
  std::string word = technique.name;
  for (size_t i = 0; i < technique.parameters.size(); ++i)
    word += fmt::format("{}{}={}", i == 0 ? ":" : ",", technique.parameters[i].first, technique.parameters[i].second);
  return word;
}

/// The camera that the picture was seen with; none where it is the one that the scene begins with.
std::optional<std::string> camera_of(const ViewedPicture& picture, const SceneOverrides& overrides,
                                     const std::vector<std::string>& names) {
  if (picture.camera) return camera_text(*picture.camera);
  if (picture.scene_camera > 0) return names.at(std::min<size_t>(picture.scene_camera, names.size() - 1));
  return overrides.camera;
}

Words camera_words(const std::optional<std::string>& camera, const SceneOverrides& overrides) {
  Words words;
  if (camera)
    add(words, "--camera", *camera);
  else if (overrides.camera_path)
    add(words, "--camera-path", *overrides.camera_path);
  return words;
}

/// The techniques that are seen, the picture's own first.
std::vector<ViewTechnique> techniques_of(const ViewedPicture& picture) {
  std::vector<ViewTechnique> techniques = {picture.technique};
  for (const ViewTechnique& other : picture.others) {
    if (std::find(techniques.begin(), techniques.end(), other) == techniques.end()) techniques.push_back(other);
  }
  return techniques;
}

/// {NAME: {KEY: VALUE}}, as a comparison's file has them.
nlohmann::ordered_json material_values(const std::vector<std::string>& texts) {
  nlohmann::ordered_json values = nlohmann::ordered_json::object();
  for (const std::string& text : texts) {
    const MaterialEdit edit = parse_material(text);
    for (const auto& [key, value] : edit.values) values[edit.pattern][key] = value;
  }
  return values;
}

/// One seed, which is 1, and a small reference: to repeat pictures, errors are measured at no great cost.
const char* const repeated_seeds = "1";
constexpr int repeated_reference = 64;

std::string comparison_file(const ViewedPicture& picture, const RenderingArguments& arguments,
                            const SceneOverrides& overrides, const std::optional<std::string>& camera) {
  const RenderSettings settings = arguments.image.settings();
  nlohmann::ordered_json scene = {{"scene", arguments.scene}};
  if (camera) scene["camera"] = *camera;
  if (!camera && overrides.camera_path) scene["camera_path"] = *overrides.camera_path;
  if (overrides.environment) scene["environment"] = *overrides.environment;
  if (!overrides.lights.empty()) scene["lights"] = overrides.lights;
  if (overrides.at_seconds) scene["at_seconds"] = *overrides.at_seconds;
  if (overrides.animation) scene["animation"] = *overrides.animation;
  if (!overrides.materials.empty()) scene["materials"] = material_values(overrides.materials);
  if (arguments.overrides.no_sidecar) scene["sidecar"] = false;
  if (arguments.overrides.import.max_texture_size != ImportOptions{}.max_texture_size)
    scene["texture_size"] = arguments.overrides.import.max_texture_size;
  nlohmann::ordered_json file = {{"schema", "lucarium-comparison-1"}, {"scenes", {scene}}};
  for (const ViewTechnique& technique : techniques_of(picture)) {
    nlohmann::ordered_json entry = {{"technique", technique.name}};
    for (const auto& [key, value] : technique.parameters) entry["parameters"][key] = value;
    file["techniques"].push_back(std::move(entry));
  }
  file["budgets"] = {{{"iterations", std::max<uint64_t>(picture.iterations, 1)}}};
  file["seeds"] = 1;
  file["size"] = {settings.width, settings.height};
  file["max_bounces"] = settings.max_bounces;
  file["pixel_sampling"] = settings.pixel_sampling;
  file["reference"] = {{"samples", repeated_reference}};
  return file.dump(2) + "\n";
}

std::string line_of(std::initializer_list<Words> parts) {
  std::string line = "lucarium";
  for (const Words& words : parts)
    for (const std::string& word : words) line += " " + shell_word(word);
  return line;
}

}  // namespace

std::string shell_word(const std::string& word) {
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_-+=:,./@%").find(c) != std::string_view::npos;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

RepeatCommands repeat_commands(const RenderingArguments& arguments, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneCamera& camera : scene.cameras) names.push_back(camera.name);
  const Words image = image_words(arguments.image), device = device_words(arguments);
  return [=](const ViewedPicture& picture) -> std::vector<RepeatText> {
    const SceneOverrides overrides = edited_overrides(arguments.overrides.overrides, picture.edits);
    const Words about_scene = scene_words(arguments.overrides, overrides);
    const std::optional<std::string> camera = camera_of(picture, overrides, names);
    const Words seen = camera_words(camera, overrides);
    const Words budget = {"--iterations", std::to_string(std::max<uint64_t>(picture.iterations, 1))};
    Words techniques;
    for (const ViewTechnique& technique : techniques_of(picture)) add(techniques, "-t", technique_word(technique));
    const Words source = {"render", arguments.scene}, compared = {"compare", arguments.scene};
    std::vector<RepeatText> texts = {{"render",
                                      line_of({source,
                                               about_scene,
                                               seen,
                                               image,
                                               {"--seed", std::to_string(arguments.image.seed)},
                                               device,
                                               {"-t", technique_word(picture.technique)},
                                               budget,
                                               {"-o", "picture.exr"}}),
                                      ""}};
    if (std::to_string(arguments.image.seed) == repeated_seeds) {  // the seeds of a comparison begin at 1
      const Words rest = {"--seeds", repeated_seeds, "--reference-spp", std::to_string(repeated_reference),
                          "-o",      "comparison"};
      texts.push_back({"compare", line_of({compared, about_scene, seen, image, device, techniques, budget, rest}), ""});
      texts.push_back(
          {"compare --comparison", comparison_file(picture, arguments, overrides, camera), "comparison.json"});
    }
    if (picture.edits.any())
      texts.push_back({"beside the scene", sidecar_text(picture.edits, camera.value_or("")),
                       std::filesystem::path(arguments.scene).filename().string() + ".lucarium.json"});
    return texts;
  };
}

SceneOverrides edited_overrides(SceneOverrides overrides, const SceneEdits& edits) {
  for (const std::string& light : light_words(edits)) overrides.lights.push_back(light);
  overrides.materials.insert(overrides.materials.end(), edits.materials.begin(), edits.materials.end());
  if (!edits.environment.empty()) overrides.environment = edits.environment;
  if (edits.seconds) overrides.at_seconds = edits.seconds;
  return overrides;
}

}  // namespace lucarium::app
