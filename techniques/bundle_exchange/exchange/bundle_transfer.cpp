// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/exchange/bundle_transfer.h"

#include <algorithm>

#include "bundle_exchange/base/bundle_program.h"
#include "bundle_exchange/base/name.h"
#include "lucarium/compute/program/source_library.h"

namespace lucarium::bundle {
namespace {

LayeredRasterOptions raster_options(uint32_t edge) {
  LayeredRasterOptions options;
  options.max_width = options.max_height = edge;
  options.remedy = "raise pixel_size";
  return options;
}

/// Edge of bundle pixels [m]. Work-items that add to the same texel at a time would lose rays of it, and what they
/// touch is at least 16 pixels apart: no texel may be longer.
double usable_pixel(const BundleTransfer::Options& options, const SurfaceAtlas& atlas,
                    const SideAccessibility& accessibility) {
  const double wanted = options.pixel_size * static_cast<double>(atlas.info().texel_edge);
  return options.transfer == Transfer::texel ? wanted : std::max(wanted, accessibility.safe_pixel());
}

}  // namespace

BundleTransfer::BundleTransfer(Device& device, KernelScheduler& scheduler, const Scene& scene,
                               const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                               const TypedBuffer<float4>& records, const TexelInterior& interior,
                               const SideAccessibility& accessibility, const Channels& channels, const Options& options)
    : scheduler_(&scheduler),
      channels_(channels),
      options_(options),
      bounds_(scene.bounds()),
      pixel_(usable_pixel(options, atlas, accessibility)),
      image_edge_(bundle_side(bounds_, pixel_)),
      raster_(scheduler, buffers, raster_options(image_edge_), technique_name),
      views_(device, technique_name, "view of a direction", 1),
      ends_(device, technique_name, "ends of rays", 2) {
  all_ = record(device, buffers, atlas, records, interior, accessibility, What::all);
  if (channels.exchanged() && channels.reflected() > 0)
    emission_ = record(device, buffers, atlas, records, interior, accessibility, What::emission);
  if (options.gather) gather_ = record(device, buffers, atlas, records, interior, accessibility, What::gather);
}

BundleTransfer::Recorded BundleTransfer::record(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                                                const TypedBuffer<float4>& records, const TexelInterior& interior,
                                                const SideAccessibility& accessibility, What what) {
  const char* const names[] = {"exchange", "exchange of emission", "gather"};
  const Program begin_program(
      device, SourceLibrary(),
      {"services/texel_sides/begin_direction", {"lucarium/services/texel_sides/begin_direction.cl"}, {}});
  const bool by_texels = options_.transfer == Transfer::texel;
  Recorded result;
  ScheduleRecorder recorder = scheduler_->record(names[static_cast<int>(what)], technique_name);
  result.view = recorder.variable("view", LayeredView{});
  result.omega = recorder.variable("omega", float4(0, 0, 1, 0));
  result.weight = recorder.variable("weight", 1.f);
  const LayeredRaster::ViewRef view{views_, recorder.variable("view index", 0u)};
  PassBuilder begin = recorder.pass("begin direction", begin_program, "begin_direction");
  buffers.bind(begin);
  begin.global(1)
      .local(1)
      .arg("view", result.view)
      .arg("omega", result.omega)
      .arg("emission", channels_.emission ? 1u : 0u)
      .arg("views", views_)
      .arg("ends", ends_);
  if (what == What::gather) {
    result.first = recorder.variable("first", 1u);
    options_.gather->record(recorder, raster_.record_stored(recorder, "fragments", view), views_, ends_, result.first,
                            result.weight);
  } else {
    const SideHalves halves = accessibility.side_halves();
    std::map<std::string, std::string> defines = channels_.defines();
    if (what == What::emission) defines["BUNDLE_ACTIVE"] = "1u";
    const char* const kernel = by_texels ? "exchange_texels" : "exchange_pairs";
    if (!by_texels) {
      defines.merge(raster_.defines());
      defines.merge(halves.defines());
    }
    const Program program = make_bundle_program(device, std::string("exchange/") + kernel, defines);
    const auto bind = [&](PassBuilder& pass) {
      atlas.bind(pass);
      pass.arg("accessibility", accessibility.parts())
          .arg("weight", result.weight)
          .arg("ends", ends_)
          .arg("records", records)
          .arg("interior", interior.shares());
    };
    if (by_texels) {
      const LayeredRaster::Stored stored = raster_.record_stored(recorder, "fragments", view);
      PassBuilder pass = recorder.pass("exchange", program, kernel);
      buffers.bind(pass);
      bind(pass);
      halves.bind(pass);
      pass.global(atlas.info().texel_count)
          .arg("sides", atlas.info().texel_count)
          .arg("views", views_)
          .arg("pixel_start", stored.pixel_start)
          .arg("fragments", stored.fragments);
    } else {
      raster_.record_tiles(recorder, "exchange", view, program, kernel, [&](PassBuilder& pass) {
        bind(pass);
        if (halves.two()) pass.arg("covered", halves.covered);
      });
    }
  }
  result.schedule = recorder.compile();
  return result;
}

void BundleTransfer::run(Recorded& recorded, const BundleDirection& direction, uint32_t seed, bool per_ray) {
  const BundleView view = make_bundle_view(bounds_, direction, pixel_, seed);
  ++images_;
  image_pixels_ += static_cast<double>(view.view.width) * view.view.height;
  recorded.schedule.set(recorded.view, view.view);
  recorded.schedule.set(recorded.omega, float4(direction.direction, 0.f));
  recorded.schedule.set(recorded.weight, static_cast<float>(direction.weight * (per_ray ? view.pixel_area : 1.0)));
  scheduler_->run_to_end(recorded.schedule);  // half a bundle image would be counted twice
}

void BundleTransfer::exchange(const BundleDirection& direction, uint32_t seed) {
  run(all_, direction, seed, options_.transfer == Transfer::ray);
}

void BundleTransfer::exchange_emission(const BundleDirection& direction, uint32_t seed) {
  run(emission_.schedule ? emission_ : all_, direction, seed, options_.transfer == Transfer::ray);
}

void BundleTransfer::gather(const BundleDirection& direction, uint32_t seed, bool first) {
  gather_.schedule.set(gather_.first, first ? 1u : 0u);
  run(gather_, direction, seed, false);
}

size_t BundleTransfer::estimate_bytes(const Scene& scene, double texel_edge, const Parameters& parameters,
                                      bool gathers) {
  const uint32_t edge = bundle_side(scene.bounds(), static_cast<double>(parameters.pixel_size) * texel_edge);
  std::optional<LayeredStoreOptions> stored;
  if (gathers || parameters.transfer == Transfer::texel) stored.emplace();
  return LayeredRaster::estimate_bytes(static_cast<size_t>(scene.triangle_count()), raster_options(edge), stored);
}

void BundleTransfer::warm_up() {
  for (Recorded* recorded : {&all_, &emission_, &gather_})
    if (recorded->schedule) scheduler_->warm_up(recorded->schedule);
}
}  // namespace lucarium::bundle
