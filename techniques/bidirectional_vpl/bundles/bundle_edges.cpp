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
                            {"bidirectional_vpl/bundles/bundle_views", "bidirectional_vpl/bundles/look_up_bundle"},
                            bundle_defines(plan))),
      views_(device, owner, "views of bundles", plan.settings.bundles, "lower bundles"),
      keys_(device, owner, "bundles of rays", plan.settings.pixels, remedies::lower_size),
      order_(device, owner, "rays by bundle", plan.settings.pixels, remedies::lower_size),
      starts_(device, owner, "first rays of bundles", plan.settings.bundles + 1),
      ranges_(plan.settings.bundles + 1) {
  record_prepare(rays);
  record_look_up(rays);
}

void BundleEdges::record_prepare(const BundleRays& rays) {
  ScheduleRecorder recorder = scheduler_.record("views of bundles", owner_);
  seed_ = recorder.variable("seed", 0u);
  sample_ = recorder.variable("sample", 0u);
  depth_ = recorder.variable("depth", 0u);
  const uint32_t pixels = plan_.settings.pixels, bundles = plan_.settings.bundles;
  const uint32_t chunks = divide_up(pixels, kBoundsChunk);
  recorder.pass("split.key", program_, "key_bundle_rays")
      .global(pixels)
      .slice(kSlice)
      .arg("settings", plan_.settings)
      .arg("queue", rays.queue)
      .arg("active", rays.active)
      .arg("states", rays.states)
      .arg("keys", keys_)
      .arg("values", order_);
  primitives_.record_sort_pairs(recorder, "split.sort", keys_, order_, pixels, std::bit_width(bundles + 1));
  recorder.pass("split.ranges", program_, "find_bundle_starts")
      .global(bundles + 1)
      .arg("settings", plan_.settings)
      .arg("keys", keys_)
      .arg("starts", starts_);
  const BufferRef bounds = recorder.transient<float4>("bounds of points", size_t{2} * chunks);
  recorder.pass("bounds", program_, "bound_bundle_points")
      .global(chunks)
      .local(1)
      .arg("queue", rays.queue)
      .arg("active", rays.active)
      .arg("states", rays.states)
      .arg("rays", rays.rays)
      .arg("chunk", kBoundsChunk)
      .arg("chunks", chunks)
      .arg("bounds", bounds);
  PassBuilder views = recorder.pass("bounds.views", program_, "make_bundle_views");
  scene_.bind(views);
  views.global(bundles)
      .arg("settings", plan_.settings)
      .arg("seed", seed_)
      .arg("sample_index", sample_)
      .arg("depth", depth_)
      .arg("side", plan_.bundle_res)
      .arg("bounds", bounds)
      .arg("chunks", chunks)
      .arg("views", views_);
  recorder.read_back("first rays of bundles", starts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(ranges_.data(), bytes.data(), bytes.size());
  });
  prepare_ = recorder.compile();
}

void BundleEdges::record_look_up(const BundleRays& rays) {
  ScheduleRecorder recorder = scheduler_.record("bundle", owner_);
  number_ = recorder.variable("bundle", 0u);
  const LayeredRaster::Stored stored =
      raster_.record_stored(recorder, "bundles", {views_, number_}, store_options(plan_));
  PassBuilder look_up = recorder.pass("shading.look_up", program_, "look_up_bundle");
  scene_.bind(look_up);
  look_up.global(divide_up(plan_.settings.pixels, kLookUpChunk))
      .slice(kSlice / kLookUpChunk)
      .arg("number", number_)
      .arg("chunk", kLookUpChunk)
      .arg("starts", starts_)
      .arg("order", order_)
      .arg("views", views_)
      .arg("pixel_start", stored.pixel_start)
      .arg("fragments", stored.fragments)
      .arg("rays", rays.rays)
      .arg("queue", rays.queue)
      .arg("states", rays.states)
      .arg("hits", rays.hits);
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
  look_up_ = recorder.compile();
}

bool BundleEdges::trace(uint32_t seed, uint32_t sample, uint32_t depth) {
  if (depth == 0) new_bundles_ = new_fragments_ = 0;
  prepare_.set(seed_, seed);
  prepare_.set(sample_, sample);
  prepare_.set(depth_, depth);
  if (scheduler_.run(prepare_) == RunResult::cancelled) return false;
  for (uint32_t k = 0; k < plan_.settings.bundles; ++k) {
    if (ranges_[k] == ranges_[k + 1]) continue;
    look_up_.set(number_, k);
    if (scheduler_.run(look_up_) == RunResult::cancelled) return false;
    ++new_bundles_;
    new_fragments_ += total_;
  }
  return true;
}

void BundleEdges::complete() {
  bundles_ += new_bundles_;
  fragments_ += new_fragments_;
}

bool BundleEdges::update() {
  raster_.update();
  return raster_.generation() == generation_;
}

void BundleEdges::warm_up() {
  scheduler_.warm_up(prepare_);
  scheduler_.warm_up(look_up_);
}

size_t BundleEdges::estimate_bytes(const Plan& plan, size_t triangles) {
  // Sorting takes as much again.
  return size_t{plan.settings.pixels} * 4 * sizeof(uint32_t) + plan.settings.bundles * sizeof(LayeredView) +
         LayeredRaster::estimate_bytes(triangles, raster_options(plan), store_options(plan));
}

}  // namespace lucarium::bidirectional
