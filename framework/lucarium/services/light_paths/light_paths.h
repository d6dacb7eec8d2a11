// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/scene/device/scene_buffers.h"
#include "lucarium/scene/scene.h"
#include "lucarium/services/intersector.h"
#include "lucarium/services/light_paths/first_rays.h"
#include "lucarium/shared/light_path.h"

namespace lucarium {

struct LightPathOptions {
  uint32_t paths = 1;                    ///< of a run
  uint32_t vertices = 1;                 ///< of a path at most; ideal lobes count
  bool diffuse_only = false;             ///< diffuse lobes alone; a path ends where there is none
  bool opaque_blend = false;             ///< BLEND surfaces count as opaque
  uint32_t kinds = 31;                   ///< which lights, bits 1 << LUCARIUM_LIGHT_*
  uint32_t roulette_start = 0xffffffff;  ///< scatterings before Russian roulette; by default there is none
  bool order = true;                     ///< trace first rays in an order where that pays; off: as paths are numbered
  bool count_rays = false;               ///< fills LightPaths::ray_counts()
  /// Samples of the strategies that programs with LUCARIUM_LIGHT_PATH_MIS weigh (path_mis.clh), 0 where one is not run:
  float hit_samples = 1, light_samples = 1, connection_samples = 1;
  std::string remedy = "use fewer light paths";  ///< said where memory does not suffice
};

/// Paths from all kinds of lights, traced through any Intersector: emission in proportion to the lights' share in the
/// mixture, media, BLEND and MASK, refraction, Russian roulette, adjoint scattering at leaning shading normals.
/// Unbiased with all lobes (docs of the estimator: light_paths.clh). Numbers depend on seed, run and path alone.
///
///   LightPaths paths(device, buffers, bvh, {.paths = 1024, .vertices = 2, .diffuse_only = true}, "my technique");
///   ScheduleRecorder recorder = scheduler.record("light paths", "my technique");
///   const Variable<uint32_t> run = recorder.variable("run", 0u), seed = recorder.variable("seed", 0u);
///   TypedBuffer<VirtualLight> lights(device, "my technique", "virtual lights", paths.virtual_lights(0));
///   paths.record_virtual_lights(recorder, run, seed, lights, 0, true);
///
/// A .cl file of the technique, which includes light_paths.clh, says what else happens at vertices.
class LightPaths {
 public:
  using Bind = std::function<void(PassBuilder&)>;
  /// Records what the first rays of a batch of paths meet, and returns the rays that are traced for it; the others' are
  /// inactive there. `states`: LightPathState.
  using FirstHits =
      std::function<BufferRef(ScheduleRecorder&, const RayBuffers&, const BufferRef& states, const BufferRef& hits)>;

  /// `scene` and `intersector` must outlive this; `owner` pays for the memory.
  LightPaths(Device& device, const SceneBuffers& scene, const Intersector& intersector, const LightPathOptions& options,
             const std::string& owner);

  /// Records one run: all paths from their lights to their last vertices. `program` holds the kernels of
  /// light_paths.clh, compiled with ray_end_defines(); `bind` binds the technique's own arguments of
  /// advance_light_paths, `bind_emission` those of emit_light_paths. Every value of `run` gives other paths.
  /// `first_hits`: in place of the intersector.
  void record(ScheduleRecorder& recorder, const Variable<uint32_t>& run, const Variable<uint32_t>& seed,
              const Program& program, const Bind& bind, const Bind& bind_emission = {},
              const FirstHits& first_hits = {}) const;

  /// Records a run that fills `lights` with the vertices from number `first` on, those of one number after the other;
  /// black where a path has none, or none that is diffuse. `reflected`: what the vertices reflect (virtual lights),
  /// instead of what arrives there (photons). Error{internal} where `first` is more than the vertices of a path, or
  /// `lights` is shorter than virtual_lights(first).
  void record_virtual_lights(ScheduleRecorder& recorder, const Variable<uint32_t>& run, const Variable<uint32_t>& seed,
                             const TypedBuffer<VirtualLight>& lights, uint32_t first, bool reflected) const;
  /// Elements of such a buffer.
  size_t virtual_lights(uint32_t first) const { return size_t{options_.paths} * (options_.vertices - first); }

  /// Two elements: rays that the last run has traced, and those that met nothing. Zero without
  /// LightPathOptions::count_rays.
  const TypedBuffer<uint32_t>& ray_counts() const { return ray_counts_; }
  /// Rays of a run at most.
  double rays() const { return static_cast<double>(options_.paths) * options_.vertices; }
  /// Device memory of a run, without what vertices become [bytes]. Less where a scene is known whose first rays stay as
  /// paths are numbered.
  static size_t estimate_bytes(uint32_t paths);
  static size_t estimate_bytes(uint32_t paths, const Scene& scene);

 private:
  struct Transients {
    BufferRef rays, hits, ends, states;
    FirstRays::Keys keys;
  };
  void record_batch(ScheduleRecorder& recorder, uint32_t base, const Transients& of, const Variable<uint32_t>& run,
                    const Variable<uint32_t>& seed, const Program& program, const Bind& bind, const Bind& bind_emission,
                    const FirstHits& first_hits) const;

  Device& device_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  LightPathOptions options_;
  bool ordered_;                         ///< where no first hits are given
  std::optional<FirstRays> first_rays_;  ///< then
  uint32_t batch_;                       ///< paths that are traced together
  TypedBuffer<uint32_t> count_;          ///< paths of a batch and of the last, as the intersector takes them
  TypedBuffer<uint32_t> ray_counts_;
};

}  // namespace lucarium
