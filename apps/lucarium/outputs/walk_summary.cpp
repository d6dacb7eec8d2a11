// SPDX-License-Identifier: Apache-2.0
#include "outputs/walk_summary.h"

#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"
#include "lucarium/metrics/metrics.h"

namespace lucarium::app {

namespace {

double relmse_against(const std::filesystem::path& file, const RenderSettings& settings,
                      const std::vector<float>& image) {
  const Film truth = read_image(file);
  if (truth.width() != settings.width || truth.height() != settings.height)
    throw_error(ErrorClass::input, "{} is {}×{}, the rendering {}×{}", file.string(), truth.width(), truth.height(),
                settings.width, settings.height);
  return MetricReference(settings.width, settings.height, truth.image(), {0, false}).measure(image).relmse;
}

}  // namespace

nlohmann::ordered_json walk_json(RenderSession& session, const Walk& request) {
  nlohmann::ordered_json json = {{"frames", request.frames},
                                 {"samples", request.samples},
                                 {"frame_seconds", nlohmann::ordered_json::array()},
                                 {"relmse", nlohmann::ordered_json::array()}};
  const std::vector<double> seconds = walk(session, request, [&](uint32_t frame, const std::vector<float>& image) {
    const auto found = std::find(request.reference_frames.begin(), request.reference_frames.end(), frame);
    if (found == request.reference_frames.end()) return;
    const auto index = static_cast<size_t>(found - request.reference_frames.begin());
    const double relmse = relmse_against(request.references.at(index), session.settings(), image);
    json["relmse"].push_back({{"frame", frame}, {"relmse", relmse}});
  });
  if (seconds.size() < request.frames)
    throw_error(ErrorClass::interrupted, "interrupted in frame {} of the walk", seconds.size());
  json["frame_seconds"] = seconds;
  return json;
}

}  // namespace lucarium::app
