// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/tree/point_forest.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>

#include "lucarium/base/error.h"
#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/numbers.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/compute/program/program.h"
#include "micro_rendering/points/point_sampling.h"
#include "micro_rendering/points/point_visibility.h"
#include "micro_rendering/points/triangle_edges.h"
#include "micro_rendering/tree/tree_order.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr int kMinDepth = 4;            // of a tree
constexpr uint32_t kQualityLevel = 8;   // whose radii decide when a refitted tree is too loose
constexpr double kLoosest = 1.5;        // times the sum when built
constexpr double kMaxGrowth = 4;        // of a tree's area, beyond which it gets new points
constexpr double kContact = 0.01;       // of a disc's radius: fronts that are nearer to each other touch
constexpr double kMaxPilots = 1 << 14;  // points that estimate how much of a tree is visible
constexpr double kBent = 30;  // degrees that the normals of a pair of leaves are off their mean, for fine details
constexpr uint32_t kPlacingSeed = 1;  // every run of a scene has the same points
const char* const kFewerPoints = "lower points_log2";
const char* const kDerivation = "points and hierarchy";

Program forest_program(Device& device) {
  return make_program(
      device, micro_rendering_kernels(),
      {"micro_rendering/tree/leaf_albedo", "micro_rendering/tree/update_leaves", "micro_rendering/tree/refit_nodes"});
}

float half_to_float(uint32_t bits) {
  const int exponent = static_cast<int>(bits >> 10 & 31);
  const auto mantissa = static_cast<float>(bits & 1023);
  return exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(mantissa + 1024.f, exponent - 25);
}

/// What PointForest::radius_sum() gives for points in their order, by the rules of refitting: of where they were
/// ordered, so that it does not depend on the pose in which a run begins. `leaf_area`: that a point stands for, in the
/// points' space.
double ordered_radius_sum(const std::vector<SampledPoint>& points, const std::vector<uint32_t>& order, uint32_t depth,
                          double leaf_area, float disc_scale) {
  struct Sphere {
    glm::vec3 center;
    float radius;
  };
  const auto leaf_length = static_cast<float>(std::sqrt(std::max(leaf_area, 1e-30)));
  std::vector<Sphere> spheres;
  for (const uint32_t i : order) spheres.push_back({points[i].position, disc_scale * 0.56418958f * leaf_length});
  for (uint32_t level = depth; level > std::min(kQualityLevel, depth); --level) {
    for (size_t i = 0; i < spheres.size() / 2; ++i) {
      const Sphere &left = spheres[2 * i], &right = spheres[2 * i + 1];
      const glm::vec3 between = right.center - left.center;
      const float d = glm::length(between);
      if (d + right.radius <= left.radius) {
        spheres[i] = left;
      } else if (d + left.radius <= right.radius) {
        spheres[i] = right;
      } else {
        const float radius = 0.5f * (d + left.radius + right.radius);
        spheres[i] = {left.center + between * ((radius - left.radius) / d), radius};
      }
    }
    spheres.resize(spheres.size() / 2);
  }
  double sum = 0;
  for (const Sphere& sphere : spheres) sum += static_cast<double>(sphere.radius);
  return 0.5 * sum / static_cast<double>(leaf_length);
}

float4 matrix_row(const glm::mat4& m, int row) { return {m[0][row], m[1][row], m[2][row], m[3][row]}; }

}  // namespace

PointForest::PointForest(Device& device, KernelScheduler& scheduler, const Scene& scene, const SceneBuffers& buffers,
                         const ForestOptions& options, const std::string& owner)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      buffers_(buffers),
      options_(options),
      owner_(owner),
      program_(forest_program(device)) {
  placed_materials_ = placing();
  report(0, "surfaces");
  std::vector<TreeSource> sources = find_tree_sources(scene, buffers, options.moving, options.threads);
  std::erase_if(sources, [this](const TreeSource& source) {
    if (source.sides.empty() && source.instance != none) uncovered_.push_back(source.instance);
    return source.sides.empty();
  });
  place(std::move(sources));
  derive_albedo();
  std::vector<size_t> all(trees_.size());
  for (size_t t = 0; t < all.size(); ++t) all[t] = t;
  derive(all);
  loosened_ = std::any_of(trees_.begin(), trees_.end(), [this](const ForestTree& tree) {
    return tree.kind == TreeKind::deforming && too_loose(tree);
  });
  fine_details_ = bent_pairs();
}

/// Share of the leaves whose sibling, a neighbour on the surface where that is smooth, faces another way.
double PointForest::bent_pairs() const {
  scheduler_.finish();
  uint32_t bent = 0;
  for (const ForestTree& tree : trees_) {
    const uint32_t pairs = tree.leaves() / 2;
    for (const uint4& node : nodes.download(tree.record.first_node + pairs, pairs))
      bent += (node.z >> 20 & MICRO_CONE_STEPS) * 180. / MICRO_CONE_STEPS > kBent;
  }
  return 2. * bent / leaf_count_;
}

