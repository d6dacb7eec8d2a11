// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/text/byte_size.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "lucarium/base/error.h"

namespace lucarium {

std::string format_bytes(size_t bytes) {
  constexpr const char* units[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  if (bytes < 1024) return fmt::format("{} bytes", bytes);
  double value = static_cast<double>(bytes) / 1024;
  int unit = 0;
  for (; value >= 1024 && unit < 5; ++unit) value /= 1024;
  return fmt::format("{:.{}f} {}", value, value < 10 ? 2 : 1, units[unit]);
}

size_t parse_bytes(std::string_view text, std::string_view what) {
  const size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  const std::string number(text.substr(0, digits));
  char* end = nullptr;
  const double value = std::strtod(number.c_str(), &end);
  std::string unit(text.substr(digits));
  for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const std::string_view ending : {"IB", "B"}) {
    if (unit.ends_with(ending)) unit.erase(unit.size() - ending.size());
  }
  constexpr std::string_view units = "KMGT";
  const bool known = unit.empty() || (unit.size() == 1 && units.find(unit) != std::string_view::npos);
  if (number.empty() || end == number.c_str() || *end || !known) {
    throw_error(ErrorClass::usage, "{}: '{}' is not a number of bytes; write for instance 800M or 2G", what, text);
  }
  const int exponent = unit.empty() ? 0 : static_cast<int>(units.find(unit)) + 1;
  const double bytes = std::ldexp(value, 10 * exponent);
  if (bytes < 1)
    throw_error(ErrorClass::usage, "{}: '{}' leaves no memory at all; write for instance 800M or 2G", what, text);
  if (bytes >= std::ldexp(1.0, 63)) {
    throw_error(ErrorClass::usage, "{}: '{}' is more memory than any machine has", what, text);
  }
  return static_cast<size_t>(bytes);
}

}  // namespace lucarium
