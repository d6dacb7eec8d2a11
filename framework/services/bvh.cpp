// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/bvh.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/services/bvh_wide.h"

namespace lucarium {

namespace {

constexpr double rebuild_ratio = 1.5;     // of the SAH cost after refits to the cost as built
constexpr uint32_t minimum_stack = 128;   // so that most scenes share one compiled program
constexpr size_t slice_rays = 1u << 16;   // between two looks at the cancel flag

struct TraversalShape {
  int width, leaf_size;
  uint32_t rays_per_item;
  size_t local_size;
};

TraversalShape shape_of(BvhTraversal traversal) {
  return traversal == BvhTraversal::scalar ? TraversalShape{4, 4, 1, 64} : TraversalShape{16, 8, 1024, 1};
}

BvhTraversal choose_traversal(BvhTraversal asked, const DeviceInfo& device) {
  if (asked != BvhTraversal::automatic) return asked;
  if (const char* value = std::getenv("LUCARIUM_BVH"); value && *value) {
    const std::string name = value;
    if (name == "wide") return BvhTraversal::wide;
    if (name == "wide-portable") return BvhTraversal::wide_portable;
    if (name == "scalar") return BvhTraversal::scalar;
    throw_error(ErrorClass::usage, "LUCARIUM_BVH='{}': must be wide, wide-portable or scalar", name);
  }
  return device.type == DeviceType::cpu ? BvhTraversal::wide : BvhTraversal::scalar;
}

/// Buffers are never empty, so the count comes from the scene.
std::vector<Triangle> scene_triangles(const SceneBuffers& buffers) {
  return buffers.scene_triangles.download(0, buffers.info().triangle_count);
}

}  // namespace

struct Bvh::State {
  State(Device& on, const SceneBuffers* of, BvhTraversal asked)
      : device(&on), traversal(choose_traversal(asked, on.info())), shape(shape_of(traversal)), scene(of) {}

  Device* device;
  BvhTraversal traversal;
  TraversalShape shape;
  const SceneBuffers* scene;  // for MASK and BLEND materials; null: everything is opaque
  WideBvh tree;
  std::vector<uint32_t> ignored;  // triangles that nothing could hit when the tree was built
  double built_cost = 0;
  Program program;
  uint32_t program_stack = 0;
  bool program_alpha = false;
  TypedBuffer<uint32_t> nodes, blocks;
  BvhStatistics statistics;
  uint64_t generation = 0;

  void build(std::span<const Vertex> vertices, std::span<const Triangle> triangles);
  bool refit(std::span<const Vertex> vertices, std::span<const Triangle> triangles);
  void upload();
  void compile();
  void record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel, const BufferRef& rays,
              const char* result_name, const BufferRef& result, const BufferRef& counter, uint32_t counter_index,
              uint32_t capacity) const;
};

void Bvh::State::build(std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<BoundedTriangle> bounded;
  bounded.reserve(triangles.size());
  ignored.clear();
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    BoundedTriangle triangle;
    triangle.triangle = i;
    if (bound_triangle(vertices, triangles[i], triangle.box))
      bounded.push_back(triangle);
    else
      ignored.push_back(i);
  }
  statistics.triangles = static_cast<uint32_t>(bounded.size());
  statistics.ignored_triangles = static_cast<uint32_t>(ignored.size());
  const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  tree = WideBvh(build_binary_bvh(std::move(bounded), threads), shape.width, shape.leaf_size, threads);
  tree.fit(vertices, triangles);
  built_cost = tree.sah_cost();
  statistics.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Returns false when a rebuild is due instead.
bool Bvh::State::refit(std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  Box unused;
  for (const uint32_t triangle : ignored)
    if (triangle >= triangles.size() || bound_triangle(vertices, triangles[triangle], unused)) return false;
  tree.fit(vertices, triangles);
  return tree.sah_cost() <= rebuild_ratio * built_cost;
}

void Bvh::State::upload() {
  const auto put = [&](TypedBuffer<uint32_t>& buffer, const char* name, const std::vector<uint32_t>& words) {
    if (!buffer || buffer.count() < words.size()) {
      buffer = {};  // release first: the old and the new one need not fit together
      buffer = TypedBuffer<uint32_t>(*device, "bvh", name, words.size(), "use a scene with fewer triangles");
      ++generation;
    }
    buffer.upload(words);
  };
  const size_t bytes = 4 * (tree.node_words().size() + tree.block_words().size());
  const size_t held = (nodes ? nodes.bytes() : 0) + (blocks ? blocks.bytes() : 0);
  if (bytes > held) device->memory().require("bvh", "hierarchy", bytes - held, "use a scene with fewer triangles");
  put(nodes, "nodes", tree.node_words());
  put(blocks, "leaf blocks", tree.block_words());
  statistics.nodes = tree.node_count();
  statistics.leaf_blocks = tree.block_count();
  statistics.bytes = nodes.bytes() + blocks.bytes();
  statistics.sah_cost = tree.sah_cost();
}