std::vector<PointForest::Placing> PointForest::placing() const {
  std::vector<Placing> list;
  for (const SceneMaterial& m : scene_.materials) list.push_back({m.alpha_mode, is_two_sided(m), m.transmission > 0});
  return list;
}

void PointForest::report(double fraction, const char* stage) const {
  if (options_.progress) options_.progress(fraction, stage);
}

/// Points in proportion to area in the world, a power of two per tree.
void PointForest::place(std::vector<TreeSource> sources) {
  if (sources.empty()) throw_error(ErrorClass::input, "the scene has no surface to gather light from");
  std::vector<double> areas;
  for (const TreeSource& s : sources) {
    double area = s.covered_area;
    if (s.kind != TreeKind::resting && s.plain_area > 0) area *= instance_area(scene_, s.instance) / s.plain_area;
    areas.push_back(area);
  }
  triangle_edges = TypedBuffer<TriangleEdges>(
      device_, owner_, "edges of triangles",
      find_triangle_edges(sources, buffers_.scene_triangles.download(0, buffers_.info().triangle_count)));
  throw_if_interrupted("edges of triangles");
  const double expected = std::exp2(options_.points_log2);  // points, up to rounding
  Stopwatch watch;
  const ScenePoints points(scene_, buffers_);
  // Of what rests nothing may depend on where things move.
  std::unique_ptr<PointVisibility> visibility;
  if (options_.skip_hidden && sources.front().kind == TreeKind::resting) {
    const double disc = static_cast<double>(options_.disc_scale) * std::sqrt(areas.front() / (pi * expected));
    visibility = std::make_unique<PointVisibility>(device_, scheduler_, points, buffers_, *options_.intersector,
                                                   sources, static_cast<float>(kContact * disc), owner_);
  }
  const VisibleSampler sampler(points, visibility.get(), !options_.all_cullable, kPlacingSeed, options_.threads);
  std::vector<double> visible;
  double all = 0;
  for (size_t t = 0; t < sources.size(); ++t) {
    visible.push_back(sampler.visible_share(sources[t], static_cast<uint32_t>(std::min(expected, kMaxPilots))));
    all += areas[t];
    areas[t] *= visible[t];
  }
  const double total = std::accumulate(areas.begin(), areas.end(), 0.0);
  hidden_ = all > 0 ? 1 - total / all : 0;
  sampling_seconds_ += watch.seconds();
  std::vector<MicroLeaf> all_leaves;
  for (size_t t = 0; t < sources.size(); ++t) {
    const double share = total > 0 ? areas[t] / total : 1;
    const double depth = std::round(options_.points_log2 + std::log2(std::max(share, 1e-9)));
    ForestTree tree;
    tree.kind = sources[t].kind;
    tree.instance = sources[t].instance;
    tree.record.depth = static_cast<uint32_t>(std::clamp(static_cast<int>(depth), kMinDepth, options_.points_log2));
    tree.record.first_node = static_cast<uint32_t>(2 * all_leaves.size());

    watch.restart();
    SampledSurface sampled = sampler.sample(sources[t], visible[t], tree.leaves(), [&](double fraction) {
      report(std::min(1.0, (static_cast<double>(all_leaves.size()) + fraction * tree.leaves()) / expected), "points");
    });
    sampling_seconds_ += watch.seconds();
    watch.restart();
    if (options_.posed && tree.kind == TreeKind::deforming) pose_points(buffers_, sampled.points);
    const std::vector<uint32_t> order = tree_order(sampled.points, options_.threads);
    tree.placed_area = sampled.area;
    tree.world_area = areas[t];
    tree.covered = sources[t].plain_area > 0 ? visible[t] * sources[t].covered_area / sources[t].plain_area : 1;
    const bool posed = options_.posed && tree.kind == TreeKind::deforming;
    tree.built_radius_sum = ordered_radius_sum(sampled.points, order, tree.record.depth,
                                               (posed ? areas[t] : sampled.area) / tree.leaves(), options_.disc_scale);
    for (const uint32_t i : order) all_leaves.push_back(leaf_of(sampled.points[i]));
    ordering_seconds_ += watch.seconds();
    set_grid(tree, &sources[t]);
    trees_.push_back(tree);
    sources[t].sides = {};
  }
  visibility.reset();
  leaf_count_ = static_cast<uint32_t>(all_leaves.size());
  leaves = TypedBuffer<MicroLeaf>(device_, owner_, "leaves", all_leaves, kFewerPoints);
  leaf_albedo = TypedBuffer<uint2>(device_, owner_, "albedo of leaves", leaf_count_, kFewerPoints);
  nodes = TypedBuffer<uint4>(device_, owner_, "nodes", size_t{2} * leaf_count_, kFewerPoints);
  clips = TypedBuffer<uint4>(device_, owner_, "bounds of discs", leaf_count_, kFewerPoints);
  radiance = TypedBuffer<uint2>(device_, owner_, "radiance of nodes", size_t{2} * leaf_count_, kFewerPoints);
  radiance_unit = TypedBuffer<float>(device_, owner_, "unit of radiance", std::vector<float>{1.f});
  tree_records = TypedBuffer<MicroTree>(device_, owner_, "trees", trees_.size());
}

