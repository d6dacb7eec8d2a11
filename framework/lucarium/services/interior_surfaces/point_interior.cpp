// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/interior_surfaces/point_interior.h"

#include <algorithm>
#include <cstring>

#include "lucarium/base/interrupt.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_ends.h"

namespace lucarium {
namespace {

constexpr size_t kAtOnce = 1 << 21;    // points in device memory
constexpr uint32_t kPlaces = 1 << 17;  // points that walk at a time: so few that their rays stay in caches

}  // namespace

PointInterior::PointInterior(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                             const Intersector& intersector, const InteriorRule& rule, std::string owner,
                             const char* remedy)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      intersector_(intersector),
      rule_(rule),
      program_(device, SourceLibrary(),
               {"interior of points",
                {"lucarium/services/interior_surfaces/point_interior.cl"},
                ray_end_defines(intersector)}),
      primitives_(device),
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
  const uint32_t places = std::min(kPlaces, count);
  const TypedBuffer<InteriorPoint> list(device_, owner_, "points",
                                        std::vector<InteriorPoint>(points.begin(), points.end()), remedy_);
  const TypedBuffer<uint8_t> open(device_, owner_, "open points", std::vector<uint8_t>(known.begin(), known.end()),
                                  remedy_);
  const TypedBuffer<uint32_t> stayed(device_, owner_, "number of points that stay", std::vector<uint32_t>{0});
  const TypedBuffer<uint32_t> survivors(device_, owner_, "places of points that stay", places, remedy_);
  const TypedBuffer<uint2> next_states(device_, owner_, "next steps", places, remedy_);
  const TypedBuffer<Ray> next_rays(device_, owner_, "rays of next steps", places, remedy_);
  const TypedBuffer<RayEnds> next_ends =
      make_ray_ends(device_, intersector_, owner_, "ends of next steps", places, remedy_);

  ScheduleRecorder recorder = scheduler_.record("interior of points", owner_);
  const Variable<uint32_t> staying = recorder.variable("staying", 0u), first = recorder.variable("first", 0u),
                           coming = recorder.variable("coming", 0u);
  const BufferRef total = recorder.transient<uint32_t>("walks", 1), states = recorder.transient<uint2>("steps", places),
                  rays = recorder.transient<Ray>("steps of walks", places, remedy_),
                  ends = transient_ray_ends(recorder, intersector_, "ends of steps of walks", places, remedy_),
                  hits = recorder.transient<Hit>("ends of steps", places, remedy_),
                  stays = recorder.transient<uint32_t>("who stays", places);
  PassBuilder aim = recorder.pass("aim walks", program_, "aim_point_walks");
  scene_.bind(aim);
  aim.global(places)
      .arg("points", list)
      .arg("behind", side == Side::behind ? 1u : 0u)
      .arg("staying", staying)
      .arg("first", first)
      .arg("coming", coming)
      .arg("list", survivors)
      .arg("next_states", next_states)
      .arg("next_rays", next_rays)
      .arg_if_present("next_ends", next_ends)
      .arg("open", open)
      .arg("states", states)
      .arg_if_present("ends", ends)
      .arg("rays", rays)
      .arg("total", total);
  intersector_.record_closest(recorder, "steps of walks", {rays, total, 0, places, ends}, hits);
  PassBuilder judge = recorder.pass("judge walks", program_, "judge_point_walks");
  scene_.bind(judge);
  judge.global(places)
      .arg("total", total)
      .arg("walks", walks)
      .arg("steps", rule_.steps)
      .arg("contact", rule_.contact)
      .arg("hits", hits)
      .arg("rays", rays)
      .arg("states", states)
      .arg("next_states", next_states)
      .arg_if_present("next_ends", next_ends)
      .arg("next_rays", next_rays)
      .arg("stays", stays)
      .arg("open", open);
  primitives_.record_compact(recorder, "points that stay", stays, survivors, stayed, 0, total, 0, places);
  uint32_t walking = 0, begun = 0;
  recorder.read_back("number of points that stay", stayed,
                     [&](std::span<const std::byte> bytes) { std::memcpy(&walking, bytes.data(), sizeof(walking)); });
  Schedule schedule = recorder.compile();
  while (walking > 0 || begun < count) {
    throw_if_interrupted("hidden points");
    progress(static_cast<double>(begun - walking) / count);
    const uint32_t more = std::min(places - walking, count - begun);
    schedule.set(staying, walking);
    schedule.set(first, begun);
    schedule.set(coming, more);
    begun += more;
    scheduler_.run_to_end(schedule);
  }
  scheduler_.finish();
  return open.download();
}

size_t PointInterior::estimate_bytes(size_t points) {
  const size_t places = std::min<size_t>(kPlaces, points);
  return std::min(kAtOnce, points) * (sizeof(InteriorPoint) + sizeof(uint8_t)) +
         places * (2 * sizeof(Ray) + sizeof(Hit) + 2 * sizeof(uint2) + 2 * sizeof(uint32_t));
}

}  // namespace lucarium
