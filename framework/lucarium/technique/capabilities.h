// SPDX-License-Identifier: Apache-2.0
// What a technique can do, and the words for it in reports, checks and messages.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

enum class LightKind { point, spot, directional, emissive, environment };
enum class MaterialKind { diffuse, glossy, mirror, refraction, transmission, mask, blend, normal_map };
enum class ChangeKind { camera, transforms, deformation, materials, lights, topology };

/// The word for each value of a kind, in order: the only table of them.
template <class Kind>
inline constexpr std::array<std::string_view, 0> kind_names;
template <>
inline constexpr std::array<std::string_view, 5> kind_names<LightKind> = {"point", "spot", "directional", "emissive",
                                                                          "environment"};
template <>
inline constexpr std::array<std::string_view, 8> kind_names<MaterialKind> = {
    "diffuse", "glossy", "mirror", "refraction", "transmission", "mask", "blend", "normal_map"};
template <>
inline constexpr std::array<std::string_view, 6> kind_names<ChangeKind> = {"camera",    "transforms", "deformation",
                                                                           "materials", "lights",     "topology"};

template <class Kind>
std::string name_of(Kind kind) {
  return std::string(kind_names<Kind>.at(static_cast<size_t>(kind)));
}

/// Every value of a kind, in order.
template <class Kind>
std::vector<Kind> all_kinds() {
  std::vector<Kind> kinds;
  for (size_t i = 0; i < kind_names<Kind>.size(); ++i) kinds.push_back(static_cast<Kind>(i));
  return kinds;
}

template <class Kind>
std::vector<std::string> names_of(const std::vector<Kind>& kinds) {
  std::vector<std::string> names;
  for (const Kind kind : kinds) names.push_back(name_of(kind));
  return names;
}

/// Can this be done, and if not, what is lost: checked before a run, printed and kept in the report.
struct Capabilities {
  std::vector<LightKind> lights;
  std::vector<MaterialKind> materials;
  std::vector<ChangeKind> changes;  ///< of the scene that update() follows
  int max_bounces = -1;             ///< most it can do; -1: unlimited
  bool progressive = true;          ///< iterations converge; false: one iteration is the result
  bool view_independent = false;    ///< a camera change keeps its data
  bool resizes = false;             ///< another image size may come with one, and keeps what does not depend on it
                                    ///< (RenderSession::set_view)
  bool uses_bvh = true;             ///< may call context.bvh(); if not, none is counted in the memory that is needed
  double bias = 0;                  ///< upper bound of its systematic error: root mean square over 8×8 pixel blocks,
                                    ///< relative to the image's; 0: none. `lucarium check` holds it to that. Where it
                                    ///< depends on parameters, Technique::admitted_bias() says so.
  std::vector<uint32_t> pixel_sampling = {0, 1};  ///< modes supported
};

}  // namespace lucarium
