// SPDX-License-Identifier: Apache-2.0
// Hierarchies over analytic surfaces, made on the host, and gathers in them.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/glm.hpp>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "micro_fixture.h"
#include "micro_rendering/shared/micro_types.h"

namespace lucarium::test {

using glm::dmat3;
using glm::dvec3;

/// A point of a surface that gives off light.
struct SurfacePointLight {
  dvec3 position, normal, radiance;
  uint32_t flags = 0;
};
using Radiance = std::function<dvec3(const dvec3& position)>;

constexpr double golden_angle = std::numbers::pi * (3 - 2.2360679774997896);

/// A sphere about the origin seen from inside.
inline std::vector<SurfacePointLight> sphere_inside(int count, double radius, const Radiance& radiance) {
  std::vector<SurfacePointLight> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.) / count, s = std::sqrt(1 - z * z), phi = golden_angle * i;
    const dvec3 n(s * std::cos(phi), s * std::sin(phi), z);
    points.push_back({radius * n, -n, radiance(radius * n)});
  }
  return points;
}

/// The same sphere seen from outside.
inline std::vector<SurfacePointLight> sphere_outside(int count, double radius, const Radiance& radiance) {
  std::vector<SurfacePointLight> points = sphere_inside(count, radius, radiance);
  for (SurfacePointLight& p : points) p.normal = -p.normal;
  return points;
}

/// A disc about `center` with unit normal `normal`.
inline std::vector<SurfacePointLight> disc(int count, const dvec3& center, const dvec3& normal, double radius,
                                           const dvec3& radiance) {
  const dvec3 aside = std::abs(normal.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0);
  const dvec3 t = glm::normalize(glm::cross(normal, aside));
  const dvec3 b = glm::cross(normal, t);
  std::vector<SurfacePointLight> points;
  for (int i = 0; i < count; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / count), phi = golden_angle * i;
    points.push_back({center + r * (std::cos(phi) * t + std::sin(phi) * b), normal, radiance});
  }
  return points;
}

/// The rectangle center ± u ± v, normal u x v.
inline std::vector<SurfacePointLight> rectangle(int count, const dvec3& center, const dvec3& u, const dvec3& v,
                                                const Radiance& radiance) {
  std::vector<SurfacePointLight> points;
  const dvec3 normal = glm::normalize(glm::cross(u, v));
  for (int i = 0; i < count; ++i) {
    // The R2 sequence (Roberts 2018).
    const double x = std::fmod(0.5 + 0.7548776662466927 * i, 1), y = std::fmod(0.5 + 0.5698402909980532 * i, 1);
    const dvec3 p = center + (2 * x - 1) * u + (2 * y - 1) * v;
    points.push_back({p, normal, radiance(p)});
  }
  return points;
}

/// The cube [-half, half]^3 seen from inside.
inline std::vector<SurfacePointLight> cube_inside(int count, double half, const Radiance& radiance) {
  std::vector<SurfacePointLight> points;
  for (int face = 0; face < 6; ++face) {
    dvec3 n(0), u(0), v(0);
    const int axis = face / 2;
    n[axis] = face % 2 ? 1 : -1;
    u[(axis + 1) % 3] = half;
    v[(axis + 2) % 3] = face % 2 ? -half : half;
    const int share = count * (face + 1) / 6 - count * face / 6;
    const auto side = rectangle(share, n * half, u, v, radiance);
    points.insert(points.end(), side.begin(), side.end());
  }
  return points;
}

/// Trees as the gather kernel takes them.
class SyntheticForest {
 public:
  /// Adds a tree over 2^k points that stand for `area` together; its grid's axes are the columns of `axes`.
  void add(std::vector<SurfacePointLight> points, double area, const dmat3& axes = dmat3(1), double disc_scale = 1.6) {
    const size_t n = points.size();
    if ((n & (n - 1)) != 0) throw std::invalid_argument("a tree needs 2^k points");
    dvec3 low(1e30), high(-1e30);
    const dmat3 turn = glm::transpose(axes);
    for (auto& p : points) {
      p.position = turn * p.position;
      p.normal = turn * p.normal;
      low = glm::min(low, p.position);
      high = glm::max(high, p.position);
    }
    const dvec3 extent = high - low;
    const double step = std::max({extent.x, extent.y, extent.z, 1e-6}) / 65535;
    std::vector<Node> nodes(2 * n);
    order(points, 0, n);
    const double leaf_area = area / static_cast<double>(n),
                 radius = disc_scale * std::sqrt(leaf_area / std::numbers::pi);
    for (size_t i = 0; i < n; ++i)
      nodes[n + i] = {
          (points[i].position - low) / step, radius / step, points[i].normal, 0, points[i].radiance, points[i].flags};
    for (size_t i = n - 1; i > 0; --i) nodes[i] = merge(nodes[2 * i], nodes[2 * i + 1]);
    nodes[0] = nodes[1];
    MicroTree tree{};
    float4* rows[3] = {&tree.grid_row0, &tree.grid_row1, &tree.grid_row2};
    for (int r = 0; r < 3; ++r) *rows[r] = float4(glm::vec3(axes[r] / step), static_cast<float>(-low[r] / step));
    tree.first_node = static_cast<uint>(packed_.size() / 3);
    while ((1u << tree.depth) < n) ++tree.depth;
    tree.leaf_area = static_cast<float>(leaf_area / (step * step));
    tree.world_step = static_cast<float>(step);
    trees_.push_back(tree);
    for (const Node& node : nodes) {
      packed_.push_back(float4(glm::vec3(node.center), static_cast<float>(node.radius)));
      packed_.push_back(float4(glm::vec3(node.normal), static_cast<float>(node.cone)));
      packed_.push_back(float4(glm::vec3(node.radiance), static_cast<float>(node.flags)));
    }
  }

