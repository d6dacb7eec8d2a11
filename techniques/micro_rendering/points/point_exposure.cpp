// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/point_exposure.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/embedded_files.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/compute/program/source_library.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr size_t kLocalSize = 64;
// Of a side that few directions see a walk may not find the way; it matters as little.
constexpr uint32_t kFrontWalks = 8, kBackWalks = 4;
constexpr uint32_t kSteps =
    6;  // that bring a walk away: in the gap between two solids many steps end at fronts, few of them all along
constexpr size_t kAtOnce = 1 << 18;      // points, of which each takes 61 bytes
constexpr double kLeastShare = 1.0 / 8;  // of points that are worth looking for
const char* const kRemedy = "lower points_log2";

Program exposure_program(Device& device) {
  SourceLibrary library;
  library.add(micro_rendering_kernels());
  return Program(device, library, {"micro_rendering/exposure", {"micro_rendering/points/micro_exposure.cl"}, {}});
}

uint32_t quantize_weight(float w) { return static_cast<uint32_t>(std::clamp(w * 65535.f, 0.f, 65535.f)); }

/// `wanted` points: those that something sees, or as many of them, evenly left out; filled up with others.
std::vector<SampledPoint> choose(const std::vector<SampledPoint>& points, const std::vector<bool>& seen,
                                 uint32_t wanted) {
  std::vector<uint32_t> lists[2];
  for (uint32_t i = 0; i < points.size(); ++i) lists[seen[i] ? 0 : 1].push_back(i);
  std::vector<SampledPoint> chosen;
  for (const std::vector<uint32_t>& list : lists) {
    const size_t take = std::min(list.size(), wanted - chosen.size());
    for (size_t i = 0; i < take; ++i) chosen.push_back(points[list[i * list.size() / take]]);
  }
  return chosen;
}

/// What rests and is opaque, under the numbers that its triangles have in the scene; null where nothing moves, and MASK
/// and BLEND surfaces are what they are along each ray. Here they hide nothing.
std::unique_ptr<Bvh> make_resting(Device& device, const ScenePoints& points, const SceneBuffers& buffers,
                                  const std::vector<TreeSource>& sources) {
  std::vector<bool> moves(points.scene->instances.size(), false);
  for (const TreeSource& source : sources)
    if (source.instance != none) moves[static_cast<size_t>(source.instance)] = true;
  if (std::find(moves.begin(), moves.end(), true) == moves.end()) return nullptr;
  const std::vector<Vertex> vertices = buffers.scene_vertices.download();
  std::vector<Triangle> triangles = buffers.scene_triangles.download(0, buffers.info().triangle_count);
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const bool opaque = points.material(t).alpha_mode == AlphaMode::opaque;
    if (!opaque || moves[static_cast<size_t>(points.instance_of_triangle[t])])
      triangles[t].v1 = triangles[t].v2 = triangles[t].v0;  // met by no ray
  }
  return std::make_unique<Bvh>(device, vertices, triangles);
}

double share_of(const std::vector<bool>& seen) {
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) /
         static_cast<double>(std::max<size_t>(seen.size(), 1));
}

}  // namespace

MicroLeaf leaf_of(const SampledPoint& point) {
  return {point.source | (point.solid ? MICRO_LEAF_SOLID : 0),
          quantize_weight(point.weights.x) | quantize_weight(point.weights.y) << 16, point.area};
}

PointExposure::PointExposure(Device& device, KernelScheduler& scheduler, const ScenePoints& scene_points,
                             const SceneBuffers& buffers, const Intersector& intersector,
                             const std::vector<TreeSource>& sources, float contact, const std::string& owner)
    : device_(device),
      scheduler_(scheduler),
      buffers_(buffers),
      resting_(make_resting(device, scene_points, buffers, sources)),
      intersector_(resting_ ? *resting_ : intersector),
      scene_points_(scene_points),
      contact_(contact),
      owner_(owner),
      program_(exposure_program(device)) {}

std::vector<bool> PointExposure::fronts(const std::vector<SampledPoint>& points, const Progress& progress) {
  return measure(points, std::vector<uint8_t>(points.size(), 0), MICRO_SEEN_FRONT, kFrontWalks, progress);
}

std::vector<bool> PointExposure::backs(const std::vector<SampledPoint>& points, const Progress& progress) {
  std::vector<uint8_t> known;
  for (const SampledPoint& p : points)
    known.push_back(is_two_sided(scene_points_.material(p.source & MICRO_LEAF_TRIANGLE)) ? 1 : 0);
  return measure(points, known, MICRO_SEEN_BACK, kBackWalks, progress);
}

