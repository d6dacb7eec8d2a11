// SPDX-License-Identifier: Apache-2.0
#include "lucarium/session/memory_needs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "lucarium/base/error.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium {

size_t needed_bytes(const TechniqueInfo& info, const Technique& technique, const Scene& scene,
                    const RenderSettings& settings) {
  const size_t bvh = info.capabilities.uses_bvh ? Bvh::estimate_bytes(scene) : 0;
  return SceneBuffers::estimate_bytes(scene) + bvh + technique.estimate_bytes(scene, settings);
}

std::string memory_hint(Technique& technique, const Scene& scene, const RenderSettings& settings) {
  constexpr double min_saving = 0.1;
  constexpr size_t max_named = 4;
  const auto bytes = static_cast<double>(technique.estimate_bytes(scene, settings));
  std::vector<std::pair<double, std::string>> savings;  // bytes, name and present value
  for (const ParameterTable::Entry& entry : technique.parameters().entries()) {
    if (entry.info.type != "int") continue;
    const std::string value = entry.get();
    const long number = std::stol(value);
    for (const long less : {number / 2, number - 1, 1L}) {
      double saved = 0;
      try {
        entry.set(std::to_string(less));
        saved = bytes - static_cast<double>(technique.estimate_bytes(scene, settings));
      } catch (const Error&) {  // no value that it takes
      }
      entry.set(value);
      if (saved < min_saving * bytes) continue;
      // Where 1 takes less than 0, 0 stands for a value that the technique chooses.
      const char* const note = number == 0 && less == 1 ? ": automatic" : "";
      savings.emplace_back(saved, fmt::format("{} ({}{})", entry.info.name, value, note));
      break;
    }
  }
  std::sort(savings.rbegin(), savings.rend());
  savings.resize(std::min(savings.size(), max_named));
  std::string hint = "lower --size or --texture-size";
  for (const auto& [saved, parameter] : savings) hint += fmt::format(", {}", parameter);
  return hint;
}

}  // namespace lucarium