  struct Buffers {
    TypedBuffer<MicroTree> trees;
    TypedBuffer<uint4> nodes;
    TypedBuffer<uint2> radiance;
    TypedBuffer<uint4> clips;  ///< none
  };
  Buffers upload() const {
    const auto in = test_buffer(packed_);
    const uint32_t count = static_cast<uint32_t>(packed_.size() / 3);
    Buffers buffers{test_buffer(trees_), test_buffer<uint4>(count), test_buffer<uint2>(count),
                    test_buffer<uint4>(count / 2)};
    buffers.clips.fill_zero();
    run_kernel(micro_program("test_micro_rendering/gather/gather.cl"), "pack_forest", count, 64,
               [&](PassBuilder& pass) {
                 pass.arg("in", in).arg("count", count).arg("nodes", buffers.nodes).arg("radiance", buffers.radiance);
               });
    return buffers;
  }
  uint32_t tree_count() const { return static_cast<uint32_t>(trees_.size()); }

 private:
  struct Node {
    dvec3 center;
    double radius;
    dvec3 normal;
    double cone;
    dvec3 radiance;
    uint32_t flags;
  };

  /// Median split of the longest axis, down to single points.
  static void order(std::vector<SurfacePointLight>& points, size_t begin, size_t end) {
    if (end - begin < 2) return;
    dvec3 low(1e30), high(-1e30);
    for (size_t i = begin; i < end; ++i) {
      low = glm::min(low, points[i].position);
      high = glm::max(high, points[i].position);
    }
    const dvec3 extent = high - low;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const size_t middle = (begin + end) / 2;
    std::nth_element(points.begin() + begin, points.begin() + middle, points.begin() + end,
                     [axis](const auto& a, const auto& b) { return a.position[axis] < b.position[axis]; });
    order(points, begin, middle);
    order(points, middle, end);
  }

  static Node merge(const Node& a, const Node& b) {
    Node m;
    m.radiance = 0.5 * (a.radiance + b.radiance);
    m.flags = a.flags & b.flags;
    const double d = glm::distance(a.center, b.center);
    m.center = a.center;
    m.radius = a.radius;
    if (d + a.radius <= b.radius) {
      m.center = b.center;
      m.radius = b.radius;
    } else if (d + b.radius > a.radius) {
      m.radius = 0.5 * (d + a.radius + b.radius);
      m.center += (b.center - a.center) * ((m.radius - a.radius) / d);
    }
    const double theta = 2 * std::atan2(glm::length(a.normal - b.normal), glm::length(a.normal + b.normal));
    m.normal = a.normal;
    m.cone = a.cone;
    if (theta + a.cone <= b.cone) {
      m.normal = b.normal;
      m.cone = b.cone;
    } else if (theta + b.cone > a.cone) {
      m.cone = 0.5 * (theta + a.cone + b.cone);
      const double turn = m.cone - a.cone;
      const dvec3 across = b.normal - a.normal * glm::dot(a.normal, b.normal);
      if (glm::length(across) > 1e-9)
        m.normal = glm::normalize(a.normal * std::cos(turn) + glm::normalize(across) * std::sin(turn));
    }
    m.cone = std::min(m.cone, std::numbers::pi);
    return m;
  }

  std::vector<MicroTree> trees_;
  std::vector<float4> packed_;
};

/// Where and how light is gathered.
struct GatherPoint {
  dvec3 position, normal, view{0, 0, 1};
  double alpha = 0.5;
  uint32_t diffuse_edge = 24, specular_edge = 0;
};

struct GatherResult {
  std::vector<float4> irradiance, specular;
  std::vector<MicroStatistics> statistics;
  std::vector<float4> micro_buffer;

