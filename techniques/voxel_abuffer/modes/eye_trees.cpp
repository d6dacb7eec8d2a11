// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/modes/eye_trees.h"

#include <algorithm>
#include <cstring>

#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/services/ray_ends.h"
#include "voxel_abuffer/base/name.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {
namespace {

constexpr uint32_t kChunk = 1 << 16;  // rays that are traced at once
enum Layer { emission, direct, ambient, crossings };

uint32_t chunk_size(size_t pixels) { return static_cast<uint32_t>(std::min<size_t>(pixels, kChunk)); }

}  // namespace

EyeTrees::EyeTrees(const ModeContext& context, const Options& options)
    : scheduler_(&context.scheduler),
      options_(options),
      pixels_(context.pixels()),
      chunk_(chunk_size(pixels_)),
      frame_(context.frame),
      primitives_(context.scheduler.device()),
      direct_light_(context.scheduler.device(), context.scheduler, context.scene, context.intersector, technique_name),
      sums_(context.scheduler, pixels_, {"emission", "direct", "ambient", "crossings"}, options.samples) {
  Device& device = scheduler_->device();
  const auto make = [&]<class T>(TypedBuffer<T>& buffer, const char* name, size_t count) {
    buffer = TypedBuffer<T>(device, technique_name, name, count, remedies::lower_size);
  };
  const size_t queued = size_t{2} * chunk_ * queues();
  make(rays_, "rays of a chunk", chunk_);
  make(tree_rays_, "a chunk of trees", chunk_);
  make(points_, "points of a chunk", chunk_);
  make(lit_, "direct light of a chunk", chunk_);
  make(counts_, "numbers of a chunk's rays", 2);
  make(next_count_, "number of rays that go on", 1);
  make(queued_rays_, "queues of rays", queued);
  make(queued_tree_rays_, "queues of trees", queued);
  ends_ = make_ray_ends(device, context.intersector, technique_name, "ends of a chunk's rays", chunk_,
                        remedies::lower_size);
  queued_ends_ =
      make_ray_ends(device, context.intersector, technique_name, "ends of queued rays", queued, remedies::lower_size);
  record(context);
}

uint32_t EyeTrees::place(uint32_t level) const {
  // Camera rays need no queue. Rays that go straight on are all of one level.
  return 2 * chunk_ * (options_.straight ? level % 2 : level - 1);
}

void EyeTrees::record(const ModeContext& context) {
  const Program program = make_program(
      scheduler_->device(), voxel_abuffer_kernels(),
      {"voxel_abuffer/modes/begin_trees", "voxel_abuffer/modes/shade_tree_rays", "voxel_abuffer/modes/add_tree_light"},
      ray_end_defines(context.intersector));
  record_camera(program);
  record_load(program);
  record_shade(context, program);
  record_add(program);
}

void EyeTrees::record_camera(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("begin trees", technique_name);
  camera_frame_ = recorder.variable("frame", frame_);
  camera_rules_ = recorder.variable("rules", TreeRules{});
  recorder.pass("camera rays", program, "begin_camera_rays")
      .global(chunk_)
      .arg("frame", camera_frame_)
      .arg("rules", camera_rules_)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("tree_rays", tree_rays_)
      .arg("counts", counts_);
  camera_ = recorder.compile();
}

void EyeTrees::record_load(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("load rays of trees", technique_name);
  load_rules_ = recorder.variable("rules", TreeRules{});
  recorder.pass("load rays", program, "load_rays")
      .global(chunk_)
      .arg("rules", load_rules_)
      .arg("queued_rays", queued_rays_)
      .arg("queued_tree_rays", queued_tree_rays_)
      .arg_if_present("queued_ends", queued_ends_)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("tree_rays", tree_rays_)
      .arg("counts", counts_);
  load_ = recorder.compile();
}

