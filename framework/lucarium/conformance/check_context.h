// SPDX-License-Identifier: Apache-2.0
// What the checks share: sessions of the technique under test on small images, and how their results are compared.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/conformance/conformance.h"
#include "lucarium/session/session.h"

namespace lucarium::check {

/// Family-wise chance that a statistical check fails a technique that is right.
inline constexpr double level = 1e-3;
/// Float arithmetic, relative, that no test counts as an error.
inline constexpr double rounding = 2e-4;
/// Independent seeds of statistical checks; fewer, at least `min_seeds`, where a technique that admits a bias is within
/// it whatever the noise has done. Whoever is near the bound takes all of them.
inline constexpr size_t seeds = 8, min_seeds = 3;
/// Pixels of a side of the pictures that are compared.
inline constexpr uint32_t picture_side = 32;
/// Noise above this part of the expected value shows too little to call a check passed.
inline constexpr double largest_noise = 0.05;

struct Outcome {
  Verdict verdict = Verdict::passed;
  std::string measured;
};
inline Outcome verdict_of(bool passed, std::string measured) {
  return {passed ? Verdict::passed : Verdict::failed, std::move(measured)};
}

/// All layers of a film: what "the same image, bit for bit" is about.
using Picture = std::map<std::string, std::vector<float>>;
Picture picture_of(const Film& film);
/// Empty when all bits are the same, else which layer differs, in how many values and by how much at most.
std::string difference(const Picture& a, const Picture& b);

struct CheckContext {
  std::shared_ptr<Device> device;
  const TechniqueRegistry& registry;
  const TechniqueType& type;
  const ConformanceOptions& options;
  /// Instead of those of the options, where Oclgrind interprets.
  std::vector<std::pair<std::string, std::string>> oclgrind_parameters;
  PathSet path_set;  ///< of the technique on the furnace, with these parameters
  double bias = 0;   ///< that it admits with these parameters
  /// Of comparisons with the reference: two names in the list may stand for the same one.
  std::map<std::pair<MaterialKind, LightKind>, Outcome> compared = {};

  static constexpr uint64_t longest_lead = 64;  ///< iterations before the first sample

  const Capabilities& can() const { return type.info().capabilities; }
  bool claims(LightKind kind) const;
  bool claims(MaterialKind kind) const;
  bool claims(ChangeKind kind) const;
  bool holds_sampling(uint32_t mode) const;
  /// A kind of light of the technique's: emissive before environment before punctual ones; environment if it has none.
  LightKind any_light() const;

  /// 32×32, three bounces where the technique can, its first pixel sampling, seed 1, the scene's first camera.
  RenderSettings settings(const Scene& scene) const;
  RenderSession session(const Scene& scene) const;
  RenderSession session(const Scene& scene, const RenderSettings& settings) const;
  /// The scene in which repeatability, changes and limits are looked at, with light that the technique claims.
  Scene plain_scene() const;

  /// Iterates until converged, else 64 samples or iterations, more where no sample counts before all light is there: no
  /// time, so that a loaded machine changes no verdict.
  void run_long(RenderSession& session) const;
  /// A few iterations once there is progress, the same number every time.
  Picture run_short(RenderSession& session, uint64_t iterations = 3) const;
  Picture picture(RenderSession& session) const { return picture_of(session.resolve()); }
};

}  // namespace lucarium::check
