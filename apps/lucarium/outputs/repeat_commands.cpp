// SPDX-License-Identifier: Apache-2.0
#include "outputs/repeat_commands.h"

#include <algorithm>

#include "lucarium/scene/exposure.h"

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
Words scene_words(const SceneArguments& scene) {
  const SceneOverrides& o = scene.overrides;
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

/// The camera that the picture was seen with, as --camera; none where it is the one that the scene begins with.
Words camera_words(const ViewedPicture& picture, const SceneArguments& scene, const std::vector<std::string>& names) {
  Words words;
  if (picture.camera)
    add(words, "--camera", camera_text(*picture.camera));
  else if (picture.scene_camera > 0)
    add(words, "--camera", names.at(std::min<size_t>(picture.scene_camera, names.size() - 1)));
  else if (scene.overrides.camera)
    add(words, "--camera", *scene.overrides.camera);
  else if (scene.overrides.camera_path)
    add(words, "--camera-path", *scene.overrides.camera_path);
  return words;
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

std::function<std::vector<std::pair<std::string, std::string>>(const ViewedPicture&)> repeat_commands(
    const RenderingArguments& arguments, const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneCamera& camera : scene.cameras) names.push_back(camera.name);
  const Words about_scene = scene_words(arguments.overrides), image = image_words(arguments.image),
              device = device_words(arguments);
  const std::string seed = std::to_string(arguments.image.seed);
  return [=, name = arguments.scene, overrides = arguments.overrides](
             const ViewedPicture& picture) -> std::vector<std::pair<std::string, std::string>> {
    const Words camera = camera_words(picture, overrides, names);
    const Words technique = {"-t", technique_word(picture.technique)};
    const Words budget = {"--iterations", std::to_string(std::max<uint64_t>(picture.iterations, 1))};
    return {{"render", line_of({{"render", name},
                                about_scene,
                                camera,
                                image,
                                {"--seed", seed},
                                device,
                                technique,
                                budget,
                                {"-o", "picture.exr"}})}};
  };
}

}  // namespace lucarium::app
