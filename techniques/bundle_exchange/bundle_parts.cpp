// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/bundle_parts.h"

#include <fmt/format.h>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"

const lucarium::EmbeddedSources& bundle_exchange_kernels();

namespace lucarium::bundle {
namespace {

const char* const kOwner = "bundle_exchange";

Program make_program(Device& device, const Channels& channels) {
  std::vector<std::string> files;
  for (const char* file :
       {"senders/senders", "senders/fold", "texels/slot_openness", "texels/slot_light", "pixels/camera_light",
        "specular/hops", "senders/ring", "pixels/pixel_gather", "senders/preview"})
    files.push_back(fmt::format("bundle_exchange/{}", file));
  return make_program(device, bundle_exchange_kernels(), files, channels.defines());
}

std::unique_ptr<SurfaceAtlas> make_atlas(const TechniqueContext& c, SurfaceAtlasOptions options) {
  options.progress = [report = c.progress](double fraction, const std::string& stage) {
    report(fraction, "surface atlas, " + stage);
  };
  return std::make_unique<SurfaceAtlas>(*c.device, c.scheduler, c.scene, c.scene_buffers, options, kOwner);
}

}  // namespace

BundleParts::BundleParts(const TechniqueContext& c, const Parameters& p, const BundlePlan& plan, Kept kept)
    : atlas(kept.atlas ? std::move(kept.atlas) : make_atlas(c, plan.atlas)),
      program(make_program(*c.device, plan.channels)),
      exposure(kept.exposure ? std::move(kept.exposure)
                             : std::make_unique<TexelInterior>(*c.device, c.scheduler, c.scene_buffers, c.bvh(), *atlas,
                                                               kOwner, "lower texels")),
      openness(kept.openness
                   ? std::move(kept.openness)
                   : std::make_unique<SlotOpenness>(*c.device, c.scene_buffers, *atlas,
                                                    SlotOpenness::Options{p.pixel_size, p.open_gap, p.open_rays})),
      slot_light(*c.device, c.scheduler, program, c.scene_buffers, c.bvh(), *atlas, *openness, plan.light_kinds),
      means(*c.device, c.scheduler, program, *atlas, openness->shares(), slot_light.light_samples(), plan.channels, p),
      preview(plan.preview ? std::make_unique<SlotPreview>(*c.device, c.scheduler, program, *atlas, means) : nullptr),
      camera(*c.device, c.scheduler, program, c.scene_buffers, c.bvh(), *atlas, means, preview.get(),
             make_frame(c.settings), plan.camera),
      transfer(*c.device, c.scheduler, c.scene, c.scene_buffers, *atlas, means.records(), *exposure, *openness,
               plan.channels, {p.pixel_size, p.transfer, camera.pixel_gather()}) {
  if (!openness->complete())
    openness->begin(*c.device, c.scheduler, program, c.scene, c.scene_buffers, *atlas, *exposure, transfer.raster());
  if (!plan.reflects) return;
  specular =
      std::make_unique<SlotSpecular>(*c.device, c.scheduler, program, c.scene_buffers, c.bvh(), *atlas, means, p,
                                     !c.scene.lights.empty(), c.settings.max_bounces, p.transfer == Transfer::ray);
}

void BundleParts::measure_openness(const std::function<void(double, const std::string&)>& report) {
  const auto check = [](bool done) {
    if (!done)
      throw Error(ErrorClass::interrupted, "bundle_exchange: interrupted while texels were measured; nothing is kept");
  };
  for (; !exposure->complete(); report(exposure->progress(), "hidden places")) check(exposure->advance());
  for (; !openness->complete(); report(openness->progress(), openness->measured())) check(openness->advance());
  means.take_materials();
}

void BundleParts::warm_up() {
  slot_light.warm_up();
  means.warm_up();
  if (preview) preview->warm_up();
  if (specular) specular->warm_up();
  transfer.warm_up();
  camera.warm_up();
}

}  // namespace lucarium::bundle
