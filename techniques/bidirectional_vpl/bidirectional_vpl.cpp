// SPDX-License-Identifier: Apache-2.0
//
// bidirectional_vpl: camera paths, light samples and virtual point lights, joined by multiple importance sampling
// ----------------------------------------------------------------------------------------------------------------
//
// Idea. Light that a path tracer finds by chance only is easy to find from its source. Vertices of light paths are
// virtual point lights (Keller 1997); a camera path is connected to one of them at every vertex. Every light path has
// several ways of being found, and the balance heuristic joins them, so that none of them is left alone with what it
// does badly: corners for virtual lights, small lamps for camera paths (Tokuyoshi and Ogaki 2012, section 4.2).
//
// How. An iteration traces light paths, keeps their vertices with BSDFs, and follows one camera path per pixel:
//
//   hit      the camera path meets the emitter               n = 1
//   nee      a light sample at its vertex                    n = 1
//   vpl s    connection to a vertex s of a light path        n = M / 2 per vertex of a light path
//   splat    a light vertex seen by the camera itself        n = light paths
//
// A connection compares M candidates by what they would bring unshadowed and traces one shadow ray (resampled
// importance sampling). Weights are sums over all strategies, which both sides of a connection carry along
// (kernels/lucarium/path_mis.clh has the derivation).
//
// Error. None but noise, except with reuse=shared, whose directions depend on each other, with rasterized bundles
// (bundle_mode=raster and linked_list) and maps (light_trace=rsm, vpl_visibility=map, direct=maps), which show what
// lies up to a pixel beside a ray, and with the modes for few samples: two_bounce=clamp, gloss, filter, caches.
// preset=paper has all of these.
//
// Where the paper stands in the source (files below this folder; light_paths/ and layered_raster/ are in
// framework/lucarium/services and kernels/lucarium; lucarium/ is kernels/lucarium):
//
//   section 3.1, equation 1, path tracing    eye/shade_eye_vertices.cl: sample_direction(), shade_eye_vertices()
//   section 3.2, global ray-bundles          bundles/bundle_set.clh: bundle_number(), bundle_set(): directions that all
//                                            pixels of an iteration share (directions=bundle); with bundle_mode
//                                            bundles/bundle_views.cl: make_bundle_views(), lists per pixel by
//                                            layered_raster/, linear search in bundles/look_up_bundle.cl: look_up()
//   section 3.3, equation 2, density p_r     base/eye_directions.clh: bundle_pdf(): of w and -w, uniform or after an
//                                            environment map (dir_pdf)
//   section 4, figure 3, combined paths      eye/shade_eye_vertices.cl: shade_eye_vertices();
//                                            strategies: lucarium/path_mis.clh
//   section 4.1, creating VPLs, p_e          light_paths/light_paths.clh: emit_light_paths(); lucarium/emission.clh:
//                                            sample_emission(); light/store_light_vertices.cl: take_light_vertex()
//   section 4.1, Russian roulette            light_paths/light_paths.clh: scatter_light()
//   section 4.1, reflective shadow maps      maps/light_maps.cl: look_up_light_maps() (light_trace=rsm)
//   section 4.1, shadow maps of VPLs         maps/vpl_maps.cl: test_vpl_maps() (vpl_visibility=map)
//   section 7, shadow maps of lights         maps/light_maps.cl: test_light_maps() (direct=maps)
//   section 4.2, equation 3, one-bounce: VPL eye/connect.clh: connected_light()
//   section 4.2, equation 3, by ray-bundle   eye/find_lights.clh: connect_light_sample(), at the next vertex
//   section 4.2, equation 4, density p_1     light_paths/light_paths.clh: arrive_light_path_mis()
//   section 4.2, equation 5, density p_2     eye/eye_path.clh: arrive_eye_mis(). Both are by area here; the paper's are
//                                            these over |cos| / d^2 of both edges, so that their ratio is the same
//   section 4.2, equation 6, weights, β      lucarium/path_mis.clh: path_mis_sum(), path_mis_power() (beta)
//   section 4.3, equation 7, two-bounce      eye/connect.clh: connected_light(), at later vertices of a camera path,
//                                            with weights (equation 6)
//   section 4.3, clamp of two bounces        eye/two_bounce.clh: connected_share(), rest_share() (two_bounce)
//   section 4.3, equation 8, density p_1,2   the product of both sides, carried along: lucarium/path_mis.clh:
//                                            path_mis_leave(), path_mis_arrive()
//   section 5.1, equation 9, equation 10,
//   equation 12                              base/clamped_roughness.clh; base/gloss.clh: widened_bsdf() (gloss)
//   section 5.2, equation 13                 base/clamped_roughness.clh: joint_density()
//   section 5.2, equation 14                 eye/shade_eye_vertices.cl: sample_direction()
//   section 5.2, equation 15, equation 16,
//   equation 17                              eye/gloss_paths.clh: suppress_connection(), suppressed_light_sample()
//   section 6, split, gather, filter         base/interleave.clh; eye/filter_pixels.cl
//   section 6, 2 x 2 supersampling, caches   eye/caches.cl
//   section 7, multi-bounce, reuse           bundles/bundle_set.clh: bundle_number(), bundle_set() (reuse)
//
// Not in the source: the anisotropic lobe of equation 11, which no material has.
//
// Not in the paper: light paths of more than one vertex, lights other than points, light samples and splats as
// strategies, the choice among candidates (light/candidates.clh), directions after light paths behind mirrors and glass
// (guide/), leaving out what costs more than it brings (effort/).

