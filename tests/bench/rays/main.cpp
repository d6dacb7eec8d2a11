// SPDX-License-Identifier: Apache-2.0
// lucarium_ray_bench: rays per second of the hierarchy beside Embree's, on the same triangles and the same rays, in
// turns within one run. Ratios are medians over the rounds of processor time against processor time, thread against
// thread; docs/measurements/ray_tracing.md explains the table.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/glm.hpp>
#include <thread>

#include "embree_rays.h"
#include "lucarium/base/error.h"
#include "ray_subject.h"
#include "rounds.h"
#include "traced_batch.h"

namespace {

using namespace lucarium;
using namespace lucarium::bench;

struct Options {
  std::vector<std::string> scenes = {"builtin:atrium"};
  int rounds = 7;
  uint32_t width = 1024, height = 576;
  bool shuffled = false;
  std::vector<std::string> kinds = {"primary", "diffuse", "shadow"};
  std::vector<std::string> only;  // contestants; empty: all
};

bool listed(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

/// One hits and the other misses, or distances differ by more than 1e-4 of themselves.
bool differ(double a, double b) { return std::isinf(a) != std::isinf(b) || std::fabs(a - b) > 1e-4 * b; }

/// Distance of the nearest hit in double precision by Möller and Trumbore's test of all triangles; INFINITY: a miss.
double exact_distance(const RaySubject& subject, const Ray& ray) {
  const auto corner = [&](uint32_t vertex) { return glm::dvec3(subject.vertices[vertex].position.xyz()); };
  const glm::dvec3 o(ray.origin.xyz()), d(ray.direction.xyz());
  double best = INFINITY;
  for (const Triangle& triangle : subject.triangles) {
    const glm::dvec3 a = corner(triangle.v0), ab = corner(triangle.v1) - a, ac = corner(triangle.v2) - a;
    const glm::dvec3 p = glm::cross(d, ac), q = glm::cross(o - a, ab);
    const double determinant = glm::dot(ab, p), u = glm::dot(o - a, p) / determinant, v = glm::dot(d, q) / determinant;
    const double distance = glm::dot(ac, q) / determinant;
    if (determinant != 0 && u >= 0 && v >= 0 && u + v <= 1 && distance > 0) best = std::min(best, distance);
  }
  return best <= static_cast<double>(ray.direction.w) ? best : INFINITY;
}

/// Rays on which two sides differ, and those of them on which the first one is wrong.
std::string describe_differences(const RaySubject& subject, const std::vector<Ray>& rays,
                                 const std::vector<Hit>& tested, const std::vector<Hit>& reference) {
  size_t different = 0, wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    const double distance = static_cast<double>(tested[i].distance);
    if (!differ(distance, static_cast<double>(reference[i].distance))) continue;
    ++different;
    wrong += differ(distance, exact_distance(subject, rays[i]));
  }
  return fmt::format("{} ({})", different, wrong);
}

/// Rays of pixels, or what was found for them, with 4 x 4 pixels at a time; as they are where that does not come out.
template <class Value>
std::vector<Value> in_tiles(const std::vector<Value>& of_pixels, uint32_t width) {
  const size_t row = width, band = 4 * row;
  if (row % 4 || of_pixels.size() % band) return of_pixels;
  std::vector<Value> tiled;
  for (size_t i = 0; i < of_pixels.size(); ++i) {
    const size_t place = i % band, tile = place / 16, pixel = place % 16;
    tiled.push_back(of_pixels[i - place + pixel / 4 * row + 4 * tile + pixel % 4]);
  }
  return tiled;
}

size_t count_differences(const std::vector<uint32_t>& a, const std::vector<uint32_t>& b) {
  size_t different = 0;
  for (size_t i = 0; i < a.size(); ++i) different += a[i] != b[i];
  return different;
}

void print_rows(const std::string& scene, RayKind kind, size_t rays, const std::vector<Contestant>& contestants,
                const std::vector<std::string>& differences) {
  const auto find = [&](const std::string& name) -> const Contestant* {
    for (const Contestant& c : contestants)
      if (c.name == name) return &c;
    return nullptr;
  };
  const Contestant* single = find("Embree");
  const Contestant* packet = find("Embree packets of 16");
  for (size_t i = 0; i < contestants.size(); ++i) {
    const Contestant& c = contestants[i];
    const double millions = 1e-6 * static_cast<double>(rays);
    const auto ratio = [&](const Contestant* to) {
      return to ? fmt::format("{:.2f}", median_ratio(to->cpu, c.cpu)) : "-";
    };
    fmt::print("| {} | {} | {} | {:.2f} | {:.2f} | {} | {} | {} |\n", scene, to_string(kind), c.name,
               millions / median(c.cpu), millions / median(c.wall), ratio(single), ratio(packet), differences[i]);
  }
  std::fflush(stdout);
}

/// The hierarchies under test over one scene.
struct Field {
  struct Entry {
    std::string name;
    std::unique_ptr<Bvh> bvh;
  };
  std::vector<Entry> entries;
  EmbreeScene embree, robust;  // robust: what hits are compared with

