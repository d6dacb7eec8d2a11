// SPDX-License-Identifier: Apache-2.0
#include "bundle_program.h"

const lucarium::EmbeddedSources& bundle_exchange_kernels();

namespace lucarium::bundle {

Program make_bundle_program(Device& device, const std::string& file, std::map<std::string, std::string> defines) {
  SourceLibrary library;
  library.add(bundle_exchange_kernels());
  return Program(device, library, {"bundle_exchange/" + file, {"bundle_exchange/" + file + ".cl"}, std::move(defines)});
}

}  // namespace lucarium::bundle
