// SPDX-License-Identifier: Apache-2.0
//
// bundle_exchange: radiance exchange along global ray-bundles
// -----------------------------------------------------------
//
// Idea. Take one direction ω for the whole scene. All rays along ω form a bundle; drawn orthographically, with every
// fragment kept and sorted by depth, a pixel of the bundle image is such a ray, and consecutive fragments see each
// other along it. They exchange radiance, each giving the other what it reflects. After many directions every texel of
// an atlas over all surfaces has received light from its whole hemisphere (Hermes, Henrich, Grosch, Mueller: Global
// Illumination using Parallel Global Ray-Bundles, VMV 2010).
//
//   E_t = π Σ w L / Σ w        over all rays that met texel t, w = W A_p a, W = 1 / (q(ω) + q(-ω))
//
// q is the density of directions, A_p the area of a bundle pixel, a the accessibility of that part of the texel
// (texel_sides/side_accessibility.h): what is covered by something near is neither seen nor to count. The cosine is
// implicit: a texel is met by as many rays as it shows area to ω. The ratio needs no texel area and is exact in a
// uniform field.
//
// All bounces at once. Direction i sends what the directions before have brought, c (E_direct + E) / π. Two means are
// kept (senders/sender_weights.h): S forgets quickly, so that light that was missing at the beginning fades as
// exp(-2 (1 - ρ) √N) for albedo ρ after N batches, and is what is sent; D is nearly a plain mean, and is what is
// displayed. A balance of the power sent and held scales S meanwhile. With max_bounces, each bounce has its mean.
//
// Who carries what. Direct light: light samples at pixels and at texels (direct_mode=nee), or the bundles themselves:
// emission of texels, and the environment at the ends of rays (exchange; point, spot and directional lights are always
// sampled). Specular lobes (mirrors, glass, metals, coats): a texel traces a ray by such a lobe and sends what it
// finds. The ray follows specular lobes only, since the atlas holds the diffuse light. So do rays from the pixels
// towards the eye.
//
// Where the paper stands in the source (files below this folder; bundles/, layered_raster/, surface_atlas/,
// texel_sides/ and interior_surfaces/ are in framework/lucarium/services and kernels/lucarium):
//
//   equation 1 (Eq. 1), rendering equation   f_r: lucarium/bsdf.clh: eval_bsdf();
//                                            the integral: exchange/exchange_pairs.cl: receive()
//   equation 2 (Eq. 2), sum over directions  senders/accumulate_batch.cl; ratio: side_mean() (base/exchange_layout.clh)
//   equation 3 (Eq. 3), transfer             exchange/exchange_pairs.cl: receive() (L_x cosθ);
//                                            senders/make_senders.cl: make_senders() (f_r);
//                                            term by term in exchange/exchange_texels.cl: exchange_texels()
//   equation 4 (Eq. 4), transfer atlas       senders/receive_history.cl, senders/send_history.cl (glossy_window)
//   figure 3, loop over directions           bundle_exchange.cpp: run_batch(), exchange_along()
//   figure 5, self-localization              exchange/exchange_texels.cl: exchange_texels() (transfer=texel);
//                                            layered_raster/fragment_list.clh: seen_fragment()
//   section 4.1, texture atlases             surface_atlas/surface_atlas.h; sums in base/exchange_layout.clh
//   section 4.2, k-buffer, sorting           layered_raster/layered_raster.h: every fragment, not the first k;
//                                            layered_raster/rows.clh: layered_sort_row()
//   section 4.2, opposite sampling points    exchange/exchange_pairs.cl: layered_ray_crosses()
//   section 4.3, ray directions, Halton      bundles/direction_sequence.cpp: point()
//   section 5.1, direct illumination         texel_sides/begin_direction.cl: begin_direction();
//                                            exchange/exchange_pairs.cl: receive_end(); area lights:
//                                            senders/make_senders.cl: make_senders() (direct_mode=exchange)
//   section 5.2, diffuse, ping-pong          senders/finish_bounce.cl (interleave=pingpong)
//   section 5.3, final glossy bounce         pixels/gather_pixels.cl (pixel_rays=bundle);
//                                            specular/begin_pixel_chains.cl (by rays)
//   section 5.4, glossy interreflections     senders/direction_history.h; specular/begin_side_chains.cl (by rays)
//   section 5.5, interleaved light transfer  senders/make_senders.cl, senders/accumulate_batch.cl;
//                                            senders/sender_weights.cpp: next()
//   section 6.4, direct light first          senders/side_means.cpp: direct_only(), reflecting() (direct_first)
//   section 6.5, separate direct light       texel_sides/sample_side_light.cl: light_point() (nee)
//
// Not in the paper: the two means S and D (senders/sender_weights.h), the balance (senders/balance_power.cl),
// accessibility (texel_sides/side_accessibility.h), light kept apart of parts of texels close under glass
// (SideAccessibility::halves()), hidden surfaces (interior_surfaces/), specular chains (specular/),
// the preview (senders/smooth_preview.cl) and the start from what is known (senders/side_means.cpp: start_from()).

