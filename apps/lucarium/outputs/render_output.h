// SPDX-License-Identifier: Apache-2.0
// What lucarium render writes.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/film/film.h"
#include "lucarium/session/session.h"

namespace lucarium::app {

struct FrameRange {
  int first = 0, last = 0;
};

/// "FIRST:LAST"; nothing of an empty text. Throws Error{usage}.
std::optional<FrameRange> parse_frames(const std::string& text);

bool any_of_kind(const std::vector<std::filesystem::path>& files, const char* extension);

/// The files of every frame, checked as in check_output(); one entry without frames.
std::vector<std::vector<std::filesystem::path>> plan_outputs(const std::vector<std::filesystem::path>& files,
                                                             const std::optional<FrameRange>& frames, bool overwrite);

/// Each file by its extension; `exposure` [stops] of pictures, `half`: 16-bit floats in .exr.
void write_outputs(const std::vector<std::filesystem::path>& files, const Film& film, float exposure, bool half);

/// Where the time went: "-" as a table on standard output, which goes to standard error where that is for JSON; else a
/// file; nothing without a name.
void write_profile(const std::string& file, RenderSession& session, bool json);

}  // namespace lucarium::app
