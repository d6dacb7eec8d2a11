// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "lucarium/technique/cost.h"
#include "virtual_light_field/base/plan.h"

namespace lucarium::vlf {

/// Seconds until the first picture with all its light, as Technique::estimate_seconds().
double estimate_seconds(const Plan& plan, const Parameters& parameters, const Scene& scene,
                        const RenderSettings& settings, const ComputePower& power);

/// Parts of an iteration [s of a core]: light samples of texel sides, pixels of subfields of which a share is drawn and
/// the rest kept, a sample of pixels.
double light_seconds(uint32_t samples);
double subfield_seconds(double subfield_pixels, double drawn);
double eye_seconds(uint32_t pixels);

/// Technique::savings().
std::vector<ParameterSaving> savings();

/// Device memory [bytes]. How many surfaces keep radiance by direction is taken from the materials; the field refuses
/// with the exact number when it is built.
size_t estimate_bytes(const Plan& plan, const Parameters& parameters, const Scene& scene,
                      const RenderSettings& settings);

}  // namespace lucarium::vlf
