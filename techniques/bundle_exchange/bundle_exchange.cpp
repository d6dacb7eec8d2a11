// SPDX-License-Identifier: Apache-2.0
//
// bundle_exchange: radiance exchange along global ray-bundles
// -----------------------------------------------------------
//
// Idea. Take one direction ω for the whole scene. All rays along ω form a bundle; drawn orthographically, with every
// fragment kept and sorted by depth, a pixel of the film is such a ray, and consecutive fragments see each other along
// it. They exchange radiance, each giving the other what it reflects. After many directions every texel of an atlas
// over all surfaces has received light from its whole hemisphere (Hermes, Henrich, Grosch, Mueller: Global Illumination
// using Parallel Global Ray-Bundles, VMV 2010).
//
//   E_t = π Σ w L / Σ w        over all rays that met texel t, w = W A_p a, W = 1 / (q(ω) + q(-ω))
//
// q is the density of directions, A_p the area of a film pixel, a the openness of that part of the texel
// (slot_openness.h): what is covered by something near is neither seen nor to count. The cosine is implicit: a texel is
// met by as many rays as it shows area to ω. The ratio needs no texel area and is exact in a uniform field.
//
// All bounces at once. Direction i sends what the directions before have brought, c (E_direct + E) / π. Two means are
// kept (sender_weights.h): S forgets quickly, so that light that was missing at the beginning fades as
// exp(-2 (1 - ρ) √N), and is what is sent; D is nearly a plain mean, and is what is displayed. A balance of the power
// sent and held scales S meanwhile. With max_bounces there is a mean per bounce, each fed by the one before.
//
// Who carries what. Direct light: light samples at pixels and at texels (direct_mode=nee), or, but for point, spot and
// directional lights, the bundles themselves: what texels emit, and the environment at the ends of rays (exchange).
// Specular lobes (mirrors, glass, metals, coats): texels send what a ray finds that leaves by such a lobe; from vertex
// to vertex it follows specular lobes only, since the atlas knows the diffuse light. So do rays from the pixels towards
// the eye.
//
// Parts (bundle_parts): direction_sequence and bundle_view (ω, W, film), slot_exposure and slot_openness (what of
// texels counts), bundle_transfer (a direction's exchange), sender_weights and slot_means (S, D, balance, error),
// slot_light and camera_light (light samples, image), slot_hops and hop_tracer (specular chains).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bundle_exchange/bundle_parts.h"
#include "lucarium/technique/plugin.h"

namespace lucarium {
namespace {

using namespace bundle;

const char* const kOwner = "bundle_exchange";

TechniqueInfo bundle_exchange_info() {
  TechniqueInfo info;
  info.name = kOwner;
  info.version = "1.0";
  info.summary = "radiance exchange along global parallel ray-bundles into a surface atlas";
  info.citation =
      "J. Hermes, N. Henrich, T. Grosch, S. Mueller, Global Illumination using Parallel Global Ray-Bundles, Vision, "
      "Modeling, and Visualization 2010";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.capabilities.max_bounces = -1;
  info.capabilities.view_independent = true;
  info.capabilities.bias = 0.02;  // radiance is constant over a texel; geometric cosines of indirect light
  info.layers = {"emission", "direct", "indirect"};
  return info;
}

class BundleExchange : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set;
    set.max_bounces = settings.max_bounces;
    if (parameters_.interleave == Interleave::pingpong && set.max_bounces < 0) {  // a bounce for each block
      const int head = parameters_.direct_mode == DirectMode::exchange ? parameters_.direct_first : 0;
      set.max_bounces = (std::max(0, parameters_.directions - head) + parameters_.block - 1) / parameters_.block;
    }
    set.light_delta = parameters_.glossy_bounces == GlossyBounces::multiple;
    set.secondary_lambert_only = !set.light_delta;
    return set;
  }

  std::vector<std::string> limitations(const Scene& scene, const RenderSettings& settings) const override {
    return bundle::limitations(parameters_, scene, settings);
  }

  size_t estimate_bytes(const Scene& scene, const RenderSettings& settings) const override {
    return bundle::estimate_bytes(make_plan(parameters_, scene, settings), parameters_, scene, settings);
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    seed_ = context.settings.seed;
    guide_ = make_guide(parameters_, environment());
    build();
  }