void EyeTrees::record_shade(const ModeContext& context, const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("grow trees", technique_name);
  shade_rules_ = recorder.variable("rules", TreeRules{});
  const uint32_t places = 2 * chunk_;
  const BufferRef hits = recorder.transient<Hit>("hits", chunk_, remedies::lower_size);
  const NextRays next = {
      recorder.transient<Ray>("next rays", places, remedies::lower_size),
      recorder.transient<TreeRay>("next rays of trees", places, remedies::lower_size),
      transient_ray_ends(recorder, context.intersector, "ends of next rays", places, remedies::lower_size),
      recorder.transient<uint32_t>("goes on", places, remedies::lower_size)};
  context.primary.record_closest(recorder, "closest hit", {rays_, counts_, 0, chunk_, ends_}, hits);
  PassBuilder shade = recorder.pass("shade rays of trees", program, "shade_tree_rays");
  context.scene.bind(shade);
  shade.global(chunk_)
      .arg("rules", shade_rules_)
      .arg("places", chunk_)
      .arg("rays", rays_)
      .arg("hits", hits)
      .arg("tree_rays", tree_rays_)
      .arg_if_present("next_ends", next.ends)
      .arg("points", points_)
      .arg("next_rays", next.rays)
      .arg("next_tree_rays", next.tree_rays)
      .arg("goes_on", next.goes_on);
  record_queue(recorder, program, next);
  recorder.fill_zero("clear direct light", lit_);
  recorder.read_back("rays that go on", next_count_, [this](std::span<const std::byte> bytes) {
    std::memcpy(&next_rays_, bytes.data(), sizeof next_rays_);
  });
  shade_ = recorder.compile();
}

void EyeTrees::record_queue(ScheduleRecorder& recorder, const Program& program, const NextRays& next) {
  const uint32_t places = 2 * chunk_;
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", places, remedies::lower_size);
  primitives_.record_compact(recorder, "compact rays", next.goes_on, survivors, next_count_, 0, counts_, 1, places);
  recorder.pass("queue rays", program, "queue_rays")
      .global(places)
      .arg("rules", shade_rules_)
      .arg("survivors", survivors)
      .arg("survivor_count", next_count_)
      .arg("next_rays", next.rays)
      .arg("next_tree_rays", next.tree_rays)
      .arg_if_present("next_ends", next.ends)
      .arg_if_present("queued_ends", queued_ends_)
      .arg("queued_rays", queued_rays_)
      .arg("queued_tree_rays", queued_tree_rays_);
}

void EyeTrees::record_add(const Program& program) {
  ScheduleRecorder recorder = scheduler_->record("add light of trees", technique_name);
  add_rules_ = recorder.variable("rules", TreeRules{});
  recorder.pass("add light of trees", program, "add_tree_light")
      .global(chunk_)
      .arg("rules", add_rules_)
      .arg("ambient", options_.ambient)
      .arg("tree_rays", tree_rays_)
      .arg("points", points_)
      .arg("lit", lit_)
      .arg("emission", sums_.pass(emission))
      .arg("direct", sums_.pass(direct))
      .arg("ambient_light", sums_.pass(ambient))
      .arg("crossings", sums_.pass(crossings));
  add_ = recorder.compile();
}

bool EyeTrees::trace(const TreeRules& rules, uint32_t chunk) {
  shade_.set(shade_rules_, rules);
  add_.set(add_rules_, rules);
  traced_in_pass_ += rules.count;
  // Light samples of different chunks and levels have numbers of their own.
  const uint32_t seed = indexed_seed(mixed_seed(seed_, rules.level), chunk);
  return scheduler_->run(shade_) == RunResult::done &&
         direct_light_.accumulate_radiance(points_, lit_, rules.sample_index, seed) &&
         scheduler_->run(add_) == RunResult::done;
}