/// The cube of the grid about the tree's points, and where it lies in the world. `source`: of a tree that is being
/// made.
void PointForest::set_grid(ForestTree& tree, const TreeSource* source) {
  glm::vec3 low, high;
  double area = tree.placed_area;  // in tree space
  if (tree.kind == TreeKind::deforming) {
    const Bounds box = scene_.instance_bounds(tree.instance);
    low = box.min, high = box.max;
    area = tree.covered * instance_area(scene_, tree.instance);
  } else if (source) {
    low = source->low, high = source->high;
  } else {
    set_transform(tree);
    return;
  }
  // A margin, since the device's vertices are not rounded as the host's.
  const glm::vec3 extent = high - low;
  const float size = std::max({extent.x, extent.y, extent.z, 1e-6f}) * 1.0002f;
  const glm::vec3 origin = 0.5f * (low + high) - 0.5f * size;
  const float step = size / MICRO_GRID;
  tree.record.origin_step = float4(origin, step);
  tree.record.leaf_area = static_cast<float>(area / tree.leaves() / (static_cast<double>(step) * step));
  set_transform(tree);
}

void PointForest::set_transform(ForestTree& tree) const {
  glm::mat4 world_from_tree(1);
  if (tree.kind == TreeKind::rigid)
    world_from_tree = scene_.instances[static_cast<size_t>(tree.instance)].world_from_object;
  const float step = tree.record.origin_step.w;
  glm::mat4 tree_from_grid(step);
  tree_from_grid[3] = glm::vec4(tree.record.origin_step.xyz(), 1);
  const glm::mat4 world_from_grid = world_from_tree * tree_from_grid;
  const glm::mat4 grid_from_world(glm::inverse(glm::dmat4(world_from_grid)));
  MicroTree& record = tree.record;
  float4* const grid_rows[3] = {&record.grid_row0, &record.grid_row1, &record.grid_row2};
  for (int row = 0; row < 3; ++row) *grid_rows[row] = matrix_row(grid_from_world, row);
  record.world_step = glm::length(glm::vec3(world_from_grid[0]));
}

void PointForest::derive_albedo() {
  ScheduleRecorder recorder = scheduler_.record("albedo of leaves", owner_);
  PassBuilder pass = recorder.pass("albedo of leaves", program_, "store_leaf_albedo");
  buffers_.bind(pass);
  pass.global(leaf_count_).arg("leaves", leaves).arg("count", leaf_count_).arg("leaf_albedo", leaf_albedo);
  Schedule schedule = recorder.compile();
  scheduler_.run_to_end(schedule);
}

/// Leaves and inner nodes of these trees, and the records of all.
void PointForest::derive(const std::vector<size_t>& which) {
  std::vector<MicroTree> records;
  for (const ForestTree& tree : trees_) records.push_back(tree.record);
  scheduler_.finish();
  tree_records.write(records.data(), records.size() * sizeof(MicroTree));
  if (which.empty()) return;
  ScheduleRecorder recorder = scheduler_.record(kDerivation, owner_);
  for (const size_t t : which) {
    const ForestTree& tree = trees_[t];
    const auto number = static_cast<uint32_t>(t);
    MicroLeafRules rules{};
    rules.tree = number;
    rules.object_space = tree.kind == TreeKind::rigid;
    rules.disc_radius = options_.disc_scale * static_cast<float>(std::sqrt(tree.placed_area / (pi * tree.leaves())));
    rules.all_cullable = options_.all_cullable;
    rules.min_area = 1 / (options_.disc_scale * options_.disc_scale);
    PassBuilder leaf_pass = recorder.pass("update leaves", program_, "update_leaves");
    buffers_.bind(leaf_pass);
    leaf_pass.global(tree.leaves())
        .arg("mesh_vertices", buffers_.scene_mesh_vertices)
        .arg("leaves", leaves)
        .arg("trees", tree_records)
        .arg("rules", rules)
        .arg("count", tree.leaves())
        .arg("triangle_edges", triangle_edges)
        .arg("nodes", nodes)
        .arg("clips", clips);
    add_level_passes(recorder, "refit", program_, "refit_nodes", number,
                     [&](PassBuilder& pass) { pass.arg("nodes", nodes); });
  }
  Schedule schedule = recorder.compile();
  const double before = update_seconds();
  scheduler_.run_to_end(schedule);
  updating_seconds_ = update_seconds() - before;
}

