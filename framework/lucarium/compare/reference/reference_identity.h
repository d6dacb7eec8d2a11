// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/film/film.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

/// Everything a rendered reference depends on, except how many samples it has. Written into its header; its hash is its
/// name in the cache.
class ReferenceIdentity {
 public:
  /// `registry` finds path_tracing, which renders; the size and so on come from `settings`.
  ReferenceIdentity(const Scene& scene, const RenderSettings& settings, const PathSet& path_set,
                    const TechniqueRegistry& registry);

  std::string hash() const;
  /// (key, value) of the header.
  const std::vector<std::pair<std::string, std::string>>& entries() const { return entries_; }
  /// The entries, and their hash as `identity`.
  void write_to(std::map<std::string, std::string>& metadata) const;
  /// Differences of the film's header from this ("path_set: … against …"); empty: the same image.
  std::vector<std::string> differences(const Film& film) const;

 private:
  std::vector<std::pair<std::string, std::string>> entries_;
};

/// Text of everything in a camera that changes an image.
std::string describe_camera(const SceneCamera& camera);

}  // namespace lucarium