#include <algorithm>
#include <optional>
#include <utility>

#include "bundle_exchange/bundle_parts.h"
#include "bundle_exchange/cost.h"
#include "bundle_exchange/declaration.h"
#include "bundle_exchange/direction_plan.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"
#include "lucarium/technique/technique_state.h"

namespace lucarium {
namespace {

using namespace bundle;

class BundleExchange : public TechniqueBase<Parameters> {
 public:
  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    return bundle::path_set(parameters_, settings);
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return bundle::limitations(parameters_, scene, settings);
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return bundle::estimate_bytes(make_plan(parameters_, scene, settings), parameters_, scene, settings);
  }

  double estimate_seconds(const Scene& scene, const RenderSettings& settings,
                          const ComputePower& power) const override {
    return bundle::estimate_seconds(make_plan(parameters_, scene, settings), parameters_, scene, settings, power);
  }

  std::string state_refusal() const override { return bundle::state_refusal(parameters_); }
  std::vector<std::string> parameters_of_view() const override {
    return {"camera_samples", "eye_share", "preview", "warm_start"};
  }

  std::vector<ParameterSaving> savings(const Scene&, const RenderSettings&) const override { return bundle::savings(); }
  std::vector<std::pair<std::string, std::string>> endless() const override { return bundle::endless(parameters_); }

  InspectedValues inspect(const SeenPoint& point) const override {
    return parts_ ? parts_->inspect(point) : InspectedValues();
  }

  std::map<std::string, double> counters() const override {
    return parts_ ? parts_->counters(directions_) : std::map<std::string, double>{{"directions", 0}};
  }

 protected:
  // ---- the loop over directions

  /// An iteration: light samples for some texels, some directions, and where these have earned it (eye_share) a camera
  /// sample, which alone changes the image; behind it iterations of a camera sample only, where they have earned more.
  /// What a cancelled one has completed is kept; the next goes on from there.
  bool step() override {
    BundleParts& parts = *parts_;
    if (!step_.begun) begin_step();
    if (step_.eye && !step_.seen && !parts.camera->begin_sample()) return false;
    step_.seen = true;
    if (!sample_texels() || !exchange_directions()) return false;
    if (step_.eye) {
      if (!parts.camera->sample()) return false;
      if (!step_.eye_only && shows_preview() && !parts.preview->smooth()) return false;
      parts.commit_sample(shows_all());
    }
    eye_earned_ = std::max(0.0, step_.eye_earned - (step_.eye ? 1 : 0));
    step_ = {};
    return true;
  }

  IterationResult state() const override {
    const Phase now = phase();
    IterationResult result;
    result.samples = parts_->camera->samples();
    result.progress = progress_of(now, parameters_, directions_);
    const bool seen = has_samples(parameters_, parts_->camera->atlas_samples());
    result.light_done = now == Phase::done && !wants_light() && !light_rests();
    result.converged = result.light_done && seen;
    result.phase = result.converged ? why_converged(parameters_, parts_->means, directions_, exchanges(),
                                                    parts_->camera->atlas_samples())
                                    : describe(now, parts_->means);
    return result;
  }

  void write(Film& film) override { parts_->write(film, shows_preview()); }

  void restart() override {
    directions_ = gathers_ = 0;
    eye_earned_ = 0;
    step_ = {};
    batch_ = {};
    const bool has_history = parts_->specular && parts_->specular->has_history();
    sequence_ = make_sequence(parameters_, full_seed(), guide_, has_history);
    parts_->reset(seed());
    if (known_) parts_->means.start_from(std::move(*known_));
    known_.reset();
  }

  // ---- what is made for a scene

  void compile() override { guide_ = make_guide(parameters_, scene()); }

  bool follow(const SceneChange& change) override {
    if (change.environment || change.topology) guide_ = make_guide(parameters_, scene());
    if (!parts_) return false;
    if (change.only_camera()) {
      step_ = {};
      gathers_ = 0;  // the picture's own directions
      eye_earned_ = 0;
      std::unique_ptr<BundleParts> parts = std::move(parts_);  // lost where memory does not suffice for another size
      const bool kept = parts->set_frame(context(), parameters_, seed());
      parts_ = std::move(parts);
      return kept;
    }
    const bool touched = change.geometry() || !change.materials.empty();
    if (parameters_.warm_start && forgets(parameters_)) {
      keep_senders(change, touched);
    } else if (!touched) {
      kept_ = parts_->release_surfaces();
    }
    return false;
  }

