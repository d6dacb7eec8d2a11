// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh/bvh.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <thread>
#include <utility>

#include "lucarium/base/error.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/moving_parts.h"
#include "lucarium/services/bvh/two_level_bvh.h"
#include "lucarium/services/ray_shares/ray_shares.h"

namespace lucarium {

namespace {

constexpr uint32_t minimum_stack = 128;  // so that most scenes share one compiled program
constexpr size_t slice_rays = 1u << 15;  // per compute unit, between two looks at the cancel flag
constexpr size_t scalar_local_size = 64;

struct TraversalShape {
  int width, leaf_size;
  bool shares;  // runs of rays per work-item, else one ray
};

struct NamedTraversal {
  const char* name;
  BvhTraversal traversal;
};
constexpr NamedTraversal named_traversals[] = {{"wide", BvhTraversal::wide},
                                               {"wide-portable", BvhTraversal::wide_portable},
                                               {"wide-16", BvhTraversal::wide_16},
                                               {"wide-8", BvhTraversal::wide_8},
                                               {"wide-16-portable", BvhTraversal::wide_16_portable},
                                               {"wide-8-portable", BvhTraversal::wide_8_portable},
                                               {"scalar", BvhTraversal::scalar}};

bool is_portable(BvhTraversal traversal) {
  return traversal != BvhTraversal::wide_16 && traversal != BvhTraversal::wide_8;
}

TraversalShape shape_of(BvhTraversal traversal) {
  switch (traversal) {
    case BvhTraversal::scalar: return {4, 4, false};
    case BvhTraversal::wide_8:
    case BvhTraversal::wide_8_portable: return {8, 4, true};
    default: return {16, 8, true};
  }
}

BvhTraversal named_traversal(const std::string& name) {
  std::string known;
  for (const NamedTraversal& each : named_traversals) {
    if (name == each.name) return each.traversal;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", each.name);
  }
  throw_error(ErrorClass::usage, "LUCARIUM_BVH='{}': must be one of {}", name, known);
}

BvhTraversal choose_traversal(BvhTraversal asked, const DeviceInfo& device) {
  if (asked == BvhTraversal::automatic) {
    const char* value = std::getenv("LUCARIUM_BVH");
    if (value && *value)
      asked = named_traversal(value);
    else
      asked = device.type == DeviceType::cpu ? BvhTraversal::wide : BvhTraversal::scalar;
  }
  const bool sixteen = device.native_float_lanes >= 16;
  if (asked == BvhTraversal::wide) return sixteen ? BvhTraversal::wide_16 : BvhTraversal::wide_8;
  if (asked == BvhTraversal::wide_portable)
    return sixteen ? BvhTraversal::wide_16_portable : BvhTraversal::wide_8_portable;
  return asked;
}

void write_words(TypedBuffer<uint32_t>& buffer, const TwoLevelBvh::Words& words, bool all,
                 std::span<const std::pair<size_t, size_t>> changed) {
  if (all) {
    if (!words.empty()) buffer.write(words.data(), sizeof(uint32_t) * words.size());
    return;
  }
  for (const auto& [first, end] : changed)
    if (end > first) buffer.write(words.data() + first, sizeof(uint32_t) * (end - first), sizeof(uint32_t) * first);
}

}  // namespace

struct Bvh::State {
  State(Device& on, const SceneBuffers* of, BvhTraversal asked)
      : device(&on),
        traversal(choose_traversal(asked, on.info())),
        shape(shape_of(traversal)),
        scene(of),
        hierarchy(shape.width, shape.leaf_size, std::max(1u, std::thread::hardware_concurrency())) {}

  Device* device;
  BvhTraversal traversal;
  TraversalShape shape;
  const SceneBuffers* scene;  // for MASK and BLEND materials; null: everything is opaque
  TwoLevelBvh hierarchy;
  MovingParts parts;  // which instance lies in which part of the hierarchy
  WorldGeometry geometry;
  Program program;
  uint32_t program_stack = 0;
  bool program_alpha = false;
  TypedBuffer<uint32_t> nodes, blocks;
  bool uploaded = false;                        // these hold what the hierarchy did after its last change
  size_t vertex_count = 0, triangle_count = 0;  // of the last build
  BvhStatistics statistics;
  uint64_t generation = 0;

  void build(std::span<const Vertex> vertices, std::span<const Triangle> triangles,
             std::vector<TwoLevelBvh::Part> ranges);
  void build_scene(const SceneBuffers& buffers);
  void follow(const SceneBuffers& buffers, const SceneChange& change);
  bool same_counts(size_t vertices, size_t triangles) const {
    return vertices == vertex_count && triangles == triangle_count;
  }
  void prepare_refit();
  void upload();
  void compile();
  void record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel, const RayBuffers& rays,
              const char* result_name, const BufferRef& result) const;
};

