// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/reference/reference_identity.h"

#include <cstdlib>

#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/hash.h"
#include "lucarium/version.h"

const lucarium::EmbeddedSources& lucarium_kernels();

namespace lucarium {
namespace {

/// What renders references: a changed kernel or plug-in must not be measured against the truth of the old one.
std::string describe_renderer(const TechniqueRegistry& registry) {
  Hasher hasher;
  for (const auto& [name, text] : lucarium_kernels()) hasher.add(name).add(text);
  hasher.add(read_file(registry.find("path_tracing").file()));
  const char* override_path = std::getenv("LUCARIUM_KERNEL_PATH");
  return fmt::format("path_tracing {} {}{}{}", LUCARIUM_VERSION, hasher.finish().hex(), override_path ? " " : "",
                     override_path ? override_path : "");
}

}  // namespace

ReferenceIdentity::ReferenceIdentity(const Scene& scene, const RenderSettings& settings, const PathSet& path_set,
                                     const TechniqueRegistry& registry)
    : entries_{{"scene_hash", scene.hash().hex()},
               {"camera", describe_camera(settings.camera)},
               {"path_set", path_set.to_string()},
               {"size", fmt::format("{}x{}", settings.width, settings.height)},
               {"pixel_sampling", std::to_string(settings.pixel_sampling)},
               {"seed", std::to_string(settings.seed)},
               {"renderer", describe_renderer(registry)}} {}

std::string ReferenceIdentity::hash() const {
  Hasher hasher;
  for (const auto& [key, value] : entries_) hasher.add(key).add(value);
  return hasher.finish().hex();
}

void ReferenceIdentity::write_to(std::map<std::string, std::string>& metadata) const {
  for (const auto& [key, value] : entries_) metadata[key] = value;
  metadata["identity"] = hash();
}

std::vector<std::string> ReferenceIdentity::differences(const Film& film) const {
  std::vector<std::string> lines;
  for (const auto& [key, value] : entries_) {
    const auto found = film.metadata.find(key);
    const std::string theirs = found == film.metadata.end() ? "nothing" : found->second;
    if (theirs == value) continue;
    if (key == "path_set" && found != film.metadata.end()) {
      for (const std::string& line : PathSet::parse(theirs).differences(PathSet::parse(value))) lines.push_back(line);
    } else if (key == "scene_hash") {
      lines.push_back("another scene, or another version of it");
    } else if (key == "renderer") {
      lines.push_back("rendered by another version of Lucarium");
    } else if (key == "camera") {
      lines.push_back("another camera");
    } else {
      lines.push_back(fmt::format("{}: {} against {}", key, theirs, value));
    }
  }
  return lines;
}

std::string describe_camera(const SceneCamera& camera) {
  std::string text = fmt::format("{} {} {} {}", camera.perspective, camera.yfov, camera.xmag, camera.ymag);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) text += fmt::format(" {}", camera.world_from_camera[column][row]);
  }
  return text;
}

}  // namespace lucarium