  Field(Device& device, const RaySubject& subject)
      : embree(subject.vertices, subject.triangles, 1, false), robust(subject.vertices, subject.triangles, 1, true) {
    for (const auto& [name, traversal] :
         {std::pair{"wide", BvhTraversal::wide}, std::pair{"portable", BvhTraversal::wide_portable},
          device.info().native_float_lanes >= 16 ? std::pair{"wide-8", BvhTraversal::wide_8}
                                                 : std::pair{"wide-16", BvhTraversal::wide_16}})
      entries.push_back({name, std::make_unique<Bvh>(device, subject.vertices, subject.triangles, traversal)});
  }
};

void measure(Device& device, KernelScheduler& scheduler, const Field& field, const RaySubject& subject,
             const std::string& scene, RayKind kind, const Options& options) {
  const std::vector<Ray>& rays = subject.rays(kind);
  const bool any = kind == RayKind::shadow;
  // Packets of camera rays are squares of pixels on both sides.
  const uint32_t row = kind == RayKind::primary ? options.width : 0;
  const std::vector<Ray> packets = row > 0 ? in_tiles(rays, row) : rays;
  std::vector<Hit> hits(rays.size()), hits16(rays.size());
  std::vector<uint32_t> occluded(rays.size()), occluded16(rays.size());
  std::vector<std::unique_ptr<TracedBatch>> batches;
  std::vector<Contestant> contestants;
  for (const Field::Entry& entry : field.entries) {
    TracedBatch* batch = batches
                             .emplace_back(std::make_unique<TracedBatch>(device, scheduler, *entry.bvh, rays, any,
                                                                         std::vector<RayEnds>(), row))
                             .get();
    contestants.push_back({.name = entry.name, .run = [batch] { batch->run(); }});
  }
  if (device.info().compute_units > 1) {
    TracedBatch* batch = batches.front().get();
    contestants.push_back({.name = "wide, 2 threads", .run = [batch] { batch->run(); }, .cpus = 2});
  }
  if (EmbreeScene::available()) {
    contestants.push_back(
        {.name = "Embree", .run = [&] { any ? field.embree.any(rays, occluded) : field.embree.closest(rays, hits); }});
    contestants.push_back({.name = "Embree packets of 16", .run = [&] {
                             any ? field.embree.any16(packets, occluded16) : field.embree.closest16(packets, hits16);
                           }});
  }
  std::erase_if(contestants,
                [&](const Contestant& c) { return !options.only.empty() && !listed(options.only, c.name); });
  run_rounds(contestants, options.rounds);
  std::vector<std::string> differences(contestants.size(), "-");
  if (EmbreeScene::available()) {
    std::vector<Hit> right(rays.size());
    std::vector<uint32_t> right_any(rays.size());
    any ? field.robust.any(rays, right_any) : field.robust.closest(rays, right);
    const auto against = [&](const std::vector<Hit>& closest, const std::vector<uint32_t>& occlusion) {
      return any ? std::to_string(count_differences(occlusion, right_any))
                 : describe_differences(subject, rays, closest, right);
    };
    for (size_t i = 0; i < contestants.size(); ++i) {
      const std::string& name = contestants[i].name;
      if (name == "Embree") {
        differences[i] = against(hits, occluded);
      } else if (name == "Embree packets of 16") {
        differences[i] = any ? against({}, occluded16)
                             : describe_differences(subject, packets, hits16, row > 0 ? in_tiles(right, row) : right);
      } else {
        const TracedBatch& batch = *batches[name == "portable" ? 1 : 0];
        differences[i] = any ? against({}, batch.occluded()) : against(batch.hits(), {});
      }
    }
  }
  print_rows(scene, kind, rays.size(), contestants, differences);
}

void run(const Options& options) {
  DeviceOptions two;
  two.threads = 2;
  const std::shared_ptr<Device> device = Device::open(two);
  KernelScheduler scheduler(device);
  fmt::print("{}; {} rounds; Mrays/s per thread by processor time and by elapsed time\n\n", device->info().name,
             options.rounds);
  for (const std::string& scene : options.scenes) {
    const RaySubject subject(*device, scheduler, scene, options.width, options.height, options.shuffled);
    const Field field(*device, subject);
    const std::string name = std::filesystem::path(scene.substr(0, scene.find('@'))).stem().string();
    const BvhStatistics& built = field.entries.front().bvh->statistics();
    fmt::print("{}: {} triangles, {} primary and {} other rays, ", name, built.triangles, subject.primary.size(),
               subject.diffuse.size());
    const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
    const EmbreeScene parallel(subject.vertices, subject.triangles, threads, false);
    fmt::print("{:.1f} bytes per triangle, SAH cost {:.2f}, ", static_cast<double>(built.bytes) / built.triangles,
               built.sah_cost);
    fmt::print("built in {:.3f} s of elapsed time on {} threads (Embree: {:.3f} s, on 1: {:.3f} s)\n\n",
               built.build_seconds, threads, parallel.build_seconds(), field.embree.build_seconds());
    fmt::print("| scene | rays | kernel | Mrays/s cpu | Mrays/s wall | x Embree | x packets | differ (wrong) |\n");
    fmt::print("|---|---|---|---:|---:|---:|---:|---:|\n");
    for (const RayKind kind : {RayKind::primary, RayKind::diffuse, RayKind::shadow})
      if (listed(options.kinds, to_string(kind))) measure(*device, scheduler, field, subject, name, kind, options);
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Rays per second beside Embree's");
  app.add_option("scenes", options.scenes, "scene files or built-in scenes, each optionally with @CAMERA");
  app.add_option("--rounds", options.rounds, "measurements of each contestant")->check(CLI::Range(1, 1000));
  app.add_option("--width", options.width, "pixels")->check(CLI::Range(16, 8192));
  app.add_option("--height", options.height, "pixels")->check(CLI::Range(16, 8192));
  app.add_option("--rays", options.kinds, "primary, diffuse, shadow");
  app.add_option("--only", options.only, "contestants by name");
  app.add_flag("--shuffled", options.shuffled, "diffuse and shadow rays in random order");
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