std::vector<bool> PointExposure::measure(const std::vector<SampledPoint>& points, const std::vector<uint8_t>& known,
                                         uint32_t side, uint32_t most_walks, const Progress& progress) {
  std::vector<bool> seen;
  for (size_t first = 0; first < points.size(); first += kAtOnce) {
    const size_t count = std::min(kAtOnce, points.size() - first);
    const auto part = [&](double fraction) {
      if (progress)
        progress((static_cast<double>(first) + fraction * static_cast<double>(count)) /
                 static_cast<double>(points.size()));
    };
    for (const uint8_t escaped :
         walk(std::span(points).subspan(first, count), std::span(known).subspan(first, count), side, most_walks, part))
      seen.push_back(escaped != 0);
  }
  return seen;
}

/// Which of some points a walk has escaped from; nonzero in `known` where none is needed.
std::vector<uint8_t> PointExposure::walk(std::span<const SampledPoint> points, std::span<const uint8_t> known,
                                         uint32_t side, uint32_t most_walks, const Progress& progress) {
  std::vector<MicroLeaf> list;
  for (const SampledPoint& p : points) list.push_back(leaf_of(p));
  const TypedBuffer<MicroLeaf> leaves(device_, owner_, "points", list, kRemedy);
  TypedBuffer<uint8_t> escaped(device_, owner_, "exposed points", std::vector<uint8_t>(known.begin(), known.end()),
                               kRemedy);
  const auto count = static_cast<uint32_t>(points.size());
  const TypedBuffer<uint32_t> ray_count(device_, owner_, "number of points", std::vector<uint32_t>{count});

  ScheduleRecorder recorder = scheduler_.record("exposure of points", owner_);
  const Variable<uint32_t> number = recorder.variable("number", 0u);
  const BufferRef rays = recorder.transient<Ray>("steps of walks", count, kRemedy);
  const BufferRef hits = recorder.transient<Hit>("ends of steps", count, kRemedy);
  PassBuilder begin = recorder.pass("begin walks", program_, "mr_begin_walks");
  buffers_.bind(begin, program_, "mr_begin_walks");
  begin.global(count)
      .local(kLocalSize)
      .arg("leaves", leaves)
      .arg("count", count)
      .arg("side", side)
      .arg("number", number)
      .arg("escaped", escaped)
      .arg("rays", rays);
  for (uint32_t step = 0; step < kSteps; ++step) {
    intersector_.record_closest(recorder, "steps of walks", rays, hits, ray_count, 0, count);
    PassBuilder pass = recorder.pass("walk", program_, "mr_walk");
    buffers_.bind(pass, program_, "mr_walk");
    pass.global(count)
        .local(kLocalSize)
        .arg("count", count)
        .arg("number", step)
        .arg("last", step + 1 == kSteps ? 1u : 0u)
        .arg("contact", contact_)
        .arg("hits", hits)
        .arg("rays", rays)
        .arg("escaped", escaped);
  }
  Schedule schedule = recorder.compile();
  for (uint32_t i = 0; i < most_walks; ++i) {
    throw_if_interrupted("hidden points");
    progress(static_cast<double>(i) / most_walks);
    schedule.set(number, i);
    scheduler_.run_to_end(schedule);
  }
  scheduler_.finish();
  return escaped.download();
}

size_t PointExposure::estimate_bytes(const Scene& scene, size_t points) {
  const size_t per_point = sizeof(MicroLeaf) + sizeof(Ray) + sizeof(Hit) + sizeof(uint8_t);
  const auto most = static_cast<size_t>(static_cast<double>(points) / kLeastShare);
  return std::min(kAtOnce, most) * per_point + (scene.animations.empty() ? 0 : Bvh::estimate_bytes(scene));
}

double ExposedSampler::exposed_share(const TreeSource& source, uint32_t points) const {
  if (!measures(source)) return 1;
  const std::vector<bool> seen = exposure_->fronts(
      sample_surface(source.sides, points, seed_, threads_, point_is_there, &scene_points_).points, {});
  return std::max(share_of(seen), kLeastShare);
}

SampledSurface ExposedSampler::sample(const TreeSource& source, double share, uint32_t count,
                                      const PointExposure::Progress& progress) const {
  const auto part = [&](double first, double last) {
    return [=, &progress](double fraction) {
      if (progress) progress(first + (last - first) * fraction);
    };
  };
  const auto drawn = static_cast<uint32_t>(std::lround(count / share));
  const auto placed = part(0, measures(source) ? 0.6 : 1);
  SampledSurface sampled = sample_surface(source.sides, drawn, seed_, threads_, point_is_there, &scene_points_,
                                          [&](uint32_t points) { placed(static_cast<double>(points) / drawn); });
  if (!measures(source)) return sampled;
  const std::vector<bool> seen = exposure_->fronts(sampled.points, part(0.6, 0.75));
  sampled.points = choose(sampled.points, seen, count);
  sampled.area *= std::max(share_of(seen), static_cast<double>(count) / drawn);
  if (!backs_) return sampled;
  const std::vector<bool> backs = exposure_->backs(sampled.points, part(0.75, 1));
  for (size_t i = 0; i < sampled.points.size(); ++i) sampled.points[i].solid = !backs[i];
  return sampled;
}

}  // namespace lucarium::micro