/// Everything that has begun with a chunk of camera rays, the deepest level first.
bool EyeTrees::grow(uint32_t sample_index) {
  for (uint32_t chunk = 1; !levels_.empty(); ++chunk) {
    const auto level = static_cast<uint32_t>(levels_.size());  // camera rays are level 0, and in no queue
    Level& waiting = levels_.back();
    TreeRules rules{};
    rules.straight = options_.straight;
    rules.level = level;
    rules.last_level = options_.depth;
    rules.sample_index = sample_index;
    rules.first = place(level) + waiting.begin;
    rules.count = std::min(chunk_, waiting.end - waiting.begin);
    rules.target = options_.straight || level < options_.depth ? place(level + 1) : 0;
    load_.set(load_rules_, rules);
    if (scheduler_->run(load_) == RunResult::cancelled || !trace(rules, chunk)) return false;
    waiting.begin += rules.count;
    if (next_rays_ > 0) {
      levels_.push_back({0, next_rays_});
      continue;
    }
    while (!levels_.empty() && levels_.back().begin == levels_.back().end) levels_.pop_back();
  }
  return true;
}

bool EyeTrees::sample(uint32_t index) {
  camera_.set(camera_frame_, frame_);
  for (uint32_t pixel = 0; pixel < pixels_; pixel += chunk_) {
    TreeRules rules{};
    rules.straight = options_.straight;
    rules.last_level = options_.depth;
    rules.sample_index = index;
    rules.first = pixel;
    rules.count = std::min(chunk_, pixels_ - pixel);
    rules.target = place(1);
    camera_.set(camera_rules_, rules);
    if (scheduler_->run(camera_) == RunResult::cancelled || !trace(rules, pixel / chunk_)) return false;
    levels_.clear();
    if (next_rays_ > 0) levels_.push_back({0, next_rays_});
    if (!grow(index)) return false;
  }
  return true;
}

bool EyeTrees::pass() {
  traced_in_pass_ = 0;
  if (!sums_.begin()) return false;
  for (uint32_t s = 0; s < options_.samples; ++s)
    if (!sample(passes_ * options_.samples + s)) return false;
  sums_.commit();
  ++passes_;
  traced_ += traced_in_pass_;
  return true;
}

void EyeTrees::restart(const Frame& frame, uint64_t seed) {
  frame_ = frame;
  seed_ = kernel_seed(seed);
  sums_.clear();
  passes_ = 0;
  traced_ = 0;
}

void EyeTrees::write(Film& film) {
  add_mean(film, "emission", sums_.sum(emission));
  add_mean(film, "direct", sums_.sum(direct));
  if (options_.ambient > 0) add_mean(film, "ambient", sums_.sum(ambient));
  FilmLayer& layer = film.layer("crossings", {"Y"});
  layer.pixels.clear();
  for (const float4& sum : sums_.sum(crossings).download()) layer.pixels.push_back(sum.w > 0 ? sum.x / sum.w : 0);
}

void EyeTrees::warm_up() {
  for (Schedule* schedule : {&camera_, &load_, &shade_, &add_}) scheduler_->warm_up(*schedule);
  direct_light_.warm_up(points_, lit_);
  sums_.warm_up();
}

std::map<std::string, double> EyeTrees::counters() const { return {{"closest_rays", traced_}}; }

size_t EyeTrees::estimate_bytes(size_t pixels, const Options& options, bool ray_ends) {
  const size_t chunk = chunk_size(pixels), queues = options.straight ? 2 : options.depth;
  const size_t per_ray = sizeof(Ray) + sizeof(TreeRay) + (ray_ends ? sizeof(RayEnds) : 0);
  return PassSums::estimate_bytes(pixels, 4) + DirectLight::estimate_bytes(chunk, ray_ends) +
         chunk * (per_ray + sizeof(GBufferPoint) + sizeof(float4) + sizeof(Hit) + 2 * per_ray * (queues + 1) +
                  4 * sizeof(uint32_t));
}

}  // namespace lucarium::abuffer