void Bvh::State::build(std::span<const Vertex> vertices, std::span<const Triangle> triangles,
                       std::vector<TwoLevelBvh::Part> ranges) {
  const Stopwatch watch;
  vertex_count = vertices.size();
  triangle_count = triangles.size();
  hierarchy.build(vertices, triangles, std::move(ranges));
  statistics.build_seconds = watch.seconds();
}

/// Builds the hierarchies of the scene's parts.
void Bvh::State::build_scene(const SceneBuffers& buffers) {
  geometry.read_all(buffers);
  build(geometry.vertices, geometry.triangles, parts.ranges(buffers));
  if (hierarchy.parts().size() == 1) geometry = {};  // nothing is known to move: read again should something
}

/// Brings back the words that were given up after the upload.
void Bvh::State::prepare_refit() {
  if (hierarchy.can_refit()) return;
  TwoLevelBvh::Words node_words, block_words;
  if (hierarchy.released()) {
    node_words.resize(hierarchy.node_word_count());
    block_words.resize(hierarchy.block_word_count());
    nodes.read(node_words.data(), sizeof(uint32_t) * node_words.size());
    blocks.read(block_words.data(), sizeof(uint32_t) * block_words.size());
  }
  hierarchy.restore(std::move(node_words), std::move(block_words));
}

void Bvh::State::follow(const SceneBuffers& buffers, const SceneChange& change) {
  prepare_refit();
  geometry.read_instances(buffers, change);
  std::vector<size_t> moved = parts.touched(change);
  for (const size_t part : moved) {
    if (hierarchy.refit(part, geometry.vertices, geometry.triangles)) continue;
    if (part == MovingParts::resting) {
      // A moving instance would degrade the static part again and again: give it a part of its own.
      parts.separate(change);
      build(geometry.vertices, geometry.triangles, parts.ranges(buffers));
      return;
    }
    hierarchy.rebuild(part, geometry.vertices, geometry.triangles);
  }
  hierarchy.join(moved);
}

/// Buffers that are too small are replaced: both or, if memory does not suffice, none, so that what was recorded and
/// what will be recorded stay usable. The old ones live until the last schedule that was recorded with them is gone.
void Bvh::State::upload() {
  const char* const remedy = "use a scene with fewer triangles";
  const auto too_small = [](const TypedBuffer<uint32_t>& buffer, const TwoLevelBvh::Words& words) {
    return !buffer || buffer.count() < words.size();
  };
  const bool new_nodes = too_small(nodes, hierarchy.node_words()),
             new_blocks = too_small(blocks, hierarchy.block_words());
  const size_t bytes =
      (new_nodes ? 4 * hierarchy.node_words().size() : 0) + (new_blocks ? 4 * hierarchy.block_words().size() : 0);
  const bool all = !std::exchange(uploaded, false);
  if (bytes > 0) device->memory().require_total("bvh", "hierarchy", bytes, remedy);
  const auto allocate = [&](const char* name, const TwoLevelBvh::Words& words) {
    return TypedBuffer<uint32_t>(*device, "bvh", name, std::max<size_t>(1, words.size()), remedy);
  };
  TypedBuffer<uint32_t> node_buffer = new_nodes ? allocate("nodes", hierarchy.node_words()) : nodes;
  TypedBuffer<uint32_t> block_buffer = new_blocks ? allocate("leaf blocks", hierarchy.block_words()) : blocks;
  nodes = std::move(node_buffer);
  blocks = std::move(block_buffer);
  if (new_nodes || new_blocks) ++generation;
  write_words(nodes, hierarchy.node_words(), all || new_nodes, hierarchy.changed_nodes());
  write_words(blocks, hierarchy.block_words(), all || new_blocks, hierarchy.changed_blocks());
  uploaded = true;
  hierarchy.release();
  statistics.triangles = hierarchy.triangle_count();
  statistics.ignored_triangles = hierarchy.ignored_count();
  statistics.nodes = hierarchy.node_count();
  statistics.leaf_blocks = hierarchy.block_count();
  statistics.bytes = nodes.bytes() + blocks.bytes();
  statistics.sah_cost = hierarchy.sah_cost();
  statistics.parts = static_cast<uint32_t>(hierarchy.parts().size());
  statistics.part_builds = hierarchy.builds();
  statistics.part_refits = hierarchy.refits();
  statistics.host_bytes = hierarchy.host_bytes();
}

