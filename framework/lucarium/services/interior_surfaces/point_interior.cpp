// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/point_interior.h"

#include <algorithm>

#include "lucarium/base/interrupt.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {
namespace {

constexpr size_t kAtOnce = 1 << 18;  // points

}  // namespace

PointInterior::PointInterior(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                             const Intersector& intersector, const InteriorRule& rule, std::string owner,
                             const char* remedy)
    : device_(device),
      scheduler_(scheduler),
      walks_(device, scene, intersector, rule),
      owner_(std::move(owner)),
      remedy_(remedy) {}

std::vector<bool> PointInterior::are_open(std::span<const InteriorPoint> points, std::span<const uint8_t> known,
                                          Side side, uint32_t walks, const Progress& progress) const {
  const std::vector<uint8_t> unknown(known.empty() ? points.size() : 0);
  if (known.empty()) known = unknown;
  std::vector<bool> open;
  for (size_t first = 0; first < points.size(); first += kAtOnce) {
    const size_t count = std::min(kAtOnce, points.size() - first);
    const auto part = [&](double fraction) {
      if (progress)
        progress((static_cast<double>(first) + fraction * static_cast<double>(count)) /
                 static_cast<double>(points.size()));
    };
    for (const uint8_t escaped : walk(points.subspan(first, count), known.subspan(first, count), side, walks, part))
      open.push_back(escaped != 0);
  }
  return open;
}

std::vector<uint8_t> PointInterior::walk(std::span<const InteriorPoint> points, std::span<const uint8_t> known,
                                         Side side, uint32_t walks, const Progress& progress) const {
  const auto count = static_cast<uint32_t>(points.size());
  const TypedBuffer<InteriorPoint> list(device_, owner_, "points",
                                        std::vector<InteriorPoint>(points.begin(), points.end()), remedy_);
  const TypedBuffer<uint8_t> escaped(device_, owner_, "open points", std::vector<uint8_t>(known.begin(), known.end()),
                                     remedy_);
  const TypedBuffer<uint32_t> counter(device_, owner_, "number of points", std::vector<uint32_t>{count});

  ScheduleRecorder recorder = scheduler_.record("interior of points", owner_);
  const Variable<uint32_t> number = recorder.variable("number", 0u);
  const BufferRef rays = recorder.transient<Ray>("steps of walks", count, remedy_);
  const BufferRef ends = transient_ray_ends(recorder, walks_.intersector(), "ends of steps of walks", count, remedy_);
  PassBuilder begin = recorder.pass("begin walks", walks_.program(), "begin_point_walks");
  walks_.scene().bind(begin);
  begin.global(count)
      .arg("points", list)
      .arg("count", count)
      .arg("behind", side == Side::behind ? 1u : 0u)
      .arg("number", number)
      .arg("escaped", escaped)
      .arg("rays", rays)
      .arg_if_present("ends", ends);
  walks_.record(recorder, {rays, counter, 0, count, ends}, escaped);
  Schedule schedule = recorder.compile();
  for (uint32_t i = 0; i < walks; ++i) {
    throw_if_interrupted("hidden points");
    progress(static_cast<double>(i) / walks);
    schedule.set(number, i);
    scheduler_.run_to_end(schedule);
  }
  scheduler_.finish();
  return escaped.download();
}

size_t PointInterior::estimate_bytes(size_t points) {
  const size_t at_once = std::min(kAtOnce, points);
  return at_once * (sizeof(InteriorPoint) + sizeof(Ray) + sizeof(uint8_t)) + InteriorWalks::estimate_bytes(at_once);
}

}  // namespace lucarium