  void update(const SceneChange& change) override {
    if (!change.any()) return;
    if (change.environment || change.topology) guide_ = make_guide(parameters_, environment());
    if (change.only_camera() && parts_) {
      step_ = {};
      parts_->camera.set_frame(make_frame(context_->settings));
      return;
    }
    if (parameters_.warm_start && parts_ && forgets(parameters_)) {
      build_from(change);
    } else if (parts_ && !touches_surfaces(change)) {
      build(keep_surfaces());
    } else {
      build();
    }
  }

  IterationResult iterate() override {
    if (!parts_) build();  // the last attempt failed
    run_steps();
    return state();
  }

  void resolve(Film& film) override {
    if (!parts_)
      throw Error(ErrorClass::input, "bundle_exchange: the scene's last change could not be followed; nothing to show");
    parts_->camera.resolve(film, parts_->preview && !exchange_done());
  }

  void reset(uint64_t seed) override {
    seed_ = seed;
    if (!parts_) return build();
    directions_ = gathers_ = 0;
    step_ = {};
    batch_ = {};
    sequence_ = DirectionSequence(sequence_parameters(), seed_, guide_, has_ring());
    if (parts_->specular) parts_->specular->reset();
    parts_->slot_light.reset(kernel_seed(seed_));
    parts_->means.reset();
    parts_->camera.reset(kernel_seed(seed_));
  }

  void warm_up() override {
    if (!parts_) build();
    parts_->warm_up();
  }

  std::map<std::string, double> counters() const override {
    std::map<std::string, double> result{{"directions", static_cast<double>(directions_)}};
    if (parts_) {
      result["indirect_directions"] = static_cast<double>(parts_->means.reflecting(directions_));
      result["slots"] = parts_->atlas->info().texel_count;
      result["film_pixels"] = parts_->transfer.mean_film();
      result["hop_rays"] =
          static_cast<double>((parts_->specular ? parts_->specular->rays() : 0) + parts_->camera.rays());
      if (std::isfinite(parts_->means.relative_error())) result["relative_error"] = parts_->means.relative_error();
    }
    return result;
  }

 private:
  bool has_ring() const { return parts_ && parts_->specular && parts_->specular->has_ring(); }

  /// Where directions are reflected to each other, near ones must come together in a block: it holds 64 windows at
  /// least.
  Parameters sequence_parameters() const {
    Parameters result = parameters_;
    if (has_ring()) result.block = std::max(result.block, 64 * result.glossy_window);
    return result;
  }

  const Environment* environment() const {
    return context_->scene.environment ? &*context_->scene.environment : nullptr;
  }

  void build(BundleParts::Kept kept = {}) {
    parts_.reset();  // its memory first
    const BundlePlan plan = make_plan(parameters_, context_->scene, context_->settings);
    auto parts = std::make_unique<BundleParts>(*context_, parameters_, plan, std::move(kept));
    if (exchanges()) parts->measure_openness(context_->progress);
    parts_ = std::move(parts);
    reset(seed_);
  }

  static bool touches_surfaces(const SceneChange& change) { return change.geometry() || !change.materials.empty(); }

  /// The atlas, which knows surfaces and their emission only, and what of its texels counts.
  BundleParts::Kept keep_surfaces() {
    return {std::move(parts_->atlas), std::move(parts_->exposure), std::move(parts_->openness)};
  }

  /// Texels stay what they are, and senders know what they knew, where the atlas can follow the change.
  void build_from(const SceneChange& change) {
    SlotMeans::Kept known = parts_->means.keep();
    BundleParts::Kept kept = keep_surfaces();
    parts_.reset();
    const uint64_t generation = kept.atlas->generation();
    kept.atlas->refit(context_->scene, change);
    const bool same = kept.atlas->generation() == generation;
    if (touches_surfaces(change)) kept.exposure = nullptr, kept.openness = nullptr;
    build(std::move(kept));
    if (same) parts_->means.start_from(std::move(known));
  }

  bool exchange_done() const {
    return directions_ >= static_cast<uint64_t>(parameters_.directions) || !exchanges() || is_accurate();
  }

  /// Whether the error is as wanted. With pingpong it is that of one bounce, with fixed shares light is missing before
  /// the end: both use up their directions.
  bool is_accurate() const {
    return forgets(parameters_) && parameters_.stop_error > 0 && parts_->means.carries_all(directions_) &&
           parts_->means.relative_error() < parameters_.stop_error;
  }

