// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/eye/eye_paths.h"

#include <algorithm>
#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/ray.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

const char* const kRemedy = "lower --size";
constexpr size_t kSlice = 1 << 15;
constexpr uint32_t kCountChunk = 1 << 14;

std::vector<std::string> strategy_names(const Plan& plan) {
  if (!plan.shows_strategies) return {};
  std::vector<std::string> names = {"hit", "nee"};
  for (uint32_t s = 1; s <= plan.light_vertices; ++s) names.push_back("vpl" + std::to_string(s));
  names.push_back("splat");
  return names;
}

}  // namespace

std::map<std::string, std::string> EyePaths::defines() const {
  std::map<std::string, std::string> all = ray_end_defines(intersector_);
  all.merge(eye_defines(plan_));
  return all;
}

EyePaths::EyePaths(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                   const Intersector& intersector, const Frame& frame, const Plan& plan, const LightVertices* vertices,
                   const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      intersector_(intersector),
      frame_(frame),
      plan_(plan),
      vertices_(vertices),
      owner_(owner),
      primitives_(device),
      program_(make_program(device, bidirectional_vpl_kernels(),
                            {"bidirectional_vpl/eye/begin_eye_paths", "bidirectional_vpl/eye/connect_to_all",
                             "bidirectional_vpl/eye/shade_eye_vertices", "bidirectional_vpl/eye/add_eye_light",
                             "bidirectional_vpl/eye/add_iteration", "lucarium/services/path_integrator/advance_paths"},
                            defines())),
      rays_(device, owner, "rays of camera paths", plan.settings.pixels, kRemedy),
      ends_(make_ray_ends(device, intersector, owner, "ends of rays of camera paths", plan.settings.pixels, kRemedy)),
      queue_(device, owner, "queue of camera paths", plan.settings.pixels, kRemedy),
      active_(device, owner, "active camera paths", 1),
      counts_(device, owner, "events of camera paths", BIDIRECTIONAL_COUNTS),
      states_(device, owner, "camera paths", plan.settings.pixels, kRemedy),
      mis_(device, owner, "weights of camera paths", size_t{plan.settings.pixels} * std::max(plan.light_vertices, 1u),
           kRemedy),
      sample_(device, owner, "light of a sample", size_t{plan.settings.pixels} * plan.layers(), kRemedy),
      hits_(device, owner, "hits of camera paths", keeps_hits() ? plan.settings.pixels : 1, kRemedy),
      first_vertices_(device, owner, "first vertices of camera paths",
                      plan.gloss == Gloss::none ? 1 : plan.settings.pixels, kRemedy),
      no_vertices_(device, owner, "no light vertices", 1),
      no_densities_(device, owner, "no densities", 1),
      no_list_(device, owner, "no list", std::vector<uint32_t>{0}),
      no_table_(device, owner, "no candidates", 1),
      sums_(device, owner, plan.settings.pixels, {"emission", "direct"}),
      indirect_sums_(device, owner, plan.settings.pixels, {"indirect"}),
      strategy_sums_(device, owner, plan.settings.pixels, strategy_names(plan)) {
  counts_.fill_zero();
  if (plan.caches) caches_ = std::make_unique<Caches>(device, scheduler, scene, intersector, frame, plan, owner);
  if (plan.filter)
    filter_ = std::make_unique<PixelFilter>(device, scheduler, scene, intersector, frame, plan,
                                            indirect_sums_["indirect"], owner);
  record_begin();
  if (keeps_hits()) record_closest();
  if (plan_.connects_to_all()) record_connect_to_all();
  if (plan_.stores_bundles())
    bundles_ = std::make_unique<BundleEdges>(device, scheduler, scene, plan,
                                             BundleRays{rays_, queue_, active_, states_, hits_}, owner);
  record_bounce();
  record_add();
}

void EyePaths::record_begin() {
  ScheduleRecorder recorder = scheduler_.record("begin camera paths", owner_);
  begin_frame_ = recorder.variable("frame", frame_);
  begin_index_ = recorder.variable("sample", 0u);
  const uint32_t values = plan_.settings.pixels * plan_.layers();
  recorder.pass("clear sample", program_, "clear_sample")
      .global(values)
      .slice(kSlice)
      .arg("sample", sample_)
      .arg("count", values);
  recorder.fill_zero("no events of camera paths", counts_);
  PassBuilder begin = recorder.pass("begin camera paths", program_, "begin_eye_paths");
  if (caches_) begin.arg("reused", caches_->reused());
  begin.global(plan_.settings.pixels)
      .slice(kSlice)
      .arg("frame", begin_frame_)
      .arg("settings", plan_.settings)
      .arg("sample_index", begin_index_)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("eye_mis", mis_);
  begin_ = recorder.compile();
}

void EyePaths::add_shadowed(ScheduleRecorder& recorder, const std::string& name, const std::string& kernel,
                            const BufferRef& rays, const BufferRef& values, const BufferRef& blocked) const {
  recorder.pass(name, program_, kernel)
      .global_by(active_)
      .arg("settings", plan_.settings)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("rays", rays)
      .arg("light", values)
      .arg("occluded", blocked)
      .arg("sample", sample_);
}

void EyePaths::count_rays(ScheduleRecorder& recorder, const BufferRef& rays, const BufferRef& light,
                          uint32_t index) const {
  const uint32_t choices = index == BIDIRECTIONAL_COUNT_CONNECTION_RAYS && plan_.has_table() ? 1 : 0;
  recorder.pass("count shadow rays", program_, "count_shadow_rays")
      .global((plan_.settings.pixels + kCountChunk - 1) / kCountChunk)
      .arg("active", active_)
      .arg("rays", rays)
      .arg("light", light)
      .arg("index", index)
      .arg("choices", choices)
      .arg("chunk", kCountChunk)
      .arg("counts", counts_);
}

void EyePaths::record_closest() {
  ScheduleRecorder recorder = scheduler_.record("surfaces of camera paths", owner_);
  intersector_.record_closest(recorder, "closest hit", {rays_, active_, 0, plan_.settings.pixels, ends_}, hits_);
  closest_ = recorder.compile();
}

void EyePaths::record_connect_to_all() {
  ScheduleRecorder recorder = scheduler_.record("connections to a virtual light", owner_);
  connect_seed_ = recorder.variable("seed", 0u);
  connect_index_ = recorder.variable("sample", 0u);
  connect_number_ = recorder.variable("virtual light", 0u);
  const uint32_t capacity = plan_.settings.pixels;
  const BufferRef rays = recorder.transient<Ray>("shadow rays of connections", capacity, kRemedy);
  const BufferRef ends =
      transient_ray_ends(recorder, intersector_, "ends of shadow rays of connections", capacity, kRemedy);
  const BufferRef connections = recorder.transient<float4>("connections", capacity, kRemedy);
  const BufferRef connection_paths = recorder.transient<uint32_t>("light paths of connections", capacity, kRemedy);
  const BufferRef hidden = recorder.transient<uint32_t>("hidden connections", capacity, kRemedy);
  PassBuilder connect = recorder.pass("connect camera paths", program_, "connect_to_all");
  scene_.bind(connect);
  connect.global_by(active_)
      .slice(kSlice)
      .arg("seed", connect_seed_)
      .arg("settings", plan_.settings)
      .arg("sample_index", connect_index_)
      .arg("number", connect_number_)
      .arg("vertices", vertices_->vertices())
      .arg_if_present("vertex_densities", vertices_->densities())
      .arg("vertex_list", vertices_->list())
      .arg("rays", rays_)
      .arg("hits", hits_)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("eye_mis", mis_)
      .arg_if_present("connection_ends", ends)
      .arg("connection_rays", rays)
      .arg("connections", connections)
      .arg("connection_paths", connection_paths);
  intersector_.record_any(recorder, "shadow rays of connections", {rays, active_, 0, capacity, ends}, hidden);
  add_shadowed(recorder, "add connections", "add_connections", rays, connections, hidden);
  vertices_->record_learning(recorder, active_, rays, hidden, connection_paths, connections, capacity);
  count_rays(recorder, rays, connections, BIDIRECTIONAL_COUNT_CONNECTION_RAYS);
  connect_ = recorder.compile();
}

void EyePaths::record_bounce() {
  ScheduleRecorder recorder = scheduler_.record("bounce of camera paths", owner_);
  bounce_seed_ = recorder.variable("seed", 0u);
  bounce_index_ = recorder.variable("sample", 0u);
  const uint32_t capacity = plan_.settings.pixels;
  const auto ends_of = [&](const std::string& name) {
    return transient_ray_ends(recorder, intersector_, "ends of " + name, capacity, kRemedy);
  };
  BufferRef hits = hits_;
  if (!keeps_hits()) hits = recorder.transient<Hit>("hits", capacity, kRemedy);
  const BufferRef next_rays = recorder.transient<Ray>("next rays", capacity, kRemedy);
  const BufferRef next_ends = ends_of("next rays");
  const BufferRef next_queue = recorder.transient<uint32_t>("next queue", capacity, kRemedy);
  const BufferRef alive = recorder.transient<uint32_t>("alive", capacity, kRemedy);
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", capacity, kRemedy);
  const BufferRef next_active = recorder.transient<uint32_t>("next active", 1);
  const BufferRef light_rays = recorder.transient<Ray>("shadow rays of light samples", capacity, kRemedy);
  const BufferRef light_ends = ends_of("shadow rays of light samples");
  const BufferRef light = recorder.transient<float4>("light samples", capacity, kRemedy);
  const BufferRef connection_rays = recorder.transient<Ray>("shadow rays of connections", capacity, kRemedy);
  const BufferRef connection_ends = ends_of("shadow rays of connections");
  const BufferRef connections = recorder.transient<float4>("connections", capacity, kRemedy);
  const BufferRef connection_paths = recorder.transient<uint32_t>("light paths of connections", capacity, kRemedy);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded", capacity, kRemedy);
  const BufferRef hidden = recorder.transient<uint32_t>("hidden connections", capacity, kRemedy);

  if (!keeps_hits()) intersector_.record_closest(recorder, "closest hit", {rays_, active_, 0, capacity, ends_}, hits);
  PassBuilder shade = recorder.pass("shade camera paths", program_, "shade_eye_vertices");
  scene_.bind(shade);
  shade.global_by(active_)
      .slice(kSlice)
      .arg("seed", bounce_seed_)
      .arg("settings", plan_.settings)
      .arg("sample_index", bounce_index_)
      .arg("vertices", vertices_ ? vertices_->vertices() : no_vertices_)
      .arg_if_present("vertex_densities", vertices_ ? vertices_->densities() : no_densities_)
      .arg_if_present("first_vertices", first_vertices_)
      .arg("vertex_list", vertices_ ? vertices_->list() : no_list_)
      .arg("vertex_count", vertices_ ? vertices_->count() : no_list_)
      .arg("candidate_table", vertices_ ? vertices_->table() : no_table_)
      .arg("table_capacity", vertices_ ? vertices_->table_capacity() : 1u)
      .arg("shares", vertices_ ? vertices_->light_shares() : no_table_)
      .arg("rays", rays_)
      .arg("hits", hits)
      .arg("queue", queue_)
      .arg("active", active_)
      .arg("states", states_)
      .arg("eye_mis", mis_)
      .arg("sample", sample_)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("light_ends", light_ends)
      .arg_if_present("connection_ends", connection_ends)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg("alive", alive)
      .arg("light_rays", light_rays)
      .arg("light_samples", light)
      .arg("connection_rays", connection_rays)
      .arg("connections", connections)
      .arg("connection_paths", connection_paths);
  if (plan_.lights) {
    intersector_.record_any(recorder, "shadow rays of light samples", {light_rays, active_, 0, capacity, light_ends},
                            occluded);
    add_shadowed(recorder, "add light samples", "add_eye_light_samples", light_rays, light, occluded);
    count_rays(recorder, light_rays, light, BIDIRECTIONAL_COUNT_LIGHT_RAYS);
  }
  if (plan_.vpl && !plan_.connects_to_all()) {
    intersector_.record_any(recorder, "shadow rays of connections",
                            {connection_rays, active_, 0, capacity, connection_ends}, hidden);
    add_shadowed(recorder, "add connections", "add_connections", connection_rays, connections, hidden);
    vertices_->record_learning(recorder, active_, connection_rays, hidden, connection_paths, connections, capacity);
    count_rays(recorder, connection_rays, connections, BIDIRECTIONAL_COUNT_CONNECTION_RAYS);
  }
  primitives_.record_compact(recorder, "compact camera paths", alive, survivors, next_active, 0, active_, 0, capacity);
  recorder.pass("advance camera paths", program_, "advance_paths")
      .global_by(active_)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("ends", ends_)
      .arg("rays", rays_)
      .arg("queue", queue_)
      .arg("active", active_);
  recorder.read_back("active camera paths", active_, [this](std::span<const std::byte> bytes) {
    std::memcpy(&remaining_, bytes.data(), sizeof remaining_);
  });
  bounce_ = recorder.compile();
}

void EyePaths::record_add() {
  ScheduleRecorder recorder = scheduler_.record("add iteration", owner_);
  if (caches_) caches_->record_keep(recorder, sample_, BIDIRECTIONAL_INDIRECT);
  const uint32_t pixels = plan_.settings.pixels;
  const auto add = [&](uint32_t layer, const TypedBuffer<float4>& sums) {
    recorder.pass("add layer", program_, "add_layer")
        .global(pixels)
        .arg("sample", sample_)
        .arg("layer", layer)
        .arg("pixels", pixels)
        .arg("sums", sums);
  };
  add(BIDIRECTIONAL_EMISSION, sums_["emission"]);
  add(BIDIRECTIONAL_DIRECT, sums_["direct"]);
  add(BIDIRECTIONAL_INDIRECT, indirect_sums_["indirect"]);
  uint32_t layer = BIDIRECTIONAL_LAYERS;
  for (const std::string& name : strategy_names(plan_)) add(layer++, strategy_sums_[name]);
  recorder.pass("count ends of paths", program_, "count_path_ends")
      .global((pixels + kCountChunk - 1) / kCountChunk)
      .arg("states", states_)
      .arg("pixels", pixels)
      .arg("chunk", kCountChunk)
      .arg("counts", counts_);
  recorder.read_back("events of camera paths", counts_, [this](std::span<const std::byte> bytes) {
    std::memcpy(counted_.data(), bytes.data(), sizeof counted_);
  });
  add_ = recorder.compile();
}

void EyePaths::set_frame(const Frame& frame) {
  frame_ = frame;
  if (filter_) filter_->set_frame(frame);
}

bool EyePaths::begin(uint32_t index) {
  if (filter_ && !filter_->find_surfaces()) return false;
  if (caches_ && !caches_->look_up(index)) return false;
  begin_.set(begin_frame_, frame_);
  begin_.set(begin_index_, index);
  return scheduler_.run(begin_) != RunResult::cancelled;
}

bool EyePaths::trace(uint32_t index) {
  bounce_.set(bounce_seed_, frame_.seed);
  bounce_.set(bounce_index_, index);
  if (plan_.connects_to_all()) {
    connect_.set(connect_seed_, frame_.seed);
    connect_.set(connect_index_, index);
  }
  remaining_ = plan_.settings.pixels;
  double segments = 0;
  for (uint32_t depth = 0; remaining_ > 0; ++depth) {
    segments += remaining_;
    if (keeps_hits() && !find_surfaces(index, depth)) return false;
    if (plan_.connects_to_all() && !connect_to_all()) return false;
    if (scheduler_.run(bounce_) == RunResult::cancelled) return false;
  }
  segments_ += segments;
  paths_ += plan_.settings.pixels;
  return true;
}

bool EyePaths::find_surfaces(uint32_t index, uint32_t depth) {
  if (scheduler_.run(closest_) == RunResult::cancelled) return false;
  return !bundles_ || depth == 0 || bundles_->trace(frame_.seed, index, depth - 1);
}

bool EyePaths::connect_to_all() {
  for (uint32_t number = 0; number < vertices_->vertex_count(); ++number) {
    connect_.set(connect_number_, number);
    if (scheduler_.run(connect_) == RunResult::cancelled) return false;
  }
  return true;
}

void EyePaths::add(uint64_t iterations) {
  if (caches_) caches_->prepare_keep(add_);
  scheduler_.run_to_end(add_);
  scheduler_.finish();
  if (filter_) filter_->apply(iterations);
  for (size_t i = 0; i < counted_.size(); ++i) totals_[i] += counted_[i];
  if (bundles_) bundles_->complete();
  const uint32_t bad = counted_[BIDIRECTIONAL_COUNT_BAD];
  if (bad > 0)
    throw_error(ErrorClass::technique, "{} camera paths brought light that is NaN, infinite or negative", bad);
}

void EyePaths::clear(bool moves_on) {
  scheduler_.finish();
  if (caches_) moves_on ? caches_->next_frame(frame_) : caches_->clear(frame_);
  sums_.clear();
  indirect_sums_.clear();
  strategy_sums_.clear();
  totals_ = {};
  paths_ = segments_ = 0;
  if (bundles_) bundles_->clear_counters();
}

void EyePaths::warm_up() {
  for (Schedule* schedule : {&begin_, &bounce_, &add_}) scheduler_.warm_up(*schedule);
  if (keeps_hits()) scheduler_.warm_up(closest_);
  if (plan_.connects_to_all()) scheduler_.warm_up(connect_);
  if (bundles_) bundles_->warm_up();
  if (caches_) caches_->warm_up();
  if (filter_) filter_->warm_up();
}

void EyePaths::write(Film& film) const {
  sums_.write(film);
  if (filter_ && filter_->shows())
    add_mean(film, "indirect", filter_->filtered());
  else
    indirect_sums_.write(film);
  strategy_sums_.write(film, false);
}

std::map<std::string, double> EyePaths::counters() const {
  std::map<std::string, double> all = {{"paths", paths_},
                                       {"camera_rays", segments_},
                                       {"light_sample_rays", totals_[BIDIRECTIONAL_COUNT_LIGHT_RAYS]},
                                       {"connection_rays", totals_[BIDIRECTIONAL_COUNT_CONNECTION_RAYS]},
                                       {"nonfinite", totals_[BIDIRECTIONAL_COUNT_BAD]},
                                       {"terminated_by_cap", totals_[BIDIRECTIONAL_COUNT_CAPPED]},
                                       {"terminated_in_mirrors", totals_[BIDIRECTIONAL_COUNT_MIRRORS]}};
  if (bundles_)
    for (const auto& [name, count] : bundles_->counters()) all[name] = count;
  // As many as there are virtual lights in an iteration at most.
  if (plan_.has_table()) all["candidates"] = totals_[BIDIRECTIONAL_COUNT_CHOICES] * plan_.settings.candidates;
  return all;
}

size_t EyePaths::estimate_bytes(const Plan& plan, const Scene& scene, bool ray_ends) {
  const size_t ends = ray_ends ? sizeof(RayEnds) : 0, ray = sizeof(Ray) + ends;
  const size_t kept = ray + sizeof(uint32_t) + sizeof(EyePathState) +
                      sizeof(float) * std::max(plan.light_vertices, 1u) + sizeof(float4) * plan.layers() * 2;
  const size_t transient = sizeof(Hit) + 3 * ray + 2 * sizeof(float4) + (plan.learned ? 11 : 7) * sizeof(uint32_t);
  const size_t first = plan.gloss == Gloss::none ? 0 : sizeof(PathVertex);
  size_t vertices = 0;
  if (plan.caches) vertices = SceneLayout(scene).world_vertices;
  const auto triangles = static_cast<size_t>(scene.triangle_count());
  return plan.settings.pixels * (kept + first + transient) + 4096 +
         (plan.stores_bundles() ? BundleEdges::estimate_bytes(plan, triangles) : 0) +
         (plan.filter ? PixelFilter::estimate_bytes(plan, ray_ends) : 0) +
         (plan.caches ? Caches::estimate_bytes(plan, vertices, ray_ends) : 0);
}

}  // namespace lucarium::bidirectional
