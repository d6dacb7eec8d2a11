// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/base/bundle_program.h"

#include <fmt/format.h>

const lucarium::EmbeddedSources& bundle_exchange_kernels();

namespace lucarium::bundle {

Program make_technique_program(Device& device, std::map<std::string, std::string> defines) {
  std::vector<std::string> files;
  for (const char* file :
       {"senders/make_senders", "senders/balance_power", "senders/accumulate_batch", "senders/measure_errors",
        "senders/make_display", "senders/finish_bounce", "senders/copy_materials", "senders/receive_history",
        "senders/send_history", "senders/smooth_preview", "specular/begin_side_chains", "specular/begin_pixel_chains",
        "specular/advance_chains", "specular/send_chain_light", "pixels/add_atlas_light", "pixels/gather_pixels",
        "pixels/gather_missed", "pixels/add_gathered"})
    files.push_back(fmt::format("bundle_exchange/{}", file));
  return make_program(device, bundle_exchange_kernels(), files, std::move(defines));
}

Program make_bundle_program(Device& device, const std::string& file, std::map<std::string, std::string> defines) {
  return make_program(device, bundle_exchange_kernels(), {"bundle_exchange/" + file}, std::move(defines));
}

PassBuilder surface_pass(ScheduleRecorder& recorder, const std::string& name, const Program& program,
                         const std::string& kernel, const SceneBuffers& scene, const SurfaceAtlas& atlas) {
  PassBuilder pass = recorder.pass(name, program, kernel);
  scene.bind(pass);
  atlas.bind(pass);
  return pass;
}

}  // namespace lucarium::bundle
