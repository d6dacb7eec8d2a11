// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/bundles/bundle_edges.h"

#include <bit>
#include <cstring>

#include "lucarium/compute/device/remedies.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

constexpr size_t kSlice = 1 << 16;
constexpr uint32_t kBoundsChunk = 1 << 12, kLookUpChunk = 1 << 6;

uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

LayeredRasterOptions raster_options(const Plan& plan) {
  LayeredRasterOptions options;
  options.max_width = options.max_height = plan.bundle_res;
  options.conservative = options.keep_alpha = plan.bundle_mode == BundleMode::exact;
  options.remedy = "lower bundle_res, or set bundle_mode=rays";
  return options;
}

LayeredStoreOptions store_options(const Plan& plan) {
  LayeredStoreOptions options;
  if (plan.bundle_mode == BundleMode::linked_list) options.variant = LayeredVariant::linked_list;
  return options;
}

std::map<std::string, std::string> bundle_defines(const Plan& plan) {
  std::map<std::string, std::string> defines = plan_defines(plan);
  defines.emplace("LUCARIUM_JOINED", "1");
  if (plan.bundle_mode == BundleMode::exact) defines.emplace("BUNDLES_EXACT", "1");
  return defines;
}

}  // namespace

BundleEdges::BundleEdges(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Plan& plan,
                         const BundleRays& rays, const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      plan_(plan),
      owner_(owner),
      primitives_(device),
      raster_(scheduler, scene, raster_options(plan), owner),
      generation_(raster_.generation()),
      program_(make_program(device, bidirectional_vpl_kernels(),
                            {"bidirectional_vpl/bundles/bundle_views", "bidirectional_vpl/bundles/keep_bundle",
                             "bidirectional_vpl/bundles/look_up_bundle"},
                            bundle_defines(plan))),
      views_(device, owner, "views of bundles", plan.settings.bundles, "lower bundles"),
      keys_(device, owner, "bundles of rays", plan.settings.pixels, remedies::lower_size),
      order_(device, owner, "rays by bundle", plan.settings.pixels, remedies::lower_size),
      left_(device, owner, "triangles that rays leave", plan.settings.pixels, remedies::lower_size),
      starts_(device, owner, "first rays of bundles", plan.settings.bundles + 1),
      ranges_(plan.settings.bundles + 1) {
  if (plan.keeps_bundles() && KeptBundles::estimate_bytes(plan) > 0) kept_.emplace(device, plan, owner);
  record_prepare(rays);
  record_bundle(rays);
  if (kept_) record_again(rays);
}

void BundleEdges::record_prepare(const BundleRays& rays) {
  ScheduleRecorder recorder = scheduler_.record("views of bundles", owner_);
  seed_ = recorder.variable("seed", 0u);
  sample_ = recorder.variable("sample", 0u);
  depth_ = recorder.variable("depth", 0u);
  const uint32_t pixels = plan_.settings.pixels, bundles = plan_.settings.bundles;
  const uint32_t chunks = divide_up(pixels, kBoundsChunk);
  const BufferRef bounds = recorder.transient<float4>("bounds of points", size_t{2} * chunks);
  recorder.pass("split.key", program_, "key_bundle_rays")
      .global(chunks)
      .local(1)
      .arg("settings", plan_.settings)
      .arg("queue", rays.queue)
      .arg("active", rays.active)
      .arg("states", rays.states)
      .arg("rays", rays.rays)
      .arg("chunk", kBoundsChunk)
      .arg("keys", keys_)
      .arg("values", order_)
      .arg("left", left_)
      .arg("bounds", bounds);
  primitives_.record_sort_pairs(recorder, "split.sort", keys_, order_, pixels, std::bit_width(bundles + 1));
  recorder.pass("split.ranges", program_, "find_bundle_starts")
      .global(bundles + 1)
      .arg("settings", plan_.settings)
      .arg("keys", keys_)
      .arg("starts", starts_);
  PassBuilder views = recorder.pass("bounds.views", program_, "make_bundle_views");
  scene_.bind(views);
  views.global(bundles)
      .arg("settings", plan_.settings)
      .arg("seed", seed_)
      .arg("sample_index", sample_)
      .arg("depth", depth_)
      .arg("side", plan_.bundle_res)
      .arg("bounds", bounds)
      .arg("chunks", kept_ ? 0u : chunks)  // what is kept has to show all of the scene
      .arg("views", views_);
  recorder.read_back("first rays of bundles", starts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(ranges_.data(), bytes.data(), bytes.size());
  });
  prepare_ = recorder.compile();
}

