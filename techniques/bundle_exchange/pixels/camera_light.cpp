// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/pixels/camera_light.h"

#include <limits>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/late_weight.h"
#include "bundle_exchange/base/name.h"
#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"

namespace lucarium::bundle {
CameraLight::CameraLight(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                         const Intersector& intersector, const SurfaceAtlas& atlas, const SideMeans& means,
                         const SidePreview* preview, const Frame& frame, const Options& options)
    : scheduler_(&scheduler),
      options_(options),
      frame_(frame),
      pixels_(frame.width * frame.height),
      eye_(device, scheduler, scene, intersector, frame, technique_name,
           !options.exchanged ? DirectLight::kAllLights
           : options.punctual ? DirectLight::kPunctualLights
                              : 0u),
      atlas_light_(device, technique_name, pixels_, {"direct", "indirect"}),
      no_contributions_(device, technique_name, "nothing gathered", 2 * size_t{pixels_}, remedies::lower_size) {
  if (preview) smooth_light_ = LayerSums(device, technique_name, pixels_, {"direct", "indirect"});
  if (options.gather != FinalGather::off && options.by_bundles)
    bundles_ = std::make_unique<PixelGather>(device, scheduler, program, scene, intersector, atlas, means,
                                             eye_.points(), PixelGather::Options{pixels_, whole(), options.min_alpha});
  if (options.gather != FinalGather::off) {
    ChainTracer::Options chains;
    chains.targets = pixels_;
    chains.contributions = 2;
    chains.layout = CONTRIBUTION_LAYERS;
    chains.punctual = options.punctual;
    chains.what = "pixels";
    chains_ = std::make_unique<ChainTracer>(device, scheduler, program, scene, intersector, atlas,
                                            means.diffuse_shown(), means.halves(), chains);
    record_chains(program, scene);
  }
  record(device, program, atlas, means, preview);
}

size_t CameraLight::estimate_bytes(uint32_t width, uint32_t height, FinalGather gather, bool by_bundles, bool preview) {
  const size_t pixels = size_t{width} * height;
  const size_t chains =
      gather == FinalGather::off ? 2 * pixels * sizeof(float4) : ChainTracer::estimate_bytes(pixels, 2);
  return chains + (by_bundles ? PixelGather::estimate_bytes(pixels) : 0) + EyeLight::estimate_bytes(width, height) +
         LayerSums::estimate_bytes(pixels, preview ? 4 : 2);
}

void CameraLight::record(Device& device, const Program& program, const SurfaceAtlas& atlas, const SideMeans& means,
                         const SidePreview* preview) {
  ScheduleRecorder recorder = scheduler_->record("add light of the atlas", technique_name);
  atlas_weight_ = recorder.variable("atlas_weight", 1.f);
  atlas_samples_before_ = recorder.variable("samples", 0u);
  record_atlas_light(recorder, program, atlas, means.halves(), means.shown(), means.shown_direct(), atlas_light_, true);
  if (preview)
    record_atlas_light(recorder, program, atlas, means.halves(), preview->shown(), preview->shown_direct(),
                       smooth_light_, false);
  add_ = recorder.compile();
  const LayerSpread::Shown shown = {eye_.sums()["emission"], eye_.sums()["direct"], atlas_light_["indirect"]};
  spread_ = std::make_unique<LayerSpread>(device, *scheduler_, shown, eye_.deviations(), technique_name);
}

void CameraLight::record_atlas_light(ScheduleRecorder& recorder, const Program& program, const SurfaceAtlas& atlas,
                                     const SideHalves& halves, const TypedBuffer<float4>& shown,
                                     const TypedBuffer<float4>& shown_direct, const LayerSums& image, bool deviates) {
  PassBuilder add = recorder.pass("add light of the atlas", program, "add_atlas_light");
  atlas.bind(add);
  halves.bind(add);
  add.global(pixels_)
      .arg("points", eye_.points())
      .arg("count", pixels_)
      .arg("atlas_weight", atlas_weight_)
      .arg("samples", atlas_samples_before_)
      .arg("deviates", deviates ? 1u : 0u)
      .arg("whole", whole() ? 1u : 0u)
      .arg("shown", shown)
      .arg("shown_direct", shown_direct)
      .arg("bundled", bundled())
      .arg("gathered", gathered())
      .arg("exchanged", image["direct"])
      .arg("indirect", image["indirect"])
      .arg("deviations", eye_.deviations());
}

void CameraLight::record_chains(const Program& program, const SceneBuffers& scene) {
  ScheduleRecorder recorder = scheduler_->record("begin chains of pixels", technique_name);
  settings_ = recorder.variable("settings", ChainSettings{});
  PassBuilder begin = recorder.pass("begin chains of pixels", program, "begin_pixel_chains");
  scene.bind(begin);
  begin.global(pixels_)
      .arg("points", eye_.points())
      .arg("count", pixels_)
      .arg("whole", whole() && !bundles_ ? 1u : 0u)
      .arg("max_alpha", bundles_ ? options_.min_alpha : std::numeric_limits<float>::infinity())
      .arg("settings", settings_);
  const SpecularChains& chains = chains_->chains();
  begin.arg("contribution", chains_->contribution()).arg("chains", chains.chains()).arg("rays", chains.first_rays());
  begin.arg("queue", chains.queue()).arg("active", chains.active());
  begin_ = recorder.compile();
}

bool CameraLight::gather() {
  ChainSettings settings{};
  settings.seed = stream_seed(frame_.seed, 0x706978u, samples_);
  settings.first_light = options_.exchanged ? 1 : 2;  // else the first is DirectLight's
  settings.lit = 1;
  settings.max_vertices = options_.single ? 1 : SpecularChains::kMaxVertices;
  settings.limit = options_.max_bounces < 0 ? LUCARIUM_NONE : static_cast<uint32_t>(options_.max_bounces) + 1;
  begin_.set(settings_, settings);
  return scheduler_->run(begin_) == RunResult::done && chains_->chains().follow(settings);
}

bool CameraLight::begin_sample() {
  if (bundles_) bundles_->restart();
  return eye_.see(samples_);
}

bool CameraLight::sample() {
  if (!eye_.sample(samples_)) return false;
  const uint64_t before = rays();  // a cancelled sample has traced rays too
  if (chains_ && !gather()) return false;
  sample_rays_ = rays() - before;
  return true;
}

float CameraLight::atlas_weight() const {
  // The atlas that later samples saw was better, and a late image forgets what an early atlas did not know.
  return late_weight(atlas_samples_);
}

void CameraLight::commit(bool atlas_known, bool measured) {
  ++samples_;
  committed_rays_ += sample_rays_;
  add_.set(atlas_samples_before_, atlas_known ? atlas_samples_ : 0u);
  atlas_samples_ = atlas_known ? atlas_samples_ + 1 : 0;
  add_.set(atlas_weight_, atlas_weight());
  eye_.commit();
  scheduler_->run_to_end(add_);
  if (measured) spread_->measure();
}

void CameraLight::reset(uint32_t seed) {
  frame_.seed = seed;
  if (chains_) chains_->chains().reset_count();
  set_frame(frame_);
}

void CameraLight::set_frame(const Frame& frame) {
  const uint32_t seed = frame_.seed;
  frame_ = frame;
  frame_.seed = seed;
  eye_.set_frame(frame_);
  atlas_light_.clear();
  spread_->clear();
  smooth_light_.clear();
  samples_ = atlas_samples_ = 0;
  committed_rays_ = 0;
}

void CameraLight::warm_up() {
  eye_.warm_up();
  if (bundles_) bundles_->warm_up();
  if (chains_) {
    scheduler_->warm_up(begin_);
    chains_->chains().warm_up();
  }
  scheduler_->warm_up(add_);
  spread_->warm_up();
}

void CameraLight::resolve(Film& film, bool smoothed) const {
  scheduler_->finish();
  eye_.write(film);
  if (options_.debug) film.layer("sampled_direct").pixels = film.layer("direct", {"R", "G", "B"}, true).pixels;
  (smoothed ? smooth_light_ : atlas_light_).write(film);
}

}  // namespace lucarium::bundle
