// SPDX-License-Identifier: Apache-2.0
#include "bidirectional_vpl/light/light_vertices.h"

#include <algorithm>
#include <cstring>

#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/ray.h"

const lucarium::EmbeddedSources& bidirectional_vpl_kernels();

namespace lucarium::bidirectional {

namespace {

const char* const kRemedy = "lower --size or light_vertices, or set fewer light_paths";
constexpr size_t kSlice = 1 << 16;
constexpr uint32_t kCountChunk = 1 << 14;
// Light vertices that do not stay in a processor's caches until they are read.
constexpr size_t kManyVertices = (16u << 20) / sizeof(PathVertex);
// Of the table of candidates (candidates.clh): rows; entries that fill the last block, and those that are repeated
// behind it, a block and as many as a connection has at most.
constexpr uint32_t kTableRows = 8, kRepeated = 256 + 2 * 8;

std::map<std::string, std::string> with_mis(std::map<std::string, std::string> defines, const Plan& plan) {
  defines.merge(plan_defines(plan));
  defines["LUCARIUM_LIGHT_PATH_MIS"] = "1";
  return defines;
}

LightPathOptions path_options(const Plan& plan, bool has_first_hits) {
  LightPathOptions options;
  options.paths = plan.settings.light_paths;
  options.vertices = plan.light_vertices;
  options.hit_samples = plan.settings.hit_samples;
  options.light_samples = plan.settings.light_samples;
  options.connection_samples = plan.settings.connection_samples;
  options.roulette_start = 4;  // paths of more vertices end by what they carry
  options.count_rays = true;
  options.order = !has_first_hits;
  if (plan.punctual_paths)
    options.kinds = 1u << LUCARIUM_LIGHT_POINT | 1u << LUCARIUM_LIGHT_SPOT | 1u << LUCARIUM_LIGHT_DIRECTIONAL;
  options.remedy = kRemedy;
  return options;
}

int bits_of(uint32_t pixels) {
  int bits = 1;
  while (bits < 32 && (1ull << bits) <= pixels) ++bits;  // one value above the last pixel
  return bits;
}

}  // namespace

LightVertices::LightVertices(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                             const Intersector& intersector, const Frame& frame, const Plan& plan,
                             const LightPaths::FirstHits& first_hits, const std::string& owner)
    : scheduler_(scheduler),
      scene_(scene),
      intersector_(intersector),
      frame_(frame),
      plan_(plan),
      first_hits_(first_hits),
      owner_(owner),
      table_capacity_((static_cast<uint32_t>(plan.vertex_slots()) + kRepeated + 7) / 8 * 8),
      primitives_(device),
      paths_(device, scene, intersector, path_options(plan, bool(first_hits)), owner),
      store_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/light/store_light_vertices"},
                          with_mis(ray_end_defines(intersector), plan))),
      list_program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/light/list_candidates"},
                                 with_mis({}, plan))),
      splat_program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/light/splats"},
                                  with_mis(ray_end_defines(intersector), plan))),
      learn_program_(make_program(device, bidirectional_vpl_kernels(), {"bidirectional_vpl/light/learn_lights"}, {})),
      vertices_(device, owner, "light vertices", plan.vertex_slots(), kRemedy),
      densities_(device, owner, "densities of light vertices", plan.gloss == Gloss::none ? 1 : plan.vertex_slots(),
                 kRemedy),
      table_(device, owner, "table of virtual lights", plan.has_table() ? size_t{table_capacity_} * kTableRows : 1,
             kRemedy),
      light_sums_(device, owner, "light of each light's paths", plan.learned ? scene.scene_lights.count() : 1),
      light_news_(device, owner, "light of each light's paths in an iteration",
                  plan.learned ? scene.scene_lights.count() : 1),
      light_shares_(device, owner, "shares of lights", plan.learned ? scene.scene_lights.count() : 1),
      path_lights_(device, owner, "lights of light paths", plan.settings.light_paths, kRemedy),
      list_(device, owner, "list of virtual lights", plan.vertex_slots(), kRemedy),
      count_(device, owner, "number of virtual lights", 1),
      slot_count_(device, owner, "number of vertex slots",
                  std::vector<uint32_t>{static_cast<uint32_t>(plan.vertex_slots())}),
      splat_count_(device, owner, "number of splats",
                   std::vector<uint32_t>{plan.settings.light_paths * (plan.light_vertices - 1)}),
      splat_events_(device, owner, "splats, counted", 2) {
  light_sums_.fill_zero();
}