  /// Whether bundles carry anything.
  bool exchanges() const {
    return context_->settings.max_bounces != 0 || parameters_.direct_mode == DirectMode::exchange;
  }

  /// Directions of the next batch: few at first, when much is learnt from each, and none across a boundary.
  uint32_t next_batch() const {
    if (exchange_done()) return 0;
    const uint64_t first = static_cast<uint64_t>(parameters_.direct_first);
    const bool direct_only = parts_->means.direct_only(directions_);
    uint64_t count = parameters_.batch;
    if (!direct_only)
      count = std::min<uint64_t>(count, 1 + (directions_ - (parts_->means.direct_only(0) ? first : 0)) / 32);
    if (direct_only && directions_ < first) count = std::min(count, first - directions_);
    count = std::min<uint64_t>(count, parameters_.directions - directions_);
    if (parameters_.interleave == Interleave::pingpong)
      count = std::min<uint64_t>(count, parameters_.block - parts_->means.reflecting(directions_) % parameters_.block);
    return static_cast<uint32_t>(count);
  }

  /// An iteration: light samples for some slots, directions of about kPixels film pixels,
  /// a camera sample, which alone changes the image. A step that was cancelled is done again by the next iteration,
  /// which goes on from there.
  bool run_steps() {
    BundleParts& parts = *parts_;
    if (!step_.begun)
      step_ = {true, false, parts.slot_light.runs(), position(), position() + directions_per_iteration()};
    if (!step_.seen && !parts.camera.begin_sample()) return false;
    step_.seen = true;
    for (; step_.light_runs > 0 && wants_light(); --step_.light_runs) {
      if (!parts.slot_light.sample()) return false;
      parts.slot_light.commit();
    }
    step_.light_runs = 0;
    while (position() < step_.end && lit()) {
      const bool exchanging = next_batch() > 0;
      if (!exchanging && !parts.camera.pixel_gather()) break;
      if (!(exchanging ? run_batch() : run_gather())) return false;
    }
    if (!parts.camera.sample()) return false;
    if (parts.preview && !exchange_done() && !parts.preview->smooth()) return false;
    parts.camera.commit(shows_all());
    step_ = {};
    return true;
  }

  /// Directions of the batch, which share what senders know, up to its end or that of the iteration. Cancelled between
  /// directions, it goes on with the next one.
  bool run_batch() {
    if (batch_.done == 0 && !begin_batch()) return false;
    PixelGather* gather = parts_->means.carries_all(directions_) ? parts_->camera.pixel_gather() : nullptr;
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
    if (SlotSpecular* specular = reflecting()) specular->begin_batch(sequence_, directions_, batch_.count);
    return true;
  }

  /// The next direction of the batch; pixels gather along it (null: not), `first`: the first one since they last did.
  /// False when cancelled while slots find what they send, which may be done again; sums are added to in one go.
  bool exchange_along(PixelGather* gather, bool first) {
    const uint64_t index = position();
    const Direction direction = sequence_.at(index);
    const uint32_t seed = direction_seed(index);
    SlotSpecular* specular = reflecting();
    if (specular && !specular->send(direction, batch_.done, seed, parts_->means.sends_direct())) return false;
    if (gather && specular) parts_->transfer.gather(direction, seed, first);
    if (gather && !specular && !gather_along(index, first)) return false;
    parts_->means.direct_only(directions_) ? parts_->transfer.exchange_emission(direction, seed)
                                           : parts_->transfer.exchange(direction, seed);
    if (specular) specular->receive(batch_.done);
    return true;
  }

  void commit_batch() {
    if (SlotSpecular* specular = reflecting()) specular->commit();
    parts_->means.commit(directions_, batch_.count);
    directions_ += batch_.count;
    batch_ = {};
  }

  /// What slots send by specular lobes in the batch; null where bundles carry emission only.
  SlotSpecular* reflecting() const { return parts_->means.direct_only(directions_) ? nullptr : parts_->specular.get(); }

  /// Directions so far, those of pixels only included.
  uint64_t position() const { return directions_ + batch_.done + gathers_; }

  /// When slots have received enough: a direction for pixels only.
  bool run_gather() {
    if (!parts_->means.make_senders() || !gather_along(directions_ + gathers_, true)) return false;
    parts_->camera.pixel_gather()->commit(1);
    ++gathers_;
    return true;
  }