/// Device time of all derivations that the profile holds.
double PointForest::update_seconds() const {
  scheduler_.finish();
  double sum = 0;
  for (const PassProfile& pass : scheduler_.profile().passes)
    sum += pass.schedule == kDerivation ? pass.device_seconds : 0;
  return sum;
}

double PointForest::radius_sum(const ForestTree& tree) const {
  const uint32_t level = std::min(kQualityLevel, tree.record.depth), count = 1u << level;
  scheduler_.finish();
  double sum = 0;
  for (const uint4& node : nodes.download(tree.record.first_node + count, count)) sum += half_to_float(node.y >> 16);
  // In leaf radii, so that the grid, which follows the bounds, does not matter.
  return sum / std::sqrt(static_cast<double>(tree.record.leaf_area));
}

bool PointForest::too_loose(const ForestTree& tree) const {
  return radius_sum(tree) > kLoosest * tree.built_radius_sum;
}

/// Whether its area in the world has become much larger than when its number of points was chosen.
bool PointForest::outgrown(const ForestTree& tree) const {
  double area = 0;
  if (tree.kind == TreeKind::rigid) {
    const glm::vec3 axis(scene_.instances[static_cast<size_t>(tree.instance)].world_from_object[0]);
    area = tree.placed_area * static_cast<double>(glm::dot(axis, axis));
  } else {
    area = tree.covered * instance_area(scene_, tree.instance);
  }
  return area > kMaxGrowth * tree.world_area;
}

bool PointForest::update(const SceneChange& change) {
  if (change.topology) return false;
  if (placing() != placed_materials_) return false;
  for (const int m : change.materials) {
    if (scene_.materials[static_cast<size_t>(m)].alpha_mode != AlphaMode::opaque) return false;  // its alpha may differ
  }
  const auto tree_of = [&](int instance) {
    return std::find_if(trees_.begin(), trees_.end(), [&](const ForestTree& t) { return t.instance == instance; });
  };
  const auto is_uncovered = [this](int instance) {
    return std::find(uncovered_.begin(), uncovered_.end(), instance) != uncovered_.end();
  };
  std::vector<size_t> deformed;
  for (const int instance : change.moved_instances) {
    if (is_uncovered(instance)) continue;
    const auto tree = tree_of(instance);
    if (tree == trees_.end() || outgrown(*tree)) return false;
    const SceneInstance& moved = scene_.instances[static_cast<size_t>(instance)];
    if (tree->kind == TreeKind::rigid && !is_similarity(moved.world_from_object)) return false;
    if (tree->kind == TreeKind::rigid)
      set_transform(*tree);
    else
      deformed.push_back(static_cast<size_t>(tree - trees_.begin()));
  }
  for (const int instance : change.deformed_instances) {
    if (is_uncovered(instance)) continue;
    const auto tree = tree_of(instance);
    if (tree == trees_.end() || tree->kind != TreeKind::deforming || outgrown(*tree)) return false;
    deformed.push_back(static_cast<size_t>(tree - trees_.begin()));
  }
  std::sort(deformed.begin(), deformed.end());
  deformed.erase(std::unique(deformed.begin(), deformed.end()), deformed.end());
  for (const size_t t : deformed) set_grid(trees_[t], nullptr);
  if (!change.materials.empty()) derive_albedo();  // sidedness is as it was, above
  derive(deformed);
  loosened_ = std::any_of(deformed.begin(), deformed.end(), [&](size_t t) { return too_loose(trees_[t]); });
  return !loosened_;
}

PointForest::Size PointForest::estimate(const Scene& scene, const ForestOptions& options) {
  // Rounding to powers of two, and the least size of a tree.
  size_t trees = 1;
  for (const SceneInstance& instance : scene.instances) trees += instance.pose || !scene.animations.empty();
  const size_t leaves = (trees > 1 ? size_t{3} << options.points_log2 >> 1 : size_t{1} << options.points_log2) +
                        (trees - 1) * (size_t{1} << kMinDepth);
  const size_t per_leaf = sizeof(MicroLeaf) + sizeof(uint2) + 2 * (sizeof(uint4) + sizeof(uint2)) + sizeof(uint4);
  const size_t held = leaves * per_leaf + trees * sizeof(MicroTree),
               triangle_edges = scene.triangle_count() * sizeof(TriangleEdges);
  const size_t measuring =
      options.skip_hidden ? PointVisibility::estimate_bytes(scene, leaves) : 0;  // before there are leaves
  return {leaves, std::max(held, measuring) + triangle_edges};
}

}  // namespace lucarium::micro