  void build() override {
    parts_.reset();  // its memory first
    // Of this change alone: what follows a failure begins with nothing.
    BundleParts::Kept kept = std::exchange(kept_, {});
    std::optional<SideMeans::Kept> known = std::exchange(known_, {});
    BundlePlan plan = make_plan(parameters_, scene(), settings());
    if (parameters_.texels == 0)
      automatic_texels_ = plan.atlas.texel_count = std::max(automatic_texels_, plan.atlas.texel_count);
    // The atlas of the state, whatever size its picture had.
    if (context().state) plan.atlas.texel_count = saved_texels(*context().state);
    auto parts = std::make_unique<BundleParts>(context(), parameters_, plan, std::move(kept));
    atlas_texels_ = plan.atlas.texel_count;
    // Rays of bundles need it, and a state brings what they have found.
    if (exchanges() && !context().state) parts->measure_accessibility(context().progress);
    parts_ = std::move(parts);
    known_ = std::move(known);
  }

  void warm_up_kernels() override { parts_->warm_up(); }

  // ---- what is kept in a file

  void save(StateWriter& chunks) override {
    chunks.put_value("texels", atlas_texels_);
    parts_->means.save(chunks);
  }

  void load(const StateReader& chunks) override {
    parts_->means.load(chunks);
    directions_ = parts_->means.directions();
  }

 private:
  // ---- progress

  Phase phase() const { return light_held() ? Phase::done : phase_of_light(); }
  Phase phase_of_light() const {  // held or not
    if (!(parts_->side_light.complete() || settings().max_bounces == 0)) return Phase::light;
    if (!exchanges() || directions_ >= direction_limit(parameters_) ||
        is_accurate(parameters_, parts_->means, directions_))
      return Phase::done;
    return parts_->means.reflected_light_done() ? Phase::emission_only : Phase::exchange;
  }

  bool exchanges() const { return bundle::exchanges(parameters_, settings()); }

  bool shows_preview() const { return parts_->preview && (light_rests() ? phase_of_light() : phase()) != Phase::done; }

  /// Whether what the image looks up in the atlas is begun in full: the image forgets what came before. Where bounces
  /// are missing until the end, it shows the atlas as it is, and no mean over what it was.
  bool shows_all() const {
    return phase() == Phase::done ||
           (forgets(parameters_) && directions_ > 0 && parts_->means.carries_all(directions_ - 1));
  }

  /// Whether more light samples at texels are of use: to those that send reflected light, or to pixels that gather it.
  bool wants_light() const {
    if (light_held() || settings().max_bounces == 0 || parts_->side_light.exhausted()) return false;
    return phase() == Phase::light || !(phase() == Phase::done || parts_->means.reflected_light_done()) ||
           parts_->camera->pixel_gather();
  }

  // ---- an iteration

  /// Directions so far, those of pixels only included.
  uint64_t position() const { return directions_ + batch_.done + gathers_; }

  uint64_t end_of_iteration() const {
    return position() + directions_per_iteration(parameters_, parts_->transfer->largest_image(),
                                                 parts_->camera->pixel_gather() != nullptr);
  }

  void begin_step() {
    const bool eye_only = eye_earned_ >= 1;
    step_ = {.begun = true, .eye_only = eye_only, .eye = eye_only, .eye_earned = eye_earned_};
    step_.begin = step_.end = position();
    if (eye_only) return;
    step_.end = end_of_iteration();
    step_.light_runs = parts_->side_light.runs();
    const WorkUnits units = parts_->work_units(scene());
    const bool lit = phase() != Phase::light, done = phase() == Phase::done;
    step_.eye_earned +=
        earned_eye_samples(parameters_, parts_->eye_share(parameters_, units), units,
                           lit && !done ? step_.end - step_.begin : 0, wants_light() ? step_.light_runs : 0, lit);
    step_.eye = step_.eye_earned >= 1 || parts_->camera->samples() == 0 || done;
  }

  uint32_t next_batch() const {
    return phase() == Phase::done ? 0 : batch_size(parameters_, parts_->means, directions_);
  }

  /// Light samples at the runs of texels of this iteration. False when cancelled.
  bool sample_texels() {
    for (; step_.light_runs > 0 && wants_light(); --step_.light_runs) {
      if (!parts_->side_light.sample()) return false;
      parts_->side_light.commit();
    }
    step_.light_runs = 0;
    return true;
  }

  /// The directions of this iteration (figure 3 of the paper, the outer loop). When texels have received enough, those
  /// that pixels gather along, never between directions of a batch. False when cancelled.
  bool exchange_directions() {
    while (position() < step_.end && phase() != Phase::light) {
      const bool begun = light_rests() && parts_->gathers() && batch_.done > 0;  // it is completed all the same
      const bool exchanging = begun || next_batch() > 0;
      if (!exchanging && !parts_->gathers()) return true;
      if (!(exchanging ? run_batch() : run_gather())) return false;
    }
    return true;
  }

