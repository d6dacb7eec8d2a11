// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/terminal.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/utf8.h"

namespace lucarium {
namespace {

constexpr uint32_t no_character = 0xffffffff;

struct Decoded {
  uint32_t character = no_character;  ///< no_character: these bytes are no UTF-8
  size_t bytes = 1;
};

/// The first character of a text that is not empty (RFC 3629: shortest form, no surrogates, at most U+10FFFF).
Decoded decode(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < length) return {};
  uint32_t character = lead & (0xffu >> (length + 1));
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    character = character << 6 | (byte(i) & 0x3fu);
  }
  constexpr uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = character >= 0xd800 && character <= 0xdfff;
  if (character < smallest[length] || surrogate || character > 0x10ffff) return {};
  return {character, length};
}

/// C0 and C1 controls, DEL, and the marks of Unicode's bidirectional algorithm.
bool is_obeyed(uint32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x061c || c == 0x200e || c == 0x200f ||
         (c >= 0x2028 && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

std::string written_out(std::string_view text, std::string_view kept) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const Decoded next = decode(text);
    if (next.character == no_character)
      result += "\xef\xbf\xbd";
    else if (is_obeyed(next.character) && kept.find(text.front()) == std::string_view::npos)
      result += fmt::format("\\u{:04x}", next.character);
    else
      result += text.substr(0, next.bytes);
    text.remove_prefix(next.bytes);
  }
  return result;
}

void fail_to_print() {
  if (interrupt_requested()) return;
  throw_error(ErrorClass::input, "cannot write to standard output: {}", std::strerror(errno ? errno : EIO));
}

}  // namespace

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const Decoded next = decode(text);
    if (next.character == no_character) return false;
    text.remove_prefix(next.bytes);
  }
  return true;
}

std::string printable(std::string_view text) { return written_out(text, "\n\t"); }
std::string printable_line(std::string_view text) { return written_out(text, ""); }

void print_text(std::string_view text) {
  const std::string shown = printable(text);
  errno = 0;
  if (std::fwrite(shown.data(), 1, shown.size(), stdout) != shown.size()) fail_to_print();
}

void flush_results() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout)) fail_to_print();
}

void print_note_text(std::string_view text) {
  const std::string shown = printable(text);
  [[maybe_unused]] const size_t written = std::fwrite(shown.data(), 1, shown.size(), stderr);
}

}  // namespace lucarium
