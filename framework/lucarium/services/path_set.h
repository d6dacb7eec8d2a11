// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

namespace lucarium {

struct Scene;

/// Which light paths a technique with given parameters computes on a given scene; the reference can be rendered with
/// exactly this set (docs/architecture.md, conventions: counting scatterings).
struct PathSet {
  static constexpr int kMaxBounces = 4095;               ///< largest finite max_bounces
  static constexpr int kMaxEyeDeltas = 4095;             ///< largest finite eye_deltas
  int max_bounces = -1;                                  ///< counted scatterings minus one; -1: unlimited
  bool emission = true, direct = true, indirect = true;  ///< layers computed
  bool point_lights = true, spot_lights = true, directional_lights = true, emissive_triangles = true,
       environment = true;  ///< light sources included
  int eye_deltas = -1;      ///< most delta events between the eye and the first non-delta vertex; -1: unlimited
  bool light_delta = true;  ///< delta events after the first counted scattering (light caustics, mirrors inside)
  bool secondary_lambert_only = false;  ///< BSDF at vertices after the first non-delta one keeps only its diffuse lobe
  bool geometric_normals = false;       ///< cosines use n_g instead of n_s
  bool blend = true;                    ///< BLEND crossings are stochastic; false: treated as opaque
  double indirect_clamp = 0;            ///< upper bound of one sample's indirect contribution [cd/m²]; 0: none

  bool operator==(const PathSet&) const = default;
  /// Of a technique whose image is not light (occlusion, depth): nothing to compare with a reference.
  static PathSet no_light_transport() {
    PathSet set;
    set.emission = set.direct = set.indirect = false;
    return set;
  }
  bool light_transport() const { return emission || direct || indirect; }
  /// Canonical text, also the form in which it is recorded and passed to the reference ("max_bounces=2,…").
  std::string to_string() const;
  /// Inverse of to_string(); throws Error{usage} naming the unknown key, or the value out of range.
  static PathSet parse(const std::string& text);
  /// The same as (parameter, value) pairs of `path_tracing`, all keys but max_bounces, which is the framework's.
  std::vector<std::pair<std::string, std::string>> technique_parameters() const;
  /// The simplest set with the same light on this scene: what changes nothing there has its default, so that techniques
  /// that compute the same light share a reference.
  PathSet simplified(const Scene& scene) const;
  /// Human-readable differences, one per entry ("max_bounces: 2 against unlimited").
  std::vector<std::string> differences(const PathSet& other) const;
};

}  // namespace lucarium
