// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program_cache.h"

namespace lucarium {

ProgramCache::ProgramCache(const DeviceOptions&) {}

}  // namespace lucarium
