// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "lucarium/compute/schedule/schedule.h"

namespace lucarium::vlf {

/// Of the technique, and of the owner of its memory and schedules.
inline constexpr const char* technique_name = "virtual_light_field";

/// The program of one kernel file of the technique, FILE.cl.
Program make_field_program(Device& device, const std::string& file, std::map<std::string, std::string> defines = {});

}  // namespace lucarium::vlf
