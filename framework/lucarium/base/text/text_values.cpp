// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/text/text_values.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace lucarium {

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (size_t begin = 0;;) {
    const size_t end = text.find(separator, begin);
    parts.emplace_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

std::string counted(uint64_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string list_names(const std::vector<std::string>& names) {
  constexpr size_t shown = 5;
  const std::vector<std::string> first(names.begin(), names.begin() + static_cast<long>(std::min(shown, names.size())));
  const std::string rest = names.size() > shown ? fmt::format(" and {} more", names.size() - shown) : "";
  return fmt::format("'{}'{}", fmt::join(first, "', '"), rest);
}

std::optional<float> parse_number(std::string_view text) {
  float value = 0;
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<std::vector<float>> parse_numbers(std::string_view text) {
  std::vector<float> values;
  for (const std::string& part : split(text, ',')) {
    const std::optional<float> value = parse_number(part);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

std::optional<glm::vec3> parse_point(std::string_view text) {
  const auto v = parse_numbers(text);
  if (!v || v->size() != 3) return std::nullopt;
  return glm::vec3((*v)[0], (*v)[1], (*v)[2]);
}

std::optional<glm::vec3> parse_color(std::string_view text) {
  const auto v = parse_numbers(text);
  if (!v || (v->size() != 1 && v->size() != 3)) return std::nullopt;
  for (const float c : *v) {
    if (c < 0) return std::nullopt;
  }
  return v->size() == 1 ? glm::vec3((*v)[0]) : glm::vec3((*v)[0], (*v)[1], (*v)[2]);
}

}  // namespace lucarium
