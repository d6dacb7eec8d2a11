// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "lucarium/film/film.h"

namespace lucarium {

/// Names of the film's layers.
std::vector<std::string> layer_names(const Film& film);

/// The layer of that name, else the image, as picture_code.h says, three channels in all cases. The header gets
/// "exposure" [stops]: the scene's, or where that is automatic, what suits the picture.
std::string encode_film(nlohmann::ordered_json header, const Film& film, const std::string& layer, float exposure);

/// An EXR file with all layers, or a PNG at an exposure, as a message: encode_view_file() of its bytes.
std::string encode_file(const std::string& kind, float exposure, const Film& film);

}  // namespace lucarium
