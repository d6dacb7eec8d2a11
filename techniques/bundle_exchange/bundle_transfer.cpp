// SPDX-License-Identifier: Apache-2.0
#include "bundle_transfer.h"

const lucarium::EmbeddedSources& bundle_exchange_kernels();

namespace lucarium::bundle {
namespace {

const char* const kOwner = "bundle_exchange";

LayeredRasterOptions raster_options(uint32_t side) {
  LayeredRasterOptions options;
  options.max_width = options.max_height = side;
  return options;
}

Program make_program(Device& device, const char* file, std::map<std::string, std::string> defines) {
  SourceLibrary library;
  library.add(bundle_exchange_kernels());
  return Program(device, library, {std::string("bundle_exchange/") + file, {std::string("bundle_exchange/") + file + ".cl"}, std::move(defines)});
}

}  // namespace

BundleTransfer::BundleTransfer(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                               const SurfaceAtlas& atlas, const TypedBuffer<float4>& records, const Channels& channels,
                               float pixel_size)
    : scheduler_(&scheduler),
      channels_(channels),
      bounds_(scene.bounds()),
      pixel_(pixel_size * static_cast<double>(atlas.info().texel_edge)),
      side_(film_side(bounds_, pixel_)),
      raster_(scheduler, buffers, raster_options(side_), kOwner),
      views_(device, kOwner, "view of a direction", 1),
      ends_(device, kOwner, "ends of rays", 2) {
  all_ = record(device, buffers, atlas, records, false);
  if (channels.exchanged() && channels.reflected() > 0) direct_ = record(device, buffers, atlas, records, true);
}

BundleTransfer::Recorded BundleTransfer::record(Device& device, const SceneBuffers& buffers, const SurfaceAtlas& atlas,
                                                const TypedBuffer<float4>& records, bool direct_only) {
  const Program begin_program = make_program(device, "begin_direction", {});
  std::map<std::string, std::string> defines = raster_.defines();
  for (const auto& [name, value] : channels_.defines()) defines[name] = value;
  if (direct_only) defines["BUNDLE_ACTIVE"] = "1u";
  const Program program = make_program(device, "exchange_rows", defines);
  Recorded result;
  ScheduleRecorder recorder = scheduler_->record(direct_only ? "exchange of emission" : "exchange", kOwner);
  result.view = recorder.variable("view", LayeredView{});
  result.omega = recorder.variable("omega", float4(0, 0, 1, 0));
  result.weight = recorder.variable("weight", 1.f);
  const Variable<uint32_t> first_view = recorder.variable("view index", 0u);
  PassBuilder begin = recorder.pass("begin direction", begin_program, "begin_direction");
  buffers.bind(begin, begin_program, "begin_direction");
  begin.global(1)
      .local(1)
      .arg("view", result.view)
      .arg("omega", result.omega)
      .arg("emission", channels_.emission ? 1u : 0u)
      .arg("views", views_)
      .arg("ends", ends_);
  raster_.record_tiles(recorder, "exchange", {views_, first_view}, program, "exchange_rows", [&](PassBuilder& pass) {
    atlas.bind(pass, program, "exchange_rows");
    pass.arg("weight", result.weight).arg("ends", ends_).arg("records", records);
  });
  result.schedule = recorder.compile();
  return result;
}

bool BundleTransfer::exchange(const Direction& direction, uint32_t seed, bool direct_only) {
  const BundleView view = make_bundle_view(bounds_, direction, pixel_, seed);
  Recorded& recorded = direct_only && direct_.schedule ? direct_ : all_;
  recorded.schedule.set(recorded.view, view.view);
  recorded.schedule.set(recorded.omega, float4(direction.direction, 0.f));
  recorded.schedule.set(recorded.weight, static_cast<float>(direction.weight * view.pixel_area));
  return scheduler_->run(recorded.schedule) == RunResult::done;
}

void BundleTransfer::warm_up() {
  scheduler_->warm_up(all_.schedule);
  if (direct_.schedule) scheduler_->warm_up(direct_.schedule);
}

double BundleTransfer::film_pixels() const { return static_cast<double>(side_) * side_; }

}  // namespace lucarium::bundle
