// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/byte_size.h"

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
  const std::string copy(text);
  char* end = nullptr;
  const double number = std::strtod(copy.c_str(), &end);
  std::string suffix(end);
  for (char& c : suffix) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  int exponent = 0;
  if (!suffix.empty() && suffix != "B") {
    const size_t unit = std::string_view("KMGT").find(suffix[0]);
    const std::string rest = suffix.substr(1);
    exponent =
        unit != std::string::npos && (rest.empty() || rest == "B" || rest == "IB") ? static_cast<int>(unit) + 1 : -1;
  }
  const bool starts_with_digit = !copy.empty() && (std::isdigit(static_cast<unsigned char>(copy[0])) || copy[0] == '.');
  if (!starts_with_digit || end == copy.c_str() || exponent < 0 || !std::isfinite(number)) {
    throw_error(ErrorClass::usage, "{}: '{}' is not a number of bytes; write for instance 800M or 2G", what, text);
  }
  const double bytes = std::ldexp(number, 10 * exponent);
  if (bytes >= std::ldexp(1.0, 63)) {
    throw_error(ErrorClass::usage, "{}: '{}' is more memory than any machine has", what, text);
  }
  return static_cast<size_t>(bytes);
}

}  // namespace lucarium
