// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "lucarium/compute/program.h"

namespace lucarium::bundle {

/// The program of one kernel file of the technique, FILE.cl.
Program make_bundle_program(Device& device, const std::string& file, std::map<std::string, std::string> defines);

}  // namespace lucarium::bundle