  double mean_irradiance() const {
    double sum = 0;
    for (const float4& e : irradiance) sum += e.x;
    return sum / static_cast<double>(irradiance.size());
  }
  struct Totals {
    double visits = 0, splats = 0, listed = 0, disc_tests = 0, holes = 0, flushes = 0, levels = 0;
  };
  Totals total() const {
    Totals sum;
    for (const MicroStatistics& s : statistics) {
      sum.visits += s.visits;
      sum.splats += s.splats;
      sum.listed += s.listed;
      sum.disc_tests += s.disc_tests;
      sum.holes += s.holes;
      sum.flushes += s.flushes;
      sum.levels += s.levels;
    }
    return sum;
  }
};

inline TypedBuffer<MicroGather> pack_gathers(const std::vector<GatherPoint>& points) {
  std::vector<float4> in;
  for (const GatherPoint& p : points) {
    in.push_back(float4(glm::vec3(p.position), 0));
    in.push_back(float4(glm::vec3(p.normal), 0));
    in.push_back(float4(glm::vec3(p.normal), static_cast<float>(p.alpha)));
    in.push_back(float4(glm::vec3(p.view), static_cast<float>(p.diffuse_edge + 256 * p.specular_edge)));
  }
  const auto input = test_buffer(in);
  const uint32_t count = static_cast<uint32_t>(points.size());
  auto gathers = test_buffer<MicroGather>(count);
  run_kernel(micro_program("test_micro_rendering/gather/gather.cl"), "pack_gathers", count, 64,
             [&](PassBuilder& pass) { pass.arg("in", input).arg("count", count).arg("gathers", gathers); });
  return gathers;
}

inline MicroSettings default_settings(uint32_t seed = 1) {
  MicroSettings settings{};
  settings.inspect_too = 0xffffffffu;
  settings.kappa = 1;
  settings.splat_radius = 1.35f;
  settings.seed = seed;
  settings.inspect = 0xffffffffu;
  return settings;
}

inline const Program& gather_program(const Defines& defines = {}) {
  return micro_program("micro_rendering/gather/micro_gather.cl", defines);
}

/// A recorded pass of `kernel` of `program`, which has gather_light's parameters.
class GatherRun {
 public:
  GatherRun(const SyntheticForest& forest, const SyntheticForest::Buffers& buffers,
            const std::vector<GatherPoint>& points, const Program& program, const std::string& kernel = "gather_light")
      : scheduler_(test_device()),
        unit_(test_buffer(std::vector<float>{1})),
        gathers_(pack_gathers(points)),
        count_(test_buffer(std::vector<uint32_t>{static_cast<uint32_t>(points.size())})),
        irradiance_(test_buffer<float4>(points.size())),
        specular_(test_buffer<float4>(2 * points.size())),
        shown_(test_buffer<float4>(64 * 64)),
        statistics_(test_buffer<MicroStatistics>(points.size())) {
    ScheduleRecorder recorder = scheduler_.record("gather", "test");
    settings_ = recorder.variable<MicroSettings>("settings", {});
    PassBuilder pass = recorder.pass("gather", program, kernel);
    pass.global(points.size()).local(1);
    pass.arg("trees", buffers.trees).arg("tree_count", forest.tree_count()).arg("nodes", buffers.nodes);
    pass.arg("radiance", buffers.radiance)
        .arg("clips", buffers.clips)
        .arg("radiance_unit", unit_)
        .arg("gathers", gathers_);
    pass.arg("gather_count", count_).arg("settings", settings_).arg("irradiance", irradiance_);
    pass.arg("specular", specular_).arg("statistics", statistics_).arg("micro_buffer", shown_);
    schedule_ = recorder.compile();
  }
  void run(const MicroSettings& settings) {
    schedule_.set(settings_, settings);
    scheduler_.run(schedule_);
    scheduler_.finish();
  }
  GatherResult result() const {
    return {irradiance_.download(), specular_.download(), statistics_.download(), shown_.download()};
  }

 private:
  KernelScheduler scheduler_;
  TypedBuffer<float> unit_;
  TypedBuffer<MicroGather> gathers_;
  TypedBuffer<uint32_t> count_;
  TypedBuffer<float4> irradiance_, specular_, shown_;
  TypedBuffer<MicroStatistics> statistics_;
  Variable<MicroSettings> settings_;
  Schedule schedule_;
};

inline GatherResult gather(const SyntheticForest& forest, const SyntheticForest::Buffers& buffers,
                           const std::vector<GatherPoint>& points, const MicroSettings& settings,
                           const Program& program, const std::string& kernel = "gather_light") {
  GatherRun run(forest, buffers, points, program, kernel);
  run.run(settings);
  return run.result();
}

}  // namespace lucarium::test
