// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/identifiers.h"

#include <cctype>
#include <vector>

namespace lucarium {

std::unordered_set<std::string_view> identifiers_of(std::string_view source) {
  std::unordered_set<std::string_view> found;
  const auto is_part = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  for (size_t at = 0; at < source.size();) {
    const size_t first = at;
    while (at < source.size() && is_part(source[at])) ++at;
    if (at > first) found.insert(source.substr(first, at - first));
    if (at == first) ++at;
  }
  return found;
}

namespace {

/// Whether some of `words`, one behind the other, are `name`.
bool is_made_of(std::string_view name, const std::unordered_set<std::string_view>& words) {
  std::vector<bool> reached(name.size() + 1);
  reached[0] = true;
  for (size_t end = 1; end <= name.size(); ++end) {
    for (size_t begin = 0; begin < end && !reached[end]; ++begin)
      reached[end] = reached[begin] && words.contains(name.substr(begin, end - begin));
  }
  return reached[name.size()];
}

}  // namespace

std::map<std::string, std::string> named_defines(const std::map<std::string, std::string>& defines,
                                                 std::string_view sources) {
  std::string text(sources);
  for (const auto& [name, value] : defines) text += "\n" + value;
  const std::unordered_set<std::string_view> identifiers = identifiers_of(text);
  const bool pastes = text.find("##") != std::string::npos;
  std::map<std::string, std::string> named;
  for (const auto& [name, value] : defines) {
    const std::string_view macro = std::string_view(name).substr(0, name.find('('));  // of "MACRO(parameter)", too
    if (identifiers.contains(macro) || (pastes && is_made_of(macro, identifiers))) named.emplace(name, value);
  }
  return named;
}

}  // namespace lucarium
