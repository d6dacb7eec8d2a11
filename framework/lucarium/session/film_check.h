// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/film/film.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

/// What a technique has written. Throws Error{technique} on layers of the wrong size, on NaN and infinity, and where no
/// layer is of the image; warns about negative radiance.
void check_film(const Film& film, const TechniqueInfo& info);

}  // namespace lucarium
