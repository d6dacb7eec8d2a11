// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/points/point_visibility.h"

#include <algorithm>
#include <cmath>

namespace lucarium::micro {
namespace {

// Of a side that few directions see a walk may not find the way; it matters as little.
constexpr uint32_t kFrontWalks = 8, kBackWalks = 4;
constexpr uint32_t kSteps =
    6;  // that bring a walk away: in the gap between two solids many steps end at fronts, few of them all along
constexpr double kMinShare = 1.0 / 8;  // of points that are worth looking for
const char* const kFewerPoints = "lower points_log2";

uint32_t quantize_weight(float w) { return static_cast<uint32_t>(std::clamp(w * 65535.f, 0.f, 65535.f)); }

/// `wanted` points: those that something sees, or as many of them, evenly left out; filled up with others.
std::vector<SampledPoint> choose(const std::vector<SampledPoint>& points, const std::vector<bool>& seen,
                                 uint32_t wanted) {
  std::vector<uint32_t> lists[2];
  for (uint32_t i = 0; i < points.size(); ++i) lists[seen[i] ? 0 : 1].push_back(i);
  std::vector<SampledPoint> chosen;
  chosen.reserve(wanted);
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

/// The points where their leaves will be, whose weights are rounded.
std::vector<InteriorPoint> interior_points(const std::vector<SampledPoint>& points) {
  static_assert(MICRO_LEAF_BACK == INTERIOR_BACK);
  std::vector<InteriorPoint> result;
  result.reserve(points.size());
  for (const SampledPoint& p : points) {
    const uint32_t weights = leaf_of(p).weights;
    result.push_back({p.source, static_cast<float>(weights & 0xffffu) * (1.f / 65535.f),
                      static_cast<float>(weights >> 16) * (1.f / 65535.f)});
  }
  return result;
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

PointVisibility::PointVisibility(Device& device, KernelScheduler& scheduler, const ScenePoints& scene_points,
                                 const SceneBuffers& buffers, const Intersector& intersector,
                                 const std::vector<TreeSource>& sources, float contact, const std::string& owner)
    : resting_(make_resting(device, scene_points, buffers, sources)),
      scene_points_(scene_points),
      interior_(device, scheduler, buffers, resting_ ? *resting_ : intersector, {kSteps, contact}, owner,
                kFewerPoints) {}

std::vector<bool> PointVisibility::fronts(const std::vector<SampledPoint>& points, const Progress& progress) const {
  return interior_.are_open(interior_points(points), {}, PointInterior::Side::own, kFrontWalks, progress);
}

std::vector<bool> PointVisibility::backs(const std::vector<SampledPoint>& points, const Progress& progress) const {
  std::vector<uint8_t> known;
  known.reserve(points.size());
  for (const SampledPoint& p : points)
    known.push_back(is_two_sided(scene_points_.material(p.source & MICRO_LEAF_TRIANGLE)) ? 1 : 0);
  return interior_.are_open(interior_points(points), known, PointInterior::Side::behind, kBackWalks, progress);
}

size_t PointVisibility::estimate_bytes(const Scene& scene, size_t points) {
  const auto max_points = static_cast<size_t>(static_cast<double>(points) / kMinShare);
  return PointInterior::estimate_bytes(max_points) + (scene.animations.empty() ? 0 : Bvh::estimate_bytes(scene));
}

double VisibleSampler::visible_share(const TreeSource& source, uint32_t points) const {
  if (!measures(source)) return 1;
  const std::vector<bool> seen = visibility_->fronts(
      sample_surface(source.sides, points, seed_, threads_, point_is_there, &scene_points_).points, {});
  return std::max(share_of(seen), kMinShare);
}

SampledSurface VisibleSampler::sample(const TreeSource& source, double share, uint32_t count,
                                      const PointVisibility::Progress& progress) const {
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
  const std::vector<bool> seen = visibility_->fronts(sampled.points, part(0.6, 0.75));
  sampled.points = choose(sampled.points, seen, count);
  sampled.area *= std::max(share_of(seen), static_cast<double>(count) / drawn);
  if (!backs_) return sampled;
  const std::vector<bool> backs = visibility_->backs(sampled.points, part(0.75, 1));
  for (size_t i = 0; i < sampled.points.size(); ++i) sampled.points[i].solid = !backs[i];
  return sampled;
}

}  // namespace lucarium::micro