void LightVertices::record(const TypedBuffer<float4>& sample, const TypedBuffer<EyePathState>& states) {
  ScheduleRecorder recorder = scheduler_.record("light paths", owner_);
  run_ = recorder.variable("run", 0u);
  seed_ = recorder.variable("seed", 0u);
  frame_variable_ = recorder.variable("frame", frame_);
  const auto slots = static_cast<uint32_t>(plan_.vertex_slots());
  recorder.pass("clear light vertices", store_, "clear_light_vertices")
      .global(slots)
      .slice(kSlice)
      .arg("vertices", vertices_)
      .arg("count", slots);
  if (plan_.learned) {
    PassBuilder share = recorder.pass("shares of lights", learn_program_, "share_lights");
    scene_.bind(share);
    share.global(1).arg("sums", light_sums_).arg("shares", light_shares_);
    recorder.fill_zero("nothing learned yet", light_news_);
  }
  paths_.record(
      recorder, run_, seed_, store_,
      [this, slots](PassBuilder& pass) {
        pass.arg("vertices", vertices_)
            .arg("vertices_per_path", plan_.light_vertices)
            .arg("streamed", slots > kManyVertices ? 1u : 0u)
            .arg("path_lights", path_lights_);
        pass.arg_if_present("vertex_densities", densities_);
      },
      [this](PassBuilder& pass) { pass.arg("shares", light_shares_); }, first_hits_);
  const BufferRef present = recorder.transient<uint32_t>("vertices that are there", slots, kRemedy);
  recorder.pass("mark light vertices", store_, "mark_light_vertices")
      .global(slots)
      .slice(kSlice)
      .arg("vertices", vertices_)
      .arg("count", slots)
      .arg("present", present);
  primitives_.record_compact(recorder, "list light vertices", present, list_, count_, 0, slot_count_, 0, slots);
  if (plan_.has_table())
    recorder.pass("list candidates", list_program_, "list_candidates")
        .global(table_capacity_)
        .slice(kSlice)
        .arg("vertices", vertices_)
        .arg("list", list_)
        .arg("count", count_)
        .arg("capacity", table_capacity_)
        .arg("table", table_);
  if (plan_.splat) record_splats(recorder, sample, states);
  recorder.read_back("number of light vertices", count_, [this](std::span<const std::byte> bytes) {
    std::memcpy(&present_, bytes.data(), sizeof present_);
  });
  recorder.read_back("rays of light paths, counted", paths_.ray_counts(), [this](std::span<const std::byte> bytes) {
    std::memcpy(traced_.data(), bytes.data(), sizeof traced_);
  });
  schedule_ = recorder.compile();
  if (plan_.learned) record_learn();
}

void LightVertices::record_learn() {
  ScheduleRecorder recorder = scheduler_.record("learned lights", owner_);
  const auto lights = static_cast<uint32_t>(light_sums_.count());
  recorder.pass("add what lights brought", learn_program_, "add_brought_light")
      .global(lights)
      .slice(kSlice)
      .arg("brought", light_news_)
      .arg("lights", lights)
      .arg("sums", light_sums_);
  learn_ = recorder.compile();
}

void LightVertices::record_splats(ScheduleRecorder& recorder, const TypedBuffer<float4>& sample,
                                  const TypedBuffer<EyePathState>& states) {
  const uint32_t count = plan_.settings.light_paths * (plan_.light_vertices - 1);
  const BufferRef rays = recorder.transient<Ray>("rays of splats", count, kRemedy);
  const BufferRef ends = transient_ray_ends(recorder, intersector_, "ends of rays of splats", count, kRemedy);
  const BufferRef splats = recorder.transient<float4>("splats", count, kRemedy);
  const BufferRef occluded = recorder.transient<uint32_t>("occluded splats", count, kRemedy);
  const BufferRef keys = recorder.transient<uint32_t>("pixels of splats", count, kRemedy);
  const BufferRef values = recorder.transient<uint32_t>("order of splats", count, kRemedy);
  PassBuilder aim = recorder.pass("aim splats", splat_program_, "aim_splats");
  scene_.bind(aim);
  aim.global(count)
      .slice(kSlice)
      .arg("frame", frame_variable_)
      .arg("settings", plan_.settings)
      .arg("sample_index", run_)
      .arg("vertices", vertices_)
      .arg("vertices_per_path", plan_.light_vertices)
      .arg_if_present("ends", ends)
      .arg("rays", rays)
      .arg("splats", splats);
  intersector_.record_any(recorder, "rays of splats", {rays, splat_count_, 0, count, ends}, occluded);
  if (plan_.learned) {
    const BufferRef light_keys = recorder.transient<uint32_t>("lights of splats", count, kRemedy);
    const BufferRef order = recorder.transient<uint32_t>("splats by light", count, kRemedy);
    recorder.pass("key splats by light", learn_program_, "key_splat_lights")
        .global(count)
        .slice(kSlice)
        .arg("splats", splats)
        .arg("occluded", occluded)
        .arg("path_lights", path_lights_)
        .arg("per_path", plan_.light_vertices - 1)
        .arg("count", count)
        .arg("keys", light_keys)
        .arg("values", order);
    record_sums_by_light(recorder, "splats", light_keys, order, splats, count);
  }
  recorder.fill_zero("no splats", splat_events_);
  recorder.pass("key splats", splat_program_, "key_splats")
      .global(count)
      .slice(kSlice)
      .arg("splats", splats)
      .arg("occluded", occluded)
      .arg("count", count)
      .arg("keys", keys)
      .arg("values", values);
  recorder.pass("count splats", splat_program_, "count_splats")
      .global((count + kCountChunk - 1) / kCountChunk)
      .arg("rays", rays)
      .arg("keys", keys)
      .arg("count", count)
      .arg("chunk", kCountChunk)
      .arg("counts", splat_events_);
  recorder.read_back("splats, counted", splat_events_, [this](std::span<const std::byte> bytes) {
    std::memcpy(splats_.data(), bytes.data(), sizeof splats_);
  });
  primitives_.record_sort_pairs(recorder, "sort splats", keys, values, count, bits_of(plan_.settings.pixels));
  recorder.pass("sum splats", splat_program_, "sum_splats")
      .global(plan_.settings.pixels)
      .slice(kSlice)
      .arg("settings", plan_.settings)
      .arg("states", states)
      .arg("splats", splats)
      .arg("keys", keys)
      .arg("values", values)
      .arg("count", count)
      .arg("splat_layer", plan_.layers() - 1)
      .arg("sample", sample);
}