  /// Directions of the batch, which share what senders know, up to its end or that of the iteration; batches of one are
  /// the interleaved light transfer of section 5.5 (Gauss-Seidel). Cancelled between directions, it goes on with the
  /// next one.
  bool run_batch() {
    if (batch_.done == 0 && !begin_batch()) return false;
    PixelGather* gather = parts_->means.carries_all(directions_) ? parts_->camera->pixel_gather() : nullptr;
    const uint64_t gathered_from = std::max(directions_, step_.begin);  // the rest was for another camera sample
    for (; batch_.done < batch_.count && position() < step_.end; ++batch_.done)
      if (!exchange_along(position() >= gathered_from ? gather : nullptr, position() == gathered_from)) return false;
    if (gather) gather->commit(static_cast<uint32_t>(position() - gathered_from));
    if (batch_.done == batch_.count) commit_batch();
    return true;
  }

  bool begin_batch() {
    batch_.count = next_batch();
    if (!parts_->means.make_senders()) return false;
    if (parts_->side_state && !parts_->means.direct_only(directions_)) parts_->side_state->add_balance();
    if (SideSpecular* specular = reflecting()) specular->begin_batch(sequence_, directions_, batch_.count);
    return true;
  }

  /// The next direction of the batch (figure 3, the body of the loop); pixels gather along it (null: not), `first`: the
  /// first one since they last did. False when cancelled while texel sides find what they send, which may be done
  /// again; sums are added to in one go.
  bool exchange_along(PixelGather* gather, bool first) {
    const uint64_t index = position();
    const BundleDirection direction = sequence_.at(index);
    const uint32_t seed = direction_seed(index);
    SideSpecular* specular = reflecting();
    if (specular && !specular->send(direction, batch_.done, seed, parts_->means.sends_direct())) return false;
    if (gather && specular) parts_->transfer->gather(direction, seed, first);
    if (gather && !specular && !parts_->gather_along(sequence_, index, seed, first)) return false;
    if (parts_->means.direct_only(directions_))
      parts_->transfer->exchange_emission(direction, seed);
    else
      parts_->transfer->exchange(direction, seed);
    if (specular) specular->receive(batch_.done);
    if (specular && parts_->side_state) parts_->side_state->add_history();
    return true;
  }

  void commit_batch() {
    if (SideSpecular* specular = reflecting()) specular->commit();
    parts_->means.commit(directions_, batch_.count);
    directions_ += batch_.count;
    batch_ = {};
  }

  /// What texel sides send by specular lobes in the batch; null where bundles carry emission only.
  SideSpecular* reflecting() const { return parts_->means.direct_only(directions_) ? nullptr : parts_->specular.get(); }

  /// When texel sides have received enough: a direction for pixels only.
  bool run_gather() {
    const uint64_t index = directions_ + gathers_;
    if (!parts_->means.make_senders() || !parts_->gather_along(sequence_, index, direction_seed(index), true))
      return false;
    parts_->camera->pixel_gather()->commit(1);
    ++gathers_;
    return true;
  }

  uint32_t direction_seed(uint64_t index) const { return mixed_seed(seed(), static_cast<uint32_t>(index + 1)); }

  // ---- what a change of the scene leaves

  /// Texels stay what they are, and senders know what they knew, where the atlas can follow. touched: surfaces changed.
  void keep_senders(const SceneChange& change, bool touched) {
    SideMeans::Kept known = parts_->means.keep();
    BundleParts::Kept kept = parts_->release_surfaces();
    parts_.reset();
    const uint64_t generation = kept.atlas->generation();
    kept.atlas->refit(scene(), change);
    if (kept.atlas->generation() == generation) known_ = std::move(known);
    if (touched) kept.interior = nullptr, kept.accessibility = nullptr;
    kept_ = std::move(kept);
  }

  std::shared_ptr<const EnvironmentGuide> guide_;
  uint64_t directions_ = 0, gathers_ = 0;
  uint64_t atlas_texels_ = 0, automatic_texels_ = 0;  ///< wanted of the atlas; by texels=0, of the largest image so far
  IterationStep step_;
  double eye_earned_ = 0;  ///< camera samples that the work so far has earned
  BatchStep batch_;
  DirectionSequence sequence_{{}, 1};
  std::unique_ptr<BundleParts> parts_;
  BundleParts::Kept kept_;                ///< for the next build()
  std::optional<SideMeans::Kept> known_;  ///< for the next restart()
};

std::unique_ptr<Technique> create_bundle_exchange() { return std::make_unique<BundleExchange>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::bundle::technique_info, lucarium::create_bundle_exchange)
