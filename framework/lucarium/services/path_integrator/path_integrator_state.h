// SPDX-License-Identifier: Apache-2.0
// The inside of PathIntegrator, shared by path_integrator.cpp (what happens when), path_schedules.cpp (which passes)
// and path_film.cpp (what comes out).
#pragma once
#include "lucarium/services/path_integrator/path_integrator.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/shared/path_settings.h"
#include "lucarium/shared/ray.h"

namespace lucarium {

/// How an iteration is cut into batches: whole samples of all pixels where they fit, else ranges of pixels.
struct BatchPlan {
  uint32_t pixels = 0;  ///< of the image
  uint32_t pixels_per_batch = 0;
  uint32_t samples_per_batch = 0;
  uint32_t samples = 0;  ///< of one iteration
  uint32_t paths() const { return pixels_per_batch * samples_per_batch; }
  bool single_batch() const { return pixels == pixels_per_batch && samples == samples_per_batch; }
};
BatchPlan plan_batches(uint32_t width, uint32_t height, const PathIntegratorOptions& options);

/// State of the paths of one batch, one entry per path (rays and hits: per active path).
struct PathBuffers {
  TypedBuffer<Ray> rays;
  TypedBuffer<RayEnds> ends;       ///< of the rays; empty where the intersector wants none
  TypedBuffer<uint32_t> queue;     ///< path of ray i
  TypedBuffer<uint32_t> active;    ///< one element: rays in the queue
  TypedBuffer<float4> throughput;  ///< xyz; w: pdf of the last BSDF sample [1/sr]
  TypedBuffer<PathState> state;
  TypedBuffer<uint32_t> side;    ///< LitPoint::side of the last vertex (light_tree.clh)
  TypedBuffer<float4> radiance;  ///< LUCARIUM_PATH_LAYERS × paths
};

/// What has been rendered. Sums are compensated: element 2i is the sum, 2i + 1 what rounding lost.
struct PathSums {
  TypedBuffer<float4> layers;                   ///< LUCARIUM_PATH_LAYERS × pixels × 2
  std::vector<TypedBuffer<float4>> replicates;  ///< image of each replicate, pixels × 2; empty with one replicate
  TypedBuffer<uint32_t> shadow_rays;            ///< per pixel
  TypedBuffer<uint32_t> counts;                 ///< LUCARIUM_PATH_COUNTS
  std::vector<Buffer> all() const;
};

struct PathIntegrator::State {
  State(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
        const Frame& frame, const PathIntegratorOptions& options, const std::string& owner);

  /// Settings of the kernels, from the options and the contents of the scene.
  PathSettings make_settings() const;
  /// Fills the light table and trees of the path set, where the scene's own do not serve it.
  void make_light_table();
  bool samples_lights() const;  ///< whether there may be shadow rays
  void allocate();
  void record_generate();
  void record_bounce();
  void record_finish();
  void bind_scene(PassBuilder& pass) const;

  bool run_batch(const PathBatch& batch);
  /// False when cancelled.
  bool run_batches();
  void clear();
  void copy_sums(const PathSums& from, const PathSums& to);

  Device& device;
  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  const Intersector& intersector;
  Frame frame;
  PathIntegratorOptions options;
  std::string owner;
  BatchPlan plan;
  PathSettings settings{};

  Program program;
  Primitives primitives;
  TypedBuffer<AliasEntry> light_table;  ///< empty: the scene's own
  TypedBuffer<uint> light_trees;        ///< likewise
  PathBuffers paths;
  PathSums sums, backup;  ///< backup: of the last whole iteration, where a cancelled one could leave traces

  Schedule generate, bounce, finish;
  Variable<Frame> generate_frame;
  Variable<PathBatch> generate_batch, bounce_batch, finish_batch;
  Variable<PathSettings> generate_settings, bounce_settings, finish_settings;

  uint32_t active = 0;     ///< read back after every bounce
  uint32_t nonfinite = 0;  ///< read back after every batch
  uint64_t samples = 0, closest_rays = 0;
};

}  // namespace lucarium