void Bvh::State::compile() {
  const uint32_t stack = std::max({minimum_stack, std::bit_ceil(tree.stack_size()), program_stack});
  const bool alpha = scene && (scene->info().flags & LUCARIUM_SCENE_HAS_ALPHA);
  if (program && stack == program_stack && alpha == program_alpha) return;
  ProgramSpec spec{.name = "services/bvh", .files = {"lucarium/services/bvh_intersect.cl"}};
  spec.defines = {{"BVH_WIDTH", std::to_string(shape.width)},
                  {"BVH_LEAF", std::to_string(shape.leaf_size)},
                  {"BVH_STACK", std::to_string(stack)},
                  {"BVH_CHUNK", std::to_string(shape.rays_per_item)}};
  if (traversal != BvhTraversal::wide) spec.defines["BVH_PORTABLE"] = "";
  if (alpha) spec.defines["BVH_ALPHA"] = "";
  // Watertight edge functions must round both products alike: no contraction but where the source asks for it.
  spec.mad_enable = false;
  program = Program(*device, SourceLibrary(), spec);
  program_stack = stack;
  program_alpha = alpha;
  ++generation;
}

void Bvh::State::record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel,
                        const BufferRef& rays, const char* result_name, const BufferRef& result,
                        const BufferRef& counter, uint32_t counter_index, uint32_t capacity) const {
  const size_t items = std::max<size_t>(1, (size_t{capacity} + shape.rays_per_item - 1) / shape.rays_per_item);
  PassBuilder pass = recorder.pass(pass_name, program, kernel);
  pass.global(items).local(shape.local_size).slice(slice_rays / shape.rays_per_item)
      .arg("rays", rays).arg(result_name, result)
      .arg("counter", counter).arg("counter_index", counter_index).arg("capacity", capacity)
      .arg("bvh_nodes", nodes).arg("bvh_blocks", blocks);
  if (program_alpha) scene->bind(pass, program, kernel);
}

Bvh::Bvh(Device& device, const Scene&, const SceneBuffers& buffers, BvhTraversal traversal)
    : state_(std::make_unique<State>(device, &buffers, traversal)) {
  update(buffers.scene_vertices.download(), scene_triangles(buffers), true);
}

Bvh::Bvh(Device& device, std::span<const Vertex> vertices, std::span<const Triangle> triangles, BvhTraversal traversal)
    : state_(std::make_unique<State>(device, nullptr, traversal)) {
  update(vertices, triangles, true);
}

Bvh::~Bvh() = default;

void Bvh::update(const Scene&, const SceneBuffers& buffers, const SceneChange& change) {
  state_->scene = &buffers;
  if (change.geometry())
    update(buffers.scene_vertices.download(), scene_triangles(buffers), change.topology);
  else
    state_->compile();
}

void Bvh::update(std::span<const Vertex> vertices, std::span<const Triangle> triangles, bool topology) {
  if (topology || !state_->refit(vertices, triangles)) state_->build(vertices, triangles);
  state_->upload();
  state_->compile();
}

uint64_t Bvh::generation() const { return state_->generation; }

void Bvh::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                         const BufferRef& hits, const BufferRef& counter, uint32_t counter_index,
                         uint32_t capacity) const {
  state_->record(recorder, pass_name, "bvh_closest", rays, "hits", hits, counter, counter_index, capacity);
}

void Bvh::record_any(ScheduleRecorder& recorder, const std::string& pass_name, const BufferRef& rays,
                     const BufferRef& occluded, const BufferRef& counter, uint32_t counter_index,
                     uint32_t capacity) const {
  state_->record(recorder, pass_name, "bvh_any", rays, "occluded", occluded, counter, counter_index, capacity);
}

BvhTraversal Bvh::traversal() const { return state_->traversal; }

const BvhStatistics& Bvh::statistics() const { return state_->statistics; }

size_t Bvh::estimate_bytes(const Scene& scene) {
  const TraversalShape shape = shape_of(BvhTraversal::wide);
  return WideBvh::estimate_bytes(scene.triangle_count(), shape.width, shape.leaf_size);
}

}  // namespace lucarium
