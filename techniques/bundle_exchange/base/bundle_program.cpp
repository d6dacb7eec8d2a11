// SPDX-License-Identifier: Apache-2.0
#include "bundle_exchange/base/bundle_program.h"

const lucarium::EmbeddedSources& bundle_exchange_kernels();

namespace lucarium::bundle {

Program make_bundle_program(Device& device, const std::string& file, std::map<std::string, std::string> defines) {
  return make_program(device, bundle_exchange_kernels(), {"bundle_exchange/" + file}, std::move(defines));
}

PassBuilder surface_pass(ScheduleRecorder& recorder, const std::string& name, const Program& program,
                         const std::string& kernel, const SceneBuffers& scene, const SurfaceAtlas& atlas) {
  PassBuilder pass = recorder.pass(name, program, kernel);
  scene.bind(pass, program, kernel);
  atlas.bind(pass, program, kernel);
  return pass;
}

}  // namespace lucarium::bundle
