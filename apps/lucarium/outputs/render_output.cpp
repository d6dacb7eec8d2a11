// SPDX-License-Identifier: Apache-2.0
#include "outputs/render_output.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/terminal.h"
#include "lucarium/film/image_io.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

constexpr int max_frames = 100000;

/// "out.exr" → "out.0007.exr".
fs::path frame_file(const fs::path& file, int frame) {
  return file.parent_path() / fmt::format("{}.{:04}{}", file.stem().string(), frame, file.extension().string());
}

/// What the technique counts (rays, paths, …) and pixel samples, per second of iterating.
std::string rates(RenderSession& session) {
  const double seconds = session.clocks().iterate;
  const RenderSettings& settings = session.settings();
  const double samples = static_cast<double>(session.last().samples) * settings.width * settings.height;
  std::string text = fmt::format("{:.3f} Msamples/s", samples / 1e6 / seconds);
  for (const auto& [name, value] : session.technique().counters()) {
    if (value > 0) text += fmt::format(", {} {:.3f} M/s", name, value / 1e6 / seconds);
  }
  return text + "\n";
}

}  // namespace

std::optional<FrameRange> parse_frames(const std::string& text) {
  if (text.empty()) return std::nullopt;
  FrameRange range;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%7d:%7d%c", &range.first, &range.last, &rest) != 2 || range.first < 0 ||
      range.last < range.first || range.last - range.first >= max_frames) {
    throw_error(ErrorClass::usage, "--frames {} is not FIRST:LAST with at most {} frames", text, max_frames);
  }
  return range;
}

bool any_of_kind(const std::vector<fs::path>& files, const char* extension) {
  return std::any_of(files.begin(), files.end(), [&](const fs::path& file) { return file.extension() == extension; });
}

std::vector<std::vector<fs::path>> plan_outputs(const std::vector<fs::path>& files,
                                                const std::optional<FrameRange>& frames, bool overwrite) {
  for (const fs::path& file : files) check_image_name(file);
  std::vector<std::vector<fs::path>> outputs;
  for (int frame = frames ? frames->first : 0; frame <= (frames ? frames->last : 0); ++frame) {
    outputs.push_back(files);
    for (fs::path& file : outputs.back()) {
      if (frames) file = frame_file(file, frame);
      check_output(file, overwrite);
    }
  }
  return outputs;
}

void write_outputs(const std::vector<fs::path>& files, const Film& film, float exposure, bool half) {
  for (const fs::path& file : files) {
    if (file.extension() == ".png") {
      write_png(file, film, exposure);
    } else {
      write_exr(file, film, {half});
    }
  }
}

void write_profile(const std::string& file, RenderSession& session, bool json) {
  if (file.empty()) return;
  session.scheduler().finish();
  const Profile& profile = session.scheduler().profile();
  if (file == "-") {
    const std::string table = profile.table() + rates(session);
    if (json) {
      print_note("{}", table);
    } else {
      print_result("{}", table);
    }
  } else if (file.ends_with(".trace.json")) {
    write_file_atomically(file, profile.chrome_trace());
  } else {
    write_file_atomically(file, profile.json());
  }
}

}  // namespace lucarium::app