#include <memory>
#include <vector>

#include "bidirectional_vpl/base/plan.h"
#include "bidirectional_vpl/declaration.h"
#include "bidirectional_vpl/effort/trials.h"
#include "bidirectional_vpl/iteration/parts.h"
#include "lucarium/base/error.h"
#include "lucarium/base/log.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"

namespace lucarium {
namespace {

using namespace bidirectional;

const char* const kName = "bidirectional_vpl";

class BidirectionalVpl : public TechniqueBase<BidirectionalParameters> {
 public:
  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    return bidirectional::path_set(parameters_, settings);
  }
  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return bidirectional::limitations(parameters_, scene, settings);
  }
  double admitted_bias(double declared) const override { return bidirectional::admitted_bias(parameters_, declared); }
  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return bidirectional::estimate_bytes(parameters_, scene, settings);
  }
  InspectedValues inspect(const SeenPoint& point) const override {
    return parts_ ? parts_->inspect(point) : InspectedValues{};
  }
  std::map<std::string, double> counters() const override {
    if (!parts_) return {};
    std::map<std::string, double> all = parts_->counters();
    for (const auto& [name, count] : counted_before_) all[name] += count;
    if (guide_) all["guide_photons"] = guide_->collected();
    all.insert(trials_counted_.begin(), trials_counted_.end());
    if (!adapted_) return all;
    const Plan plan = make_plan(parameters_, settings(), effort_);
    all["adapted_light_paths"] = plan.light_vertices > 0 ? 1 : 0;
    all["adapted_splats"] = plan.splat ? 1 : 0;
    all["adapted_light_vertices"] = plan.light_vertices;
    all["adapted_camera_edges"] = effort_.camera_edges;
    return all;
  }

 protected:
  void build() override {
    trials_.reset();
    kept_.clear();
    parts_.reset();  // its memory first
    sums_.reset();
    check_parameters(parameters_, settings());
    guide_.reset();
    sums_ = std::make_unique<EyeSums>(device(), make_plan(parameters_, settings()), kName);
    if (make_plan(parameters_, settings()).guide && may_be_ideal(scene()))
      guide_ = std::make_unique<GuidePhotons>(device(), scheduler(), scene_buffers(), kName);
    make_parts(whole_effort(parameters_));
  }

  bool follow(const SceneChange&) override {
    if (!built() || !parts_ || buffers_replaced() || !parts_->update()) return false;
    if (make_plan(parameters_, settings()).guide && may_be_ideal(scene()) != (guide_ != nullptr)) return false;
    moves_on_ = true;
    restart_samples();
    return true;
  }

  void restart() override {
    // As a new image begins.
    counted_before_.clear();
    trials_counted_.clear();
    trials_.reset();
    adapted_ = false;
    adapts_after_ = UINT64_MAX;
    if (can_adapt(parameters_, make_plan(parameters_, settings())))
      adapts_after_ = Trials::samples_before(parameters_, settings());
    if (!parts_ || effort_ != whole_effort(parameters_)) make_parts(whole_effort(parameters_));
    if (guide_) guide_->clear();
    parts_->restart(frame(), moves_on_);
    moves_on_ = false;
  }

  bool step() override {
    if (!parts_) make_parts(effort_);  // the last attempt failed
    if (samples() >= adapts_after_ && !adapted_ && !adapt(samples() - adapts_after_)) return false;
    if (samples() == 0 && !parts_->prepare_guide()) return false;
    if (!parts_->trace(static_cast<uint32_t>(samples()))) return false;
    parts_->add(samples() + 1);
    parts_->teach();
    return true;
  }

  IterationResult state() const override {
    IterationResult result = TechniqueBase::state();
    result.phase = "trace";
    return result;
  }

  void write(Film& film) override {
    if (parts_) parts_->write(film);
  }
  void warm_up_kernels() override {
    // Those of trials, too, so that no kernel is compiled while iterating; recorded first, since what is recorded is
    // compiled side by side.
    std::vector<std::shared_ptr<SmallParts>> trials;
    if (adapts_after_ != UINT64_MAX) trials = make_trials()->certain_parts();
    parts_->warm_up();
    for (const auto& parts : trials) parts->parts().warm_up();
  }

 private:
  PartsContext parts_context() { return {device(), scheduler(), scene_buffers(), bvh(), guide_.get(), kName}; }

  std::unique_ptr<Trials> make_trials() {
    return std::make_unique<Trials>(parts_context(), parameters_, settings(), frame(), kept_);
  }

  void make_parts(const Effort& effort) {
    parts_.reset();  // its memory first
    parts_ = std::make_unique<Parts>(parts_context(), make_plan(parameters_, settings(), effort), frame(), *sums_);
    effort_ = effort;
  }

  /// Does trial number `number`, one with each sample, so that none takes long; behind the last, goes on with what is
  /// worth its work, from the same sums. Where a trial fails nothing changes. False when cancelled.
  bool adapt(uint64_t number) {
    try {
      if (!trials_) trials_ = make_trials();
      if (trials_->done() <= number && !trials_->advance()) return false;
    } catch (const Error& error) {
      if (error.error_class() == ErrorClass::interrupted) throw;
      log_warning("{}: adapt has no effect: {}", kName, error.what());
      adapts_after_ = UINT64_MAX;
      trials_.reset();
      kept_.clear();
      return true;
    }
    trials_counted_ = trials_->counted();
    if (!trials_->best()) return true;
    const Effort best = *trials_->best();
    trials_.reset();
    adapted_ = true;
    if (best == effort_) return true;
    counted_before_ = parts_->counters();
    make_parts(best);
    return true;
  }

  std::unique_ptr<EyeSums> sums_;
  std::unique_ptr<GuidePhotons> guide_;  ///< kept when adapt changes parts
  std::unique_ptr<Parts> parts_;
  KeptParts kept_;
  std::unique_ptr<Trials> trials_;  ///< while they go on
  Effort effort_;                   ///< of parts_
  uint64_t adapts_after_ = 0;       ///< samples
  bool adapted_ = false;            ///< effort_ has been decided
  std::map<std::string, double> counted_before_, trials_counted_;
  bool moves_on_ = false;  ///< restart() comes with the next frame of a moving picture
};

std::unique_ptr<Technique> create_bidirectional_vpl() { return std::make_unique<BidirectionalVpl>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::bidirectional::technique_info, lucarium::create_bidirectional_vpl)
