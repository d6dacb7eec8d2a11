// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lucarium {

std::vector<std::string> split(std::string_view text, char separator);

/// "1 sample", "2 samples".
std::string counted(uint64_t count, std::string_view noun);

/// "'a', 'b', 'c', 'd', 'e' and 4 more".
std::string list_names(const std::vector<std::string>& names);

/// A finite number that fills the whole text, else empty.
std::optional<float> parse_number(std::string_view text);

/// Comma-separated finite numbers; empty when one is malformed.
std::optional<std::vector<float>> parse_numbers(std::string_view text);

/// "x,y,z".
std::optional<glm::vec3> parse_point(std::string_view text);

/// "r,g,b" or one number for all three; not negative.
std::optional<glm::vec3> parse_color(std::string_view text);

}  // namespace lucarium
