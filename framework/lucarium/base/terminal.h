// SPDX-License-Identifier: Apache-2.0
// Standard output and standard error: checked text, checked writes. All output passes through here.
#pragma once
#include <fmt/format.h>

#include <string>
#include <string_view>

namespace lucarium {

/// The text with everything written out that a terminal would obey instead of show: control characters other than line
/// feed and tab, and marks that turn the direction of writing, as \u001b; bytes that are no UTF-8 become U+FFFD. Names
/// in files are strangers' texts. JSON stays the same JSON: such characters stand within its strings only.
std::string printable(std::string_view text);

/// The same with line feeds and tabs written out as well: for a name, or a message of one line.
std::string printable_line(std::string_view text);

/// Writes printable(text) to standard output. Throws Error{input} when it cannot be written (a full disk), except in an
/// interrupted run: its terminal may be gone, and saving its results matters more.
void print_text(std::string_view text);
template <class... Args>
void print_result(fmt::format_string<Args...> format, Args&&... args) {
  print_text(fmt::format(format, std::forward<Args>(args)...));
}

/// Hands to the system what was printed; throws as print_text() does. For rows that come slowly, and for the end.
void flush_results();

/// Writes printable(text) to standard error; failures are ignored, there is nowhere to report them.
void print_note_text(std::string_view text);
template <class... Args>
void print_note(fmt::format_string<Args...> format, Args&&... args) {
  print_note_text(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace lucarium