void LightVertices::record_sums_by_light(ScheduleRecorder& recorder, const std::string& of, const BufferRef& keys,
                                         const BufferRef& values, const BufferRef& light, uint32_t count) const {
  const auto lights = static_cast<uint32_t>(light_sums_.count());
  primitives_.record_sort_pairs(recorder, "sort " + of + " by light", keys, values, count, bits_of(lights));
  recorder.pass("sum " + of + " by light", learn_program_, "sum_by_light")
      .global(lights)
      .slice(kSlice)
      .arg("keys", keys)
      .arg("values", values)
      .arg("light", light)
      .arg("count", count)
      .arg("lights", lights)
      .arg("sums", light_news_);
}

void LightVertices::record_learning(ScheduleRecorder& recorder, const BufferRef& active, const BufferRef& rays,
                                    const BufferRef& occluded, const BufferRef& paths, const BufferRef& light,
                                    uint32_t count) const {
  if (!plan_.learned) return;
  const BufferRef keys = recorder.transient<uint32_t>("lights of connections", count, kRemedy);
  const BufferRef order = recorder.transient<uint32_t>("connections by light", count, kRemedy);
  recorder.pass("key connections by light", learn_program_, "key_connection_lights")
      .global(count)
      .slice(kSlice)
      .arg("active", active)
      .arg("rays", rays)
      .arg("occluded", occluded)
      .arg("connection_paths", paths)
      .arg("path_lights", path_lights_)
      .arg("count", count)
      .arg("keys", keys)
      .arg("values", order);
  record_sums_by_light(recorder, "connections", keys, order, light, count);
}

void LightVertices::restart() {
  counters_.clear();
  light_sums_.fill_zero();
}

bool LightVertices::trace(uint32_t index) {
  schedule_.set(run_, index);
  schedule_.set(seed_, frame_.seed);
  schedule_.set(frame_variable_, frame_);
  if (scheduler_.run(schedule_) == RunResult::cancelled) return false;
  scheduler_.finish();
  return true;
}

void LightVertices::complete() {
  if (plan_.learned) scheduler_.run_to_end(learn_);
  count_paths();
  counters_["splats"] += splats_[1];
}

void LightVertices::complete_guiding() {
  count_paths();
  counters_["guide_light_paths"] += plan_.settings.light_paths;
}

void LightVertices::count_paths() {
  counters_["light_paths"] += plan_.settings.light_paths;
  counters_["light_vertices"] += present_;
  counters_["light_path_rays"] += traced_[0];
  counters_["light_path_misses"] += traced_[1];
  counters_["splat_rays"] += splats_[0];
}

size_t LightVertices::estimate_bytes(const Plan& plan, const Scene& scene, bool ray_ends) {
  const size_t slots = plan.vertex_slots(), splats = plan.splat ? slots - plan.settings.light_paths : 0;
  const size_t ray = sizeof(Ray) + (ray_ends ? sizeof(RayEnds) : 0);
  const size_t table = plan.has_table() ? (slots + kRepeated + 7) / 8 * 8 * kTableRows * sizeof(float) : 0;
  const size_t transients = std::max({LightPaths::estimate_bytes(plan.settings.light_paths, scene),
                                      splats * (ray + sizeof(float4) + (plan.learned ? 9 : 5) * sizeof(uint32_t)),
                                      slots * 3 * sizeof(uint32_t)});
  const size_t densities = plan.gloss == Gloss::none ? 0 : slots * sizeof(float2);
  return densities + slots * (sizeof(PathVertex) + sizeof(uint32_t)) + plan.settings.light_paths * sizeof(uint32_t) +
         table + transients;
}

}  // namespace lucarium::bidirectional
