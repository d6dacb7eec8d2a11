// SPDX-License-Identifier: Apache-2.0
// Rays per second of the hierarchy, beside Embree's single-ray calls on the same rays where Embree is installed, in turns
// within one run; and elements per second of the primitives. LUCARIUM_BENCH_SCENES is a list of scenes, separated by
// semicolons (default: builtin:atrium).
//
// Counters: mrays_wall [Mrays/s] with all threads; mrays_cpu [Mrays per second of processor time], which other load
// disturbs less; embree_cpu the same for Embree; ratio = mrays_cpu / embree_cpu, thread against thread.
#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>
#include <glm/glm.hpp>
#include <map>
#include <random>
#include <sstream>

#include "embree_rays.h"
#include "lucarium/compute/scheduler.h"
#include "lucarium/scene/load_scene.h"
#include "lucarium/services/bvh.h"
#include "lucarium/services/primitives.h"

namespace {

using namespace lucarium;

constexpr uint32_t image_width = 1024, image_height = 576, ray_count = image_width * image_height;

struct Bench {
  std::shared_ptr<Device> device = Device::open();
  KernelScheduler scheduler{device};
};

Bench& bench() {
  static Bench instance;
  return instance;
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A loaded scene, its triangles and the three kinds of rays.
struct Subject {
  explicit Subject(const std::string& name)
      : scene(load_scene(name)), buffers(*bench().device, scene), vertices(buffers.scene_vertices.download()),
        triangles(buffers.scene_triangles.download(0, buffers.info().triangle_count)) {
    make_primary();
    const Bvh bvh(*bench().device, vertices, triangles);
    make_secondary(trace(bvh, rays["primary"]));
  }

  static std::vector<Hit> trace(const Bvh& bvh, const std::vector<Ray>& rays) {
    Device& device = *bench().device;
    const TypedBuffer<Ray> ray_buffer(device, "bench", "rays", rays);
    const TypedBuffer<Hit> hits(device, "bench", "hits", rays.size());
    const auto count = static_cast<uint32_t>(rays.size());
    const TypedBuffer<uint32_t> counter(device, "bench", "counter", std::vector<uint32_t>{count});
    ScheduleRecorder recorder = bench().scheduler.record("prepare", "bench");
    bvh.record_closest(recorder, "closest", ray_buffer, hits, counter, 0, count);
    Schedule schedule = recorder.compile();
    bench().scheduler.run(schedule);
    bench().scheduler.finish();
    return hits.download();
  }

  void make_primary() {
    const SceneCamera& camera = scene.cameras.at(0);
    const float height = std::tan(0.5f * camera.yfov), width = height * image_width / image_height;
    for (uint32_t i = 0; i < ray_count; ++i) {
      const float x = 2 * (static_cast<float>(i % image_width) + 0.5f) / image_width - 1;
      const float y = 1 - 2 * (static_cast<float>(i / image_width) + 0.5f) / image_height;
      const glm::mat3 turn(camera.world_from_camera);
      Ray ray;
      ray.origin = float4(glm::vec3(camera.world_from_camera[3]), 0.f);
      ray.direction = float4(glm::normalize(turn * glm::vec3(x * width, y * height, -1)), INFINITY);
      rays["primary"].push_back(ray);
    }
  }

  /// Cosine-distributed bounces off the first hits, and connections from there to random points within the bounds.
  void make_secondary(const std::vector<Hit>& hits) {
    std::mt19937 engine(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    const Bounds bounds = scene.bounds();
    for (uint32_t i = 0; i < ray_count; ++i) {
      if (hits[i].triangle == LUCARIUM_NO_HIT) continue;
      const Ray& primary = rays["primary"][i];
      const Triangle& t = triangles[hits[i].triangle];
      const glm::vec3 a = vertices[t.v0].position.xyz(), b = vertices[t.v1].position.xyz(), c = vertices[t.v2].position.xyz();
      glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
      if (glm::dot(normal, primary.direction.xyz()) > 0) normal = -normal;
      const glm::vec3 origin = primary.origin.xyz() + hits[i].distance * primary.direction.xyz() + 1e-3f * normal;
      const float z = 1 - 2 * uniform(engine), angle = 6.2831853f * uniform(engine), r = std::sqrt(1 - z * z);
      const glm::vec3 on_sphere(r * std::cos(angle), r * std::sin(angle), z);
      Ray ray;
      ray.origin = float4(origin, 0.f);
      ray.direction = float4(glm::normalize(1.0001f * normal + on_sphere), INFINITY);
      rays["diffuse"].push_back(ray);
      const glm::vec3 place(uniform(engine), uniform(engine), uniform(engine));
      const glm::vec3 way = bounds.min + (bounds.max - bounds.min) * place - origin;
      ray.direction = float4(glm::normalize(way), glm::length(way));
      rays["shadow"].push_back(ray);
    }
  }

  Scene scene;
  SceneBuffers buffers;
  std::vector<Vertex> vertices;
  std::vector<Triangle> triangles;
  std::map<std::string, std::vector<Ray>> rays;
};

const Subject& subject(const std::string& name) {
  static std::map<std::string, std::unique_ptr<Subject>> loaded;
  std::unique_ptr<Subject>& entry = loaded[name];
  if (!entry) entry = std::make_unique<Subject>(name);
  return *entry;
}

void trace(benchmark::State& state, const std::string& scene, const std::string& kind, BvhTraversal traversal) {
  try {
    const Subject& on = subject(scene);
    const std::vector<Ray>& rays = on.rays.at(kind);
    const bool any = kind == "shadow";
    Device& device = *bench().device;
    const Bvh bvh(device, on.vertices, on.triangles, traversal);
    const bench::EmbreeScene embree(on.vertices, on.triangles);
    const auto count = static_cast<uint32_t>(rays.size());
    const TypedBuffer<Ray> ray_buffer(device, "bench", "rays", rays);
    const TypedBuffer<Hit> results(device, "bench", "results", rays.size());
    const TypedBuffer<uint32_t> counter(device, "bench", "counter", std::vector<uint32_t>{count});
    ScheduleRecorder recorder = bench().scheduler.record("rays", "bench");
    if (any)
      bvh.record_any(recorder, "any", ray_buffer, results, counter, 0, count);
    else
      bvh.record_closest(recorder, "closest", ray_buffer, results, counter, 0, count);
    Schedule schedule = recorder.compile();
    bench().scheduler.run(schedule);  // compiles what drivers compile at the first launch
    bench().scheduler.finish();
    double cpu = 0, embree_cpu = 0;
    for (auto _ : state) {
      const double start = cpu_seconds();
      bench().scheduler.run(schedule);
      bench().scheduler.finish();
      const double middle = cpu_seconds();
      cpu += middle - start;
      state.PauseTiming();
      embree.trace(rays, any);
      embree_cpu += cpu_seconds() - middle;
      state.ResumeTiming();
    }
    const double total = 1e-6 * static_cast<double>(count) * static_cast<double>(state.iterations());
    state.counters["mrays_wall"] = benchmark::Counter(total, benchmark::Counter::kIsRate);
    state.counters["mrays_cpu"] = total / cpu;
    if (bench::EmbreeScene::available()) {
      state.counters["embree_cpu"] = total / embree_cpu;
      state.counters["ratio"] = embree_cpu / cpu;
    }
    state.counters["build_s"] = bvh.statistics().build_seconds;
    state.counters["triangles"] = bvh.statistics().triangles;
  } catch (const std::exception& error) {
    state.SkipWithError(error.what());
  }
}

void sort_pairs(benchmark::State& state) {
  Device& device = *bench().device;
  const auto count = static_cast<uint32_t>(state.range(0));
  std::vector<uint32_t> keys(count);
  std::mt19937 engine(1);
  for (uint32_t& key : keys) key = static_cast<uint32_t>(engine());
  const TypedBuffer<uint32_t> key_buffer(device, "bench", "keys", keys), values(device, "bench", "values", keys);
  ScheduleRecorder recorder = bench().scheduler.record("sort", "bench");
  Primitives(device).record_sort_pairs(recorder, "sort", key_buffer, values, count);
  Schedule schedule = recorder.compile();
  for (auto _ : state) {
    bench().scheduler.run(schedule);
    bench().scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * count);
}
BENCHMARK(sort_pairs)->Arg(1 << 22)->Unit(benchmark::kMillisecond)->UseRealTime();

void exclusive_scan(benchmark::State& state) {
  Device& device = *bench().device;
  const auto count = static_cast<uint32_t>(state.range(0));
  const TypedBuffer<uint32_t> in(device, "bench", "in", std::vector<uint32_t>(count, 1)),
      out(device, "bench", "out", count), total(device, "bench", "total", 1);
  ScheduleRecorder recorder = bench().scheduler.record("scan", "bench");
  Primitives(device).record_exclusive_scan(recorder, "scan", in, out, total, count);
  Schedule schedule = recorder.compile();
  for (auto _ : state) {
    bench().scheduler.run(schedule);
    bench().scheduler.finish();
  }
  state.SetItemsProcessed(state.iterations() * count);
}
BENCHMARK(exclusive_scan)->Arg(1 << 22)->Unit(benchmark::kMillisecond)->UseRealTime();

const bool registered = [] {
  const char* list = std::getenv("LUCARIUM_BENCH_SCENES");
  std::istringstream scenes(list && *list ? list : "builtin:atrium");
  for (std::string scene; std::getline(scenes, scene, ';');) {
    for (const char* kind : {"primary", "diffuse", "shadow"})
      for (const auto& [name, traversal] : {std::pair{"wide", BvhTraversal::wide},
                                            {"wide-portable", BvhTraversal::wide_portable},
                                            {"scalar", BvhTraversal::scalar}})
        benchmark::RegisterBenchmark(("rays/" + scene + "/" + kind + "/" + name).c_str(), trace, scene, std::string(kind),
                                     traversal)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
  }
  return true;
}();

}  // namespace