template <class Base>
void BundleEdges::add_look_up(ScheduleRecorder& recorder, const BundleRays& rays, const Variable<uint32_t>& number,
                              const LayeredRaster::Stored& stored, const Base& start, const Base& fragment) {
  PassBuilder look_up = recorder.pass("shading.look_up", program_, "look_up_bundle");
  scene_.bind(look_up);
  look_up.global(divide_up(plan_.settings.pixels, kLookUpChunk))
      .slice(kSlice / kLookUpChunk)
      .arg("number", number)
      .arg("chunk", kLookUpChunk)
      .arg("start_base", start)
      .arg("fragment_base", fragment)
      .arg("starts", starts_)
      .arg("order", order_)
      .arg("views", views_)
      .arg("pixel_start", stored.pixel_start)
      .arg("fragments", stored.fragments)
      .arg("rays", rays.rays)
      .arg("left", left_)
      .arg("hits", rays.hits);
}

void BundleEdges::record_bundle(const BundleRays& rays) {
  ScheduleRecorder recorder = scheduler_.record("bundle", owner_);
  number_ = recorder.variable("bundle", 0u);
  const LayeredRaster::Stored stored =
      raster_.record_stored(recorder, "bundles", {views_, number_}, store_options(plan_));
  add_look_up(recorder, rays, number_, stored, 0u, 0u);
  if (kept_) {
    entry_ = recorder.variable("entry", 0u);
    first_ = recorder.variable("first", 0u);
    kept_->record_keep(recorder, program_, stored, entry_, first_);
  }
  const BufferRef total = recorder.transient<uint32_t>("number of fragments", 1);
  recorder.pass("bundles.total", program_, "count_fragments")
      .global(1)
      .local(1)
      .arg("views", views_)
      .arg("number", number_)
      .arg("pixel_start", stored.pixel_start)
      .arg("total", total);
  recorder.read_back("number of fragments", total,
                     [this](std::span<const std::byte> bytes) { std::memcpy(&total_, bytes.data(), sizeof total_); });
  bundle_ = recorder.compile();
}

void BundleEdges::record_again(const BundleRays& rays) {
  ScheduleRecorder recorder = scheduler_.record("kept bundle", owner_);
  again_number_ = recorder.variable("bundle", 0u);
  again_start_ = recorder.variable("start", 0u);
  again_fragment_ = recorder.variable("fragment", 0u);
  add_look_up(recorder, rays, again_number_, {kept_->starts(), kept_->fragments(), {}}, again_start_, again_fragment_);
  again_ = recorder.compile();
}

/// What the rays of bundle k meet.
bool BundleEdges::look_up(uint32_t k) {
  if (kept_) {
    if (const std::optional<KeptBundles::Place> place = kept_->find(k)) {
      again_.set(again_number_, k);
      again_.set(again_start_, place->entry * (plan_.bundle_res * plan_.bundle_res + 1));
      again_.set(again_fragment_, place->first);
      if (scheduler_.run(again_) == RunResult::cancelled) return false;
      ++new_.again;
      return true;
    }
    bundle_.set(entry_, kept_->next().entry);
    bundle_.set(first_, kept_->next().first);
  }
  bundle_.set(number_, k);
  if (scheduler_.run(bundle_) == RunResult::cancelled) return false;
  if (kept_) kept_->stored(k, total_);
  ++new_.bundles;
  new_.fragments += total_;
  return true;
}

bool BundleEdges::trace(uint32_t seed, uint32_t sample, uint32_t depth) {
  if (depth == 0) {
    new_ = {};
    if (kept_) kept_->clear();
  }
  prepare_.set(seed_, seed);
  prepare_.set(sample_, sample);
  prepare_.set(depth_, kept_ ? 0u : depth);  // of all depths the same views
  if (scheduler_.run(prepare_) == RunResult::cancelled) return false;
  for (uint32_t k = 0; k < plan_.settings.bundles; ++k)
    if (ranges_[k] != ranges_[k + 1] && !look_up(k)) return false;
  return true;
}

void BundleEdges::complete() {
  totals_.bundles += new_.bundles;
  totals_.fragments += new_.fragments;
  totals_.again += new_.again;
  new_ = {};  // an iteration whose paths all end at first hits traces none
}

std::map<std::string, double> BundleEdges::counters() const {
  return {{"bundles", totals_.bundles}, {"bundle_fragments", totals_.fragments}, {"bundles_again", totals_.again}};
}

bool BundleEdges::update() {
  raster_.update();
  return raster_.generation() == generation_;
}

void BundleEdges::warm_up() {
  scheduler_.warm_up(prepare_);
  scheduler_.warm_up(bundle_);
  if (kept_) scheduler_.warm_up(again_);
}

size_t BundleEdges::estimate_bytes(const Plan& plan, size_t triangles) {
  // Keys, order and triangles that rays leave; sorting takes the first two again.
  return size_t{plan.settings.pixels} * 5 * sizeof(uint32_t) + plan.settings.bundles * sizeof(LayeredView) +
         LayeredRaster::estimate_bytes(triangles, raster_options(plan), store_options(plan)) +
         (plan.keeps_bundles() ? KeptBundles::estimate_bytes(plan) : 0);
}

}  // namespace lucarium::bidirectional
