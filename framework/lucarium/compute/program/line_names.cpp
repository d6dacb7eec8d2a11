// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/program/line_names.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "lucarium/base/log.h"

namespace lucarium {
namespace {

constexpr std::string_view unnamed = "<kernel>:", directive = "#line ";

/// Takes a number off the front of `text`; 0 where there is none.
size_t take_number(std::string_view& text) {
  size_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc()) return 0;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return number;
}

std::string_view take_line(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// The name between quotation marks, without the backslashes that protect characters.
std::string unquoted(std::string_view text) {
  std::string name;
  for (size_t i = text.find('"') + 1; i < text.size() && text[i] != '"'; ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) ++i;
    name += text[i];
  }
  return name;
}

/// A `#line` of a source: what it calls the line after it.
struct Mark {
  size_t after = 0;  // its own place in the source, from 1
  size_t number = 0;
  std::string file;
};

std::vector<Mark> marks_of(std::string_view source) {
  std::vector<Mark> marks;
  for (size_t place = 1; !source.empty(); ++place) {
    std::string_view line = take_line(source);
    if (!line.starts_with(directive)) continue;
    line.remove_prefix(directive.size());
    const size_t number = take_number(line);
    marks.push_back({place, number, unquoted(line)});
  }
  return marks;
}

}  // namespace

std::string name_lines(std::string_view log, std::string_view source) {
  if (log.find(unnamed) == std::string_view::npos) return std::string(log);
  const std::vector<Mark> marks = marks_of(source);
  std::string named;
  while (!log.empty()) {
    std::string_view line = take_line(log);
    if (line.starts_with(unnamed)) {
      std::string_view rest = line.substr(unnamed.size());
      const size_t place = take_number(rest);
      const auto next = std::find_if(marks.begin(), marks.end(), [&](const Mark& mark) { return mark.after >= place; });
      if (place > 0 && next != marks.begin()) {
        const Mark& mark = *std::prev(next);
        named += fmt::format("{}:{}", mark.file, mark.number + place - mark.after - 1);
        line = rest;
      }
    }
    named.append(line) += '\n';
  }
  return named;
}

}  // namespace lucarium
