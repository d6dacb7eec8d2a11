// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/hop_tracer.h"

namespace lucarium::bundle {
namespace {

const char* const kOwner = "bundle_exchange";

}  // namespace

HopTracer::HopTracer(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                     const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse,
                     const Options& options)
    : gain_(device, kOwner, "gains of " + options.what, size_t{options.targets} * options.gains),
      chains_(device, scheduler, scene, intersector, {options.targets, options.punctual, kOwner, options.what},
              {.program = program,
               .advance = "advance_hops",
               .add_light = "add_punctual",
               .bind_advance =
                   [=, &atlas, gain = gain_](PassBuilder& pass) {
                     atlas.bind(pass, program, "advance_hops");
                     pass.arg("diffuse", diffuse).arg("layout", options.layout).arg("gain", gain);
                   },
               .bind_add_light = [layout = options.layout,
                                  gain = gain_](PassBuilder& pass) { pass.arg("layout", layout).arg("gain", gain); }}) {
}

}  // namespace lucarium::bundle
