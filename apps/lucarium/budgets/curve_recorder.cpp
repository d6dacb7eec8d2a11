// SPDX-License-Identifier: Apache-2.0
#include "budgets/curve_recorder.h"

#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/film/exposure.h"
#include "lucarium/film/image_io.h"
#include "lucarium/scene/exposure.h"
#include "lucarium/session/counted_seconds.h"

namespace lucarium::app {
namespace {

const double half_octave = std::sqrt(2.0);

std::vector<float> read_truth(const std::filesystem::path& file, const RenderSettings& settings) {
  const Film film = read_reference_image(file);
  if (film.width() != settings.width || film.height() != settings.height) {
    throw_error(ErrorClass::input, "{} is {}×{}, the rendering {}×{}; give --size {}x{}", file.string(), film.width(),
                film.height(), settings.width, settings.height, film.width(), film.height());
  }
  return film.image();
}

nlohmann::ordered_json metrics_json(const ImageMetrics& metrics) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Metric& metric : metric_table()) {
    const double value = metrics.*metric.value;
    if (std::isfinite(value)) json[metric.name] = value;
  }
  return json;
}

}  // namespace

std::optional<double> processor_seconds_of(RenderSession& session) {
  if (session.scheduler().device().info().type != DeviceType::cpu) return std::nullopt;
  return counted_processor_seconds(session.clocks());
}

CurveSchedule CurveSchedule::up_to_count(Work work, uint64_t count) {
  const double last = static_cast<double>(count);
  return {work, std::max(1.0, last / 64), last};
}

CurveSchedule CurveSchedule::open_ended() { return {Work::seconds, 0.1, INFINITY}; }
CurveSchedule CurveSchedule::at_the_end() { return {Work::seconds, INFINITY, INFINITY}; }

CurveRecorder::CurveRecorder(const std::filesystem::path& reference, const RenderSettings& settings,
                             float exposure_stops, const CurveSchedule& schedule)
    : width_(settings.width),
      height_(settings.height),
      truth_(read_truth(reference, settings)),
      exposure_(is_automatic(exposure_stops) ? automatic_exposure(truth_) : exposure_stops),
      reference_(width_, height_, truth_, {exposure_, false}),
      schedule_(schedule),
      next_(schedule.first) {}

std::optional<double> CurveRecorder::sample(RenderSession& session) {
  const double work = work_done(session);
  // Times are those of the schedule, whatever the iterations took: late ones are not made up for.
  if (work < next_ * (1 - 1e-9)) return std::nullopt;
  while (next_ <= work * (1 + 1e-9)) next_ *= half_octave;
  if (schedule_.work != CurveSchedule::Work::seconds) next_ = std::ceil(next_ * (1 - 1e-9));
  take(session, session.resolve().image());
  return snapshots_.back().metrics.relmse;
}

double CurveRecorder::work_done(const RenderSession& session) const {
  if (schedule_.work == CurveSchedule::Work::iterations) return static_cast<double>(session.iterations());
  if (schedule_.work == CurveSchedule::Work::samples) return static_cast<double>(session.last().samples);
  return counted_seconds(session.clocks());
}

void CurveRecorder::take(RenderSession& session, const std::vector<float>& image) {
  snapshots_.push_back({counted_seconds(session.clocks()), processor_seconds_of(session), session.iterations(),
                        session.last().samples, reference_.measure(image)});
}

void CurveRecorder::finish(RenderSession& session, const std::vector<float>& image) {
  if (snapshots_.empty() || snapshots_.back().iterations != session.iterations()) take(session, image);
  final_ = MetricReference(width_, height_, truth_, {exposure_, true}).measure(image);
}

nlohmann::ordered_json CurveRecorder::to_json() const {
  nlohmann::ordered_json json = {{"metrics", metrics_json(final_)}, {"nonfinite_pixels", final_.nonfinite}};
  json["snapshots"] = nlohmann::ordered_json::array();
  for (const Snapshot& snapshot : snapshots_) {
    json["snapshots"].push_back({{"seconds", snapshot.seconds},
                                 {"iterations", snapshot.iterations},
                                 {"samples", snapshot.samples},
                                 {"metrics", metrics_json(snapshot.metrics)}});
    if (snapshot.processor_seconds) json["snapshots"].back()["processor_seconds"] = *snapshot.processor_seconds;
  }
  return json;
}

}  // namespace lucarium::app