  /// Pixels gather what slots send along a direction, which itself changes nothing that slots know.
  bool gather_along(uint64_t index, bool first) {
    const Direction direction = sequence_.at(index);
    const uint32_t seed = direction_seed(index);
    if (parts_->specular) {
      parts_->specular->begin_batch(sequence_, index, 1);
      if (!parts_->specular->send(direction, 0, seed, parts_->means.sends_direct())) return false;
    }
    parts_->transfer.gather(direction, seed, first);
    return true;
  }

  uint32_t direction_seed(uint64_t index) const {
    return mixed_seed(kernel_seed(seed_), static_cast<uint32_t>(index + 1));
  }

  /// Whether what the image looks up in the atlas is begun in full: the image forgets what came before. Where bounces
  /// are missing until the end, it shows the atlas as it is, and no mean over what it was.
  bool shows_all() const {
    return !exchanges() || exchange_done() ||
           (forgets(parameters_) && directions_ > 0 && parts_->means.carries_all(directions_ - 1));
  }

  /// Whether more light samples at slots are of use.
  bool wants_light() const {
    return context_->settings.max_bounces != 0 && !parts_->slot_light.exhausted() &&
           (!lit() || !(exchange_done() || parts_->means.reflected_light_done()) ||
            parts_->camera.pixel_gather());  // only bundles still send what they know
  }

  /// Whether slots know the direct light that they are to send.
  bool lit() const { return parts_->slot_light.complete() || context_->settings.max_bounces == 0; }

  uint32_t directions_per_iteration() const {
    // Fragments that are stored cost about three times as much as those that are exchanged at once.
    const double films = (parameters_.transfer == Transfer::texel ? 3 : 1) + (parts_->camera.pixel_gather() ? 3 : 0);
    const double count = kPixels / films / parts_->transfer.largest_film();
    return static_cast<uint32_t>(std::clamp(count, 1.0, 64 / films));
  }

  /// When converged, why.
  std::string phase(bool converged) const {
    if (converged && !exchanges()) return fmt::format("all {} camera_samples are done", parameters_.camera_samples);
    if (converged && is_accurate())
      return fmt::format("the relative error is {:.2g}, below stop_error", parts_->means.relative_error());
    const bool by_samples =
        parts_->camera.atlas_samples() == static_cast<uint64_t>(parameters_.camera_samples);  // which it waited for
    if (converged && by_samples)
      return fmt::format("all {} directions and {} camera_samples are done", parameters_.directions,
                         parameters_.camera_samples);
    if (converged) return fmt::format("all {} directions are done", parameters_.directions);
    return !lit() ? "light" : parts_->means.reflected_light_done() ? "direct light" : "exchange";
  }

  IterationResult state() const {
    IterationResult result;
    result.samples = parts_->camera.samples();
    // Of the exchange alone: what it has found is kept when the camera moves.
    result.progress = !lit() ? 0 : exchange_done() ? 1 : static_cast<double>(directions_) / parameters_.directions;
    const bool seen = parts_->camera.atlas_samples() >= static_cast<uint64_t>(parameters_.camera_samples);
    result.converged = lit() && exchange_done() && !wants_light() && seen;
    result.phase = phase(result.converged);
    return result;
  }

  /// Where an iteration is.
  struct Step {
    bool begun = false, seen = false;
    uint32_t light_runs = 0;      ///< left to do
    uint64_t begin = 0, end = 0;  ///< position() at first, and when it is done
  };

  /// The batch that is under way.
  struct Batch {
    uint32_t count = 0, done = 0;  ///< directions
  };

  static constexpr double kPixels = 4e6;  ///< film pixels of an iteration, about 100 ms
  Parameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  std::unique_ptr<TechniqueContext> context_;
  std::shared_ptr<const EnvironmentGuide> guide_;
  uint64_t seed_ = 1, directions_ = 0, gathers_ = 0;
  Step step_;
  Batch batch_;
  DirectionSequence sequence_{parameters_, 1, nullptr};
  std::unique_ptr<BundleParts> parts_;
};

std::unique_ptr<Technique> create_bundle_exchange() { return std::make_unique<BundleExchange>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::bundle_exchange_info, lucarium::create_bundle_exchange)
