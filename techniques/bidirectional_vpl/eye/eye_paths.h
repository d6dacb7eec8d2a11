// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/bundles/bundle_edges.h"
#include "bidirectional_vpl/eye/caches.h"
#include "bidirectional_vpl/eye/pixel_filter.h"
#include "bidirectional_vpl/guide/guide_photons.h"
#include "bidirectional_vpl/light/light_vertices.h"
#include "bidirectional_vpl/maps/maps.h"
#include "lucarium/services/layer_sums/layer_sums.h"

namespace lucarium::bidirectional {

/// The light of all samples so far, by layer and, where they are shown, by strategy.
struct EyeSums {
  EyeSums(Device& device, const Plan& plan, const std::string& owner);
  void clear();

  LayerSums direct, indirect, strategies;
};

/// Camera paths of an iteration, one to a pixel, and the sums of their light:
///
///   begin     begin_eye_paths                            rays, empty sample
///   bounce    closest hit           Intersector          rays -> hits
///     ^       bundle_mode: BundleEdges, of rays along bundles
///     ^       vpl_choice=all: connect_to_all, shadow rays, add_connections, for each virtual light
///     |       draw_eye_numbers      what vertices decide by
///     |       shade_eye_vertices    hits of lights, light sample, connection, BSDF sample
///     |       shadow rays, twice    Intersector (any hit)
///     |       add_eye_light_samples, add_connections
///     +------ compact, advance_paths, and the number of paths left is read back
///   add       add_layer             sample -> sums, to its end
class EyePaths {
 public:
  /// `vertices`: null where there are no light paths; `guide`: null without Plan::guide. `maps`, `guide` and `sums`,
  /// which belong to the same image, must outlive this.
  EyePaths(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
           const Frame& frame, const Plan& plan, const LightVertices* vertices, EyeSums& sums, const Maps& maps,
           const GuidePhotons* guide, const std::string& owner);

  /// Empties the sample of an iteration. False when cancelled.
  bool begin(uint32_t index);
  /// Follows all paths. False when cancelled.
  bool trace(uint32_t index);
  /// Adds the sample to the sums, `iterations` with it, and what was counted. Throws Error{technique} where one was
  /// NaN, infinite or negative.
  void add(uint64_t iterations);

  void set_frame(const Frame& frame);
  /// Follows a change of the scene. False where this must be built again.
  bool update() { return !bundles_ || bundles_->update(); }
  /// Back to no samples. `moves_on`: with the next frame, for which caches keep light.
  void clear(bool moves_on);
  void warm_up();
  void write(Film& film) const;
  /// For Technique::inspect(): what each strategy has brought to a pixel, where its layers are shown.
  InspectedValues describe_strategies(uint32_t pixel) const;
  const TypedBuffer<float4>& sample() const { return sample_; }
  const TypedBuffer<EyePathState>& states() const { return states_; }
  std::map<std::string, double> counters() const;
  static size_t estimate_bytes(const Plan& plan, const Scene& scene, bool ray_ends);

 private:
  /// Light that shadow rays bring to the paths of a pass.
  struct ShadowedLight {
    std::string name;
    BufferRef rays, ends, values;
    BufferRef sources;  ///< lights of light samples (with direct=maps), light paths of connections
    BufferRef hidden;
    std::optional<Variable<uint32_t>> number = {};  ///< of the virtual light that all connections lead to
  };
  /// What a path goes on with, and whether it does.
  struct NextRays {
    BufferRef rays, ends, queue, alive;
  };
  void record_begin();
  void record_closest();
  void record_connect_to_all();
  void record_bounce();
  void record_shade(ScheduleRecorder& recorder, const BufferRef& hits, const NextRays& next,
                    const ShadowedLight& samples, const ShadowedLight& connections) const;
  void record_connections(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& hits) const;
  void record_advance(ScheduleRecorder& recorder, const NextRays& next);
  void record_add();
  ShadowedLight shadowed_light(ScheduleRecorder& recorder, const std::string& name) const;
  /// `hits`: surfaces that are lit; `count`, `tests`: where rays, and with maps all tests, are counted.
  void record_shadowed(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& hits,
                       const std::string& kernel, uint32_t count, uint32_t tests) const;
  void count_rays(ScheduleRecorder& recorder, const ShadowedLight& light, const BufferRef& rays, uint32_t index) const;
  bool connect_to_all();
  bool find_surfaces(uint32_t index, uint32_t depth);
  /// Whether surfaces are found before the schedule that shades them: to be looked at by several, or looked up.
  bool keeps_hits() const { return plan_.connects_to_all() || plan_.stores_bundles(); }
  std::map<std::string, std::string> defines() const;

  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  const Intersector& intersector_;
  Frame frame_;
  Plan plan_;
  const LightVertices* vertices_;
  const Maps& maps_;
  const GuidePhotons* guide_;
  std::string owner_;
  Primitives primitives_;
  Program program_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<RayEnds> ends_;  ///< empty where the intersector wants none
  TypedBuffer<uint32_t> queue_, active_, counts_;
  TypedBuffer<EyePathState> states_;
  TypedBuffer<float> mis_;
  TypedBuffer<float4> sample_;
  TypedBuffer<Hit> hits_;                   ///< of one pass, where several schedules need them (keeps_hits())
  TypedBuffer<PathVertex> first_vertices_;  ///< for gloss: of each path
  TypedBuffer<PathVertex> no_vertices_;     ///< bound where there are no light paths
  TypedBuffer<float2> no_densities_;
  TypedBuffer<uint32_t> no_list_;
  TypedBuffer<float> no_table_;
  EyeSums& sums_;
  std::unique_ptr<Caches> caches_;        ///< null without Plan::caches
  std::unique_ptr<PixelFilter> filter_;   ///< null without Plan::filter
  std::unique_ptr<BundleEdges> bundles_;  ///< null where rays are traced
  Schedule begin_, closest_, connect_, bounce_, add_;
  Variable<Frame> begin_frame_;
  Variable<uint32_t> begin_index_, bounce_seed_, bounce_index_, connect_seed_, connect_index_, connect_number_;
  uint32_t remaining_ = 0;                                ///< read back after every segment
  std::array<uint32_t, BIDIRECTIONAL_COUNTS> counted_{};  ///< and this after every iteration
  std::array<double, BIDIRECTIONAL_COUNTS> totals_{};
  double candidates_ = 0;
  double paths_ = 0, segments_ = 0;
};

}  // namespace lucarium::bidirectional
