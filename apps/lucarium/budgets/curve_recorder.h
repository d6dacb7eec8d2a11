// SPDX-License-Identifier: Apache-2.0
// Error against a reference while a rendering goes on.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "lucarium/metrics/metrics.h"
#include "lucarium/session/session.h"

namespace lucarium::app {

/// Processor time of preparing and iterating [s]; none of a device that is no CPU, whose work no processor does.
std::optional<double> processor_seconds_of(RenderSession& session);

/// When a curve is sampled: at work t·2^(i/2).
struct CurveSchedule {
  enum class Work { seconds, iterations, samples };  ///< seconds of preparing and iterating; samples per pixel
  Work work = Work::seconds;
  double first = 0, last = 0;  ///< `last` infinite: without end
  /// Up to a budget, from 1/64 of it.
  static CurveSchedule up_to_seconds(double seconds) { return {Work::seconds, seconds / 64, seconds}; }
  static CurveSchedule up_to_count(Work work, uint64_t count);
  static CurveSchedule open_ended();  ///< from 0.1 s
  static CurveSchedule at_the_end();
};

/// Samples the error of a session's film against a reference; the time this takes is on no clock.
class CurveRecorder {
 public:
  /// Throws Error{input} when the file is no image of the session's size.
  CurveRecorder(const std::filesystem::path& reference, const RenderSettings& settings, float exposure_stops,
                const CurveSchedule& schedule);

  /// The stated one, or where that is automatic the reference's [stops].
  float exposure() const { return exposure_; }

  /// After an iteration: takes a snapshot if one is due. Returns its relMSE.
  std::optional<double> sample(RenderSession& session);
  /// All metrics of the finished image, FLIP among them, and the last snapshot if it is not there yet.
  void finish(RenderSession& session, const std::vector<float>& image);
  /// Of the finished image.
  double relmse() const { return final_.relmse; }
  /// {"metrics": {name: value}, "snapshots": […]} (docs/results.md).
  nlohmann::ordered_json to_json() const;

 private:
  struct Snapshot {
    double seconds;
    std::optional<double> processor_seconds;
    uint64_t iterations, samples;
    ImageMetrics metrics;
  };
  void take(RenderSession& session, const std::vector<float>& image);
  double work_done(const RenderSession& session) const;

  uint32_t width_, height_;
  std::vector<float> truth_;
  float exposure_;
  MetricReference reference_;
  CurveSchedule schedule_;
  double next_;
  std::vector<Snapshot> snapshots_;
  ImageMetrics final_;
};

}  // namespace lucarium::app
