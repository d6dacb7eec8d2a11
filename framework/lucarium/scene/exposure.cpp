// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/exposure.h"

#include "lucarium/base/error.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium {

float parse_exposure(std::string_view text) {
  if (text == "auto") return exposure_automatic;
  const std::optional<float> stops = parse_number(text);
  if (!stops) throw_error(ErrorClass::usage, "exposure: '{}' is not a finite number of stops, or auto", text);
  return *stops;
}

std::string exposure_text(float exposure_stops) {
  return is_automatic(exposure_stops) ? std::string("auto") : fmt::format("{}", exposure_stops);
}

}  // namespace lucarium
