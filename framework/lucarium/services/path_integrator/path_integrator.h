// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/film/film.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/path_set.h"

namespace lucarium {

enum class PathSampler { sobol, random };
/// How light from emissive triangles and the environment is found: light samples and BSDF hits joined by the power
/// heuristic (`mis`) or the balance heuristic, or one of them alone. Punctual lights are always sampled.
enum class PathEstimator { mis, mis_balance, nee_only, bsdf_only };

struct PathIntegratorOptions {
  PathSet path_set;
  PathEstimator estimator = PathEstimator::mis;
  PathSampler sampler = PathSampler::sobol;
  LightChoice light_choice = LightChoice::tree;
  bool roulette = true;                ///< Russian roulette
  int roulette_start = 2;              ///< counted scatterings before Russian roulette may end a path
  uint32_t replicates = 1;             ///< independently scrambled sample sets per pixel; error comes from their spread
  uint32_t batch_paths = 1u << 20;     ///< most paths in flight
  uint32_t samples_per_iteration = 1;  ///< per pixel
};

/// Wavefront path tracer (Laine, Karras, Aila 2013) over any Intersector (docs/techniques/path_tracing.md). An
/// iteration is made of batches: whole samples of all pixels where they fit into batch_paths, else ranges of pixels. A
/// batch runs three recorded schedules:
///
///   generate  generate_camera_paths                       rays, throughput 1, layer sums 0
///   bounce    closest hit        Intersector              rays -> hits
///     ^       shade_surface      emission with MIS, light sample, BSDF sample, roulette
///     |       shadow rays        Intersector (any hit)
///     |       add_unoccluded_light
///     |       compact paths      Primitives               the paths that go on, in their order
///     +------ advance_paths, and the number of paths left is read back
///   finish    accumulate_layers, accumulate_replicate     paths -> pixels, in sample order
///
/// Deterministic: every path owns its sums, and a pixel's paths are added in sample order, with Neumaier's compensated
/// sum. No ray is traced that can bring nothing: no shadow ray for a black or delta surface or a layer that is not
/// wanted, no last segment where nothing that it could hit emits.
///
/// A cancelled iteration leaves no trace: the last schedule of a batch runs to its end once begun, and where an
/// iteration has several batches the sums are copied before it and copied back.
class PathIntegrator {
 public:
  /// `path_set.max_bounces` is the limit; the frame's is not read.
  PathIntegrator(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                 const Frame& frame, const PathIntegratorOptions& options, const std::string& owner);
  ~PathIntegrator();

  /// Adds samples_per_iteration samples to every pixel. Returns false when cancelled midway: the iteration is then
  /// discarded as a whole. Throws Error{technique} when a sample is NaN, infinite or negative.
  bool iterate();
  /// Starts again from zero samples.
  void reset(uint64_t seed);
  /// The same with another camera; image size and seed stay.
  void set_frame(const Frame& frame);
  /// The same after another change of the scene, geometry, materials, lights, environment: once SceneBuffers and the
  /// intersector have followed it, and only while their generations stay. Nothing is compiled or allocated; the frame
  /// stays.
  void follow_scene();
  void warm_up();

  uint64_t samples() const;  ///< per pixel
  /// Layers emission, direct, indirect; with replicates > 1 also "Variance" (of the mean, per channel).
  void resolve(Film& film) const;
  /// Image of each replicate, 3 floats per pixel; empty with one replicate. Their spread is the error of the mean.
  std::vector<std::vector<float>> replicate_images() const;
  /// paths, closest_rays, shadow_rays, nonfinite, terminated_by_cap, terminated_in_mirrors.
  std::map<std::string, double> counters() const;
  /// `ray_ends`: over an intersector that wants them.
  static size_t estimate_bytes(uint32_t width, uint32_t height, const PathIntegratorOptions& options,
                               bool ray_ends = false);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lucarium
