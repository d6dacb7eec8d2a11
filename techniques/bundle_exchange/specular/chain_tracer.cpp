// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/specular/chain_tracer.h"

#include "bundle_exchange/base/name.h"

namespace lucarium::bundle {

ChainTracer::ChainTracer(Device& device, KernelScheduler& scheduler, const Program& program, const SceneBuffers& scene,
                         const Intersector& intersector, const SurfaceAtlas& atlas, const TypedBuffer<float4>& diffuse,
                         const SideHalves& halves, const Options& options)
    : contribution_(device, technique_name, "found for " + options.what,
                    size_t{options.targets} * options.contributions),
      chains_(device, scheduler, scene, intersector, {options.targets, options.punctual, technique_name, options.what},
              {.program = program,
               .advance = "advance_texel_chains",
               .add_light = "add_punctual",
               .bind_advance =
                   [=, &atlas, contribution = contribution_](PassBuilder& pass) {
                     atlas.bind(pass);
                     halves.bind(pass);
                     pass.arg("diffuse", diffuse).arg("layout", options.layout).arg("contribution", contribution);
                   },
               .bind_add_light =
                   [layout = options.layout, contribution = contribution_](PassBuilder& pass) {
                     pass.arg("layout", layout).arg("contribution", contribution);
                   }}) {}

}  // namespace lucarium::bundle
