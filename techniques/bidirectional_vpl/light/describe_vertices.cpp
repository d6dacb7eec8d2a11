// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/light/describe_vertices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/constants.hpp>

#include "lucarium/base/luminance.h"

namespace lucarium::bidirectional {

namespace {

constexpr size_t kLookedAt = 1 << 18;  // slots, 32 MiB: what is read within a moment
constexpr size_t kRead = 1 << 14;      // slots at a time
constexpr size_t kNamed = 3;           // the strongest ones

/// A light vertex, seen from the point.
struct SeenVertex {
  float illuminance = 0;  // that it brings if nothing is between [lx]
  float reflected = 0;    // [lm]
  float distance = 0;     // [m]
  uint32_t number = 0;    // on its path, from 1
  glm::vec3 position{0};
};

glm::vec3 vector_of(const float4& v) { return {v.x, v.y, v.z}; }

uint32_t bits_of(float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// As list_candidates() has its power, and candidate_targets() its geometry, of a Lambert surface.
SeenVertex seen_vertex(const PathVertex& vertex, const SeenPoint& point) {
  SeenVertex seen;
  seen.number = bits_of(vertex.view.w) >> PATH_VERTEX_NUMBER_SHIFT;
  seen.position = vector_of(vertex.position);
  const float share = luminance(vertex.diffuse.x + vertex.f0.x + vertex.transmission.x,
                                vertex.diffuse.y + vertex.f0.y + vertex.transmission.y,
                                vertex.diffuse.z + vertex.f0.z + vertex.transmission.z);
  const float flux = luminance(vertex.flux.x, vertex.flux.y, vertex.flux.z);
  seen.reflected = flux * share * std::abs(glm::dot(vector_of(vertex.shading), vector_of(vertex.view)));
  const glm::vec3 between = seen.position - point.position;
  seen.distance = glm::length(between);
  if (!(seen.distance > 0)) return seen;
  const glm::vec3 towards = between / seen.distance;
  const bool transmits = vertex.transmission.x + vertex.transmission.y + vertex.transmission.z > 0;
  const float there = -glm::dot(towards, vector_of(vertex.normal));
  const float geometry =
      std::max(glm::dot(towards, point.normal), 0.f) * (transmits ? std::abs(there) : std::max(there, 0.f));
  seen.illuminance = seen.reflected * geometry / (glm::pi<float>() * seen.distance * seen.distance);
  return seen;
}

}  // namespace

InspectedValues describe_vertices(const LightVertices& vertices, const Plan& plan, const SeenPoint& point) {
  const size_t per_path = plan.light_vertices;
  const bool own = plan.choice == VplChoice::own;
  const size_t first = own ? (size_t{point.y} * plan.settings.width + point.x) * per_path : 0;
  const size_t looked_at = own ? 1 : std::min<size_t>(plan.settings.light_paths, kLookedAt / per_path);  // light paths
  const size_t end = std::min(first + looked_at * per_path, vertices.vertices().count());

  size_t there = 0, facing = 0;
  double illuminance = 0;
  std::vector<SeenVertex> strongest;
  for (size_t at = first; at < end; at += kRead) {
    for (const PathVertex& vertex : vertices.vertices().download(at, std::min(kRead, end - at))) {
      const SeenVertex seen = seen_vertex(vertex, point);
      if (seen.number == 0) continue;  // the path has ended before
      ++there;
      if (!(seen.illuminance > 0)) continue;
      ++facing;
      illuminance += static_cast<double>(seen.illuminance);
      const auto place = std::find_if(strongest.begin(), strongest.end(),
                                      [&](const SeenVertex& other) { return other.illuminance < seen.illuminance; });
      strongest.insert(place, seen);
      if (strongest.size() > kNamed) strongest.pop_back();
    }
  }
  // Fluxes are shares of all light paths'.
  illuminance *= static_cast<double>(plan.settings.light_paths) / static_cast<double>(looked_at);

  const std::string of = own                                     ? "its light path"
                         : looked_at < plan.settings.light_paths ? fmt::format("the first {} light paths", looked_at)
                                                                 : fmt::format("{} light paths", looked_at);
  InspectedValues rows = {{"light vertices", fmt::format("{} of {}, {} towards this point", there, of, facing)},
                          {"they bring at most", fmt::format("{:.4g} lx, if nothing is between", illuminance)}};
  for (size_t k = 0; k < strongest.size(); ++k) {
    const SeenVertex& seen = strongest[k];
    rows.emplace_back(
        k == 0 ? "the strongest" : fmt::format("number {}", k + 1),
        fmt::format("vertex {} of its path, at {:.4g}, {:.4g}, {:.4g} m, {:.4g} m away: reflects {:.4g} lm, brings "
                    "{:.4g} lx",
                    seen.number, seen.position.x, seen.position.y, seen.position.z, seen.distance, seen.reflected,
                    seen.illuminance));
  }
  return rows;
}

InspectedValues describe_weights(const Plan& plan) {
  const BidirectionalSettings& s = plan.settings;
  std::string text;
  const auto add = [&](const char* name, float samples) {
    if (samples > 0) text += fmt::format("{}{} {:.4g}", text.empty() ? "" : ", ", name, samples);
  };
  add("hit", s.hit_samples);
  add("nee", s.light_samples);
  add("each vpl", s.connection_samples);
  add("splat", s.splat_samples);
  return {{"samples in the weights", text + (plan.beta == 2 ? "; power heuristic" : "; balance heuristic")}};
}

}  // namespace lucarium::bidirectional
