// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "bars.h"
#include "lucarium/scene/scene.h"

namespace lucarium::bench {

struct Effort {
  int rounds = 5;          ///< of contestants
  uint32_t width = 128;    ///< of square pictures whose errors are measured
  uint32_t samples = 64;   ///< of a picture whose error is measured
  uint32_t reference = 4;  ///< times as many, of each of two references
  uint32_t seeds = 6;
  std::string scene;  ///< of those beside path_tracing; empty: all
};

/// Beside path_tracing, at equal time.
void measure_paths(Bars& bars, const Effort& effort);
/// What ways of connecting, longer light paths and weights are worth.
void measure_ways(Bars& bars, const Effort& effort);
/// Stored bundles and maps of virtual lights beside rays.
void measure_stored(Bars& bars, const Effort& effort);
/// Candidates, rays of light paths, threads.
void measure_rates(Bars& bars, const Effort& effort);
/// The second of these alone.
void measure_light_rays(Bars& bars, const Effort& effort);

/// The closed room of 70 000 triangles with a lamp and a point light, seen from a corner.
Scene make_lit_room();

}  // namespace lucarium::bench