void Bvh::State::compile() {
  const uint32_t stack = std::max({minimum_stack, std::bit_ceil(hierarchy.stack_size()), program_stack});
  const bool alpha = scene && (scene->info().flags & LUCARIUM_SCENE_HAS_ALPHA);
  if (program && stack == program_stack && alpha == program_alpha) return;
  ProgramSpec spec{.name = "services/bvh", .files = {"lucarium/services/bvh/intersect.cl"}};
  spec.defines = {{"BVH_WIDTH", std::to_string(shape.width)},
                  {"BVH_LEAF", std::to_string(shape.leaf_size)},
                  {"BVH_STACK", std::to_string(stack)}};
  if (is_portable(traversal)) spec.defines["BVH_PORTABLE"] = "";
  if (alpha) spec.defines["BVH_ALPHA"] = "";
  // Watertight edge functions must round both products alike: no contraction but where the source asks for it.
  spec.mad_enable = false;
  program = Program(*device, SourceLibrary(), spec);
  program_stack = stack;
  program_alpha = alpha;
  ++generation;
}

void Bvh::State::record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel,
                        const RayBuffers& rays, const char* result_name, const BufferRef& result) const {
  PassBuilder pass = recorder.pass(pass_name, program, kernel);
  if (shape.shares)
    trace_by_shares(pass, rays, *device);
  else
    pass.global(std::max<size_t>(1, rays.capacity))
        .local(scalar_local_size)
        .slice(slice_rays * std::max(1u, device->info().compute_units))
        .arg("counter", rays.counter)
        .arg("counter_index", rays.counter_index)
        .arg("capacity", rays.capacity);
  pass.arg("rays", rays.rays)
      .arg(result_name, result)
      .arg("bvh_nodes", nodes)
      .arg("bvh_blocks", blocks)
      .arg_if_present("row", rays.row);
  if (program_alpha) scene->bind(pass);
}

Bvh::Bvh(Device& device, const Scene& scene, const SceneBuffers& buffers, BvhTraversal traversal)
    : state_(std::make_unique<State>(device, &buffers, traversal)) {
  SceneChange everything;
  everything.topology = true;
  update(scene, buffers, everything);
}

Bvh::Bvh(Device& device, std::span<const Vertex> vertices, std::span<const Triangle> triangles, BvhTraversal traversal)
    : state_(std::make_unique<State>(device, nullptr, traversal)) {
  update(vertices, triangles, true);
}

Bvh::~Bvh() = default;

void Bvh::update(const Scene& scene, const SceneBuffers& buffers, const SceneChange& change) {
  State& s = *state_;
  s.scene = &buffers;
  if (change.topology || !s.same_counts(buffers.scene_vertices.count(), buffers.info().triangle_count)) {
    s.parts = MovingParts(scene);
    s.build_scene(buffers);
  } else if (change.geometry()) {
    s.follow(buffers, change);
  } else {
    s.compile();
    return;
  }
  s.compile();
  s.upload();
}

void Bvh::update(std::span<const Vertex> vertices, std::span<const Triangle> triangles, bool topology) {
  State& s = *state_;
  const size_t all[] = {0};
  if (!topology && s.same_counts(vertices.size(), triangles.size()))
    s.prepare_refit();
  else
    topology = true;
  if (topology || !s.hierarchy.refit(0, vertices, triangles))
    s.build(vertices, triangles, {{{0, static_cast<uint32_t>(triangles.size())}}});
  else
    s.hierarchy.join(all);
  s.compile();  // before the upload: a program for more stack serves the old hierarchy, too
  s.upload();
}

uint64_t Bvh::generation() const { return state_->generation; }

void Bvh::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                         const BufferRef& hits) const {
  state_->record(recorder, pass_name, "bvh_closest", rays, "hits", hits);
}

void Bvh::record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                     const BufferRef& occluded) const {
  state_->record(recorder, pass_name, "bvh_any", rays, "occluded", occluded);
}

BvhTraversal Bvh::traversal() const { return state_->traversal; }

const BvhStatistics& Bvh::statistics() const { return state_->statistics; }

size_t Bvh::estimate_bytes(const Scene& scene) {
  size_t max_bytes = 0;  // which one the device will get is not known here
  for (const BvhTraversal traversal : {BvhTraversal::wide_16, BvhTraversal::wide_8}) {
    const TraversalShape shape = shape_of(traversal);
    max_bytes = std::max(max_bytes, WideBvh::estimate_bytes(scene.triangle_count(), shape.width, shape.leaf_size));
  }
  return max_bytes;
}

}  // namespace lucarium
