// SPDX-License-Identifier: Apache-2.0
#include "virtual_light_field/base/field_program.h"

const lucarium::EmbeddedSources& virtual_light_field_kernels();

namespace lucarium::vlf {

Program make_field_program(Device& device, const std::string& file, std::map<std::string, std::string> defines) {
  return make_program(device, virtual_light_field_kernels(), {"virtual_light_field/" + file}, std::move(defines));
}

}  // namespace lucarium::vlf
