// SPDX-License-Identifier: Apache-2.0
// Milliseconds per direction of all-fragment rasterization with radiance exchange, and how many times faster that is
// than the same rays through the hierarchy.
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <chrono>
#include <random>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/scene/load/load_scene.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/layered_raster/layered_raster.h"
#include "lucarium/services/surface_atlas/surface_atlas.h"
#include "pictures.h"
#include "room.h"
#include "through_rays.h"

const lucarium::EmbeddedSources& lucarium_layer_bench_kernels();

namespace {

using namespace lucarium;

struct Settings {
  std::string scene = "room";
  uint32_t size = 1024, directions = 32, rounds = 3;
  uint64_t texels = 1'000'000;
  bool rays = true, profile = false, variants = false;
  std::string picture;
};

/// Uniform directions; images are the square around the bounding sphere.
std::vector<LayeredView> make_views(const Scene& scene, uint32_t count, uint32_t size) {
  const Bounds bounds = scene.bounds();
  const float radius = bounds.radius() * 1.0001f, pixel = 2 * radius / static_cast<float>(size);
  std::mt19937 engine(7);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<LayeredView> views;
  for (uint32_t i = 0; i < count; ++i) {
    const float z = 2 * unit(engine) - 1, angle = 6.2831853f * unit(engine), r = std::sqrt(std::max(0.f, 1 - z * z));
    const glm::vec3 direction(r * std::cos(angle), r * std::sin(angle), z);
    const glm::vec3 other = std::abs(z) < 0.9f ? glm::vec3(0, 0, 1) : glm::vec3(1, 0, 0);
    const glm::vec3 right = glm::normalize(glm::cross(other, direction));
    const glm::vec2 corner(-radius - pixel * unit(engine), -radius - pixel * unit(engine));
    views.push_back(orthographic_view(bounds.center(), direction, right, pixel, size, size, radius, corner));
  }
  return views;
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Of all threads.
double processor_seconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Cost {
  double wall = 0, processor = 0;  ///< [s]
};

class Bench {
 public:
  explicit Bench(const Settings& settings)
      : settings_(settings),
        scene_(settings.scene == "room" ? bench::make_full_room() : load_scene(settings.scene)),
        scheduler_(Device::open()),
        buffers_(scheduler_.device(), scene_),
        atlas_(scheduler_.device(), scheduler_, scene_, buffers_, atlas_options(settings), "bench"),
        raster_(scheduler_, buffers_, {.max_width = settings.size, .max_height = settings.size}),
        bvh_(scheduler_.device(), scene_, buffers_),
        views_(scheduler_.device(), "bench", "views", make_views(scene_, settings.directions, settings.size)),
        rays_(scheduler_, bvh_, views_, settings.size * settings.size) {
    fmt::print("{}: {} triangles, {} texel sides, image {} x {}\n", settings.scene, scene_.triangle_count(),
               atlas_.info().texel_count, settings.size, settings.size);
    SourceLibrary library;
    library.add(lucarium_layer_bench_kernels());
    exchange_ =
        Program(scheduler_.device(), library,
                {.name = "bench/exchange", .files = {"bench/layers/exchange.cl"}, .defines = raster_.defines()});
    record_exchange();
  }

  void run() {
    if (!settings_.picture.empty()) {
      write_pictures(scheduler_, raster_, views_.download()[0], settings_.picture);
      return;
    }
    std::vector<double> ratios;
    Cost best{1e9, 1e9};
    if (settings_.variants) {
      measure_variants();
      return;
    }
    const double updates = updates_per_direction();  // compiles, too, and grows what is sized by counters
    if (settings_.rays) trace(0);
    scheduler_.reset_profile();
    for (uint32_t round = 0; round < settings_.rounds; ++round) {
      const Cost all = exchange(0, settings_.directions, 1);
      best.wall = std::min(best.wall, all.wall);
      best.processor = std::min(best.processor, all.processor);
      if (!settings_.rays) continue;
      // The same two directions for both sides.
      constexpr uint32_t traced = 2;
      const Cost raster = exchange(round * traced, traced, 8);
      Cost rays;
      uint64_t hits = 0;
      for (uint32_t i = 0; i < traced; ++i) {
        const auto [cost, found] = trace((round * traced + i) % settings_.directions);
        rays.wall += cost.wall / traced;
        rays.processor += cost.processor / traced;
        hits += found;
      }
      ratios.push_back(rays.processor / raster.processor);
      fmt::print(
          "round {}: raster {:.2f} ms ({:.2f} of processor), rays {:.1f} ms ({:.1f}) per direction, {:.2f} M hits: "
          "{:.1f} times the processor time\n",
          round, 1e3 * raster.wall, 1e3 * raster.processor, 1e3 * rays.wall, 1e3 * rays.processor,
          1e-6 * static_cast<double>(hits) / traced, ratios.back());
    }
    fmt::print(
        "{:.2f} ms per direction, {:.2f} of processor (least of rounds); {:.3f} M receiver updates, {:.0f} M/s "
        "of processor time\n",
        1e3 * best.wall, 1e3 * best.processor, 1e-6 * updates, 1e-6 * updates / best.processor);
    if (!ratios.empty()) {
      std::sort(ratios.begin(), ratios.end());
      fmt::print("{:.1f} times as fast as rays (median)\n", ratios[ratios.size() / 2]);
    }
    if (settings_.profile) fmt::print("{}\n", scheduler_.profile().table());
  }

  /// Set-up to sorted fragments.
  void measure_variants() {
    const std::pair<const char*, LayeredStoreOptions> variants[] = {
        {"tiles", {}},
        {"exact (count, scan, fill)", {.variant = LayeredVariant::exact}},
        {"linked list", {.variant = LayeredVariant::linked_list, .list_capacity = 16}},
        {"k-buffer, 8", {.variant = LayeredVariant::k_buffer, .keep = 8}}};
    for (const auto& [name, options] : variants) {
      ScheduleRecorder recorder = scheduler_.record(name, "bench");
      view_ = recorder.variable("view", 0u);
      raster_.record_stored(recorder, "layers", {views_, view_}, options);
      schedule_ = recorder.compile();
      exchange(0, settings_.directions, 1);
      Cost best{1e9, 1e9};
      for (uint32_t round = 0; round < settings_.rounds; ++round) {
        const Cost cost = exchange(0, settings_.directions, 1);
        best.wall = std::min(best.wall, cost.wall);
        best.processor = std::min(best.processor, cost.processor);
      }
      fmt::print("{:26} {:7.2f} ms per direction, {:7.2f} of processor\n", name, 1e3 * best.wall, 1e3 * best.processor);
    }
  }

 private:
  static SurfaceAtlasOptions atlas_options(const Settings& settings) {
    SurfaceAtlasOptions options;
    options.texel_count = settings.texels;
    return options;
  }

  void record_exchange() {
    // Every texel side sends 1 in all channels, and counts 1.
    sides_.resize(2 * size_t{atlas_.info().texel_count});
    for (size_t i = 0; i < sides_.size(); i += 2) sides_[i].x = sides_[i].y = std::bit_cast<float>(0x3c003c00u);
    side_buffer_ = TypedBuffer<float4>(scheduler_.device(), "bench", "sides", sides_);
    ScheduleRecorder recorder = scheduler_.record("exchange", "bench");
    view_ = recorder.variable("view", 0u);
    raster_.record_tiles(recorder, "bundle", {views_, view_}, exchange_, "exchange", [&](PassBuilder& pass) {
      pass.arg("atlas_triangles", atlas_.triangles())
          .arg("atlas_table", atlas_.table())
          .arg("sides", side_buffer_)
          .arg("double_sided", atlas_.info().double_sided_count);
    });
    schedule_ = recorder.compile();
  }

  /// Cost per direction of some directions from `first` on, several times in turns.
  Cost exchange(uint32_t first, uint32_t count, uint32_t times) {
    const double start = now(), processor = processor_seconds();
    for (uint32_t i = 0; i < count * times; ++i) {
      schedule_.set(view_, (first + i % count) % settings_.directions);
      scheduler_.run(schedule_);
    }
    scheduler_.finish();
    const double runs = count * times;
    return {(now() - start) / runs, (processor_seconds() - processor) / runs};
  }

  double updates_per_direction() {
    side_buffer_.upload(sides_);
    exchange(0, settings_.directions, 1);
    double sum = 0;
    const std::vector<float4> after = side_buffer_.download();
    for (size_t i = 1; i < after.size(); i += 2) sum += after[i].w;
    return sum / settings_.directions;
  }

  /// Cost and hits.
  std::pair<Cost, uint32_t> trace(uint32_t view) {
    const double start = now(), processor = processor_seconds();
    const uint32_t found = rays_.trace(view);
    return {{now() - start, processor_seconds() - processor}, found};
  }

  Settings settings_;
  Scene scene_;
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  SurfaceAtlas atlas_;
  LayeredRaster raster_;
  Bvh bvh_;
  TypedBuffer<LayeredView> views_;
  std::vector<float4> sides_;
  TypedBuffer<float4> side_buffer_;
  bench::ThroughRays rays_;
  Program exchange_;
  Schedule schedule_;
  Variable<uint32_t> view_;
};

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("All-fragment rasterization and exchange beside rays");
  app.add_option("scene", settings.scene, "`room` (70 000 triangles) or any scene")->capture_default_str();
  app.add_option("--size", settings.size, "edge of the image [pixels]")->capture_default_str();
  app.add_option("--texels", settings.texels, "texel sides of the atlas")->capture_default_str();
  app.add_option("--directions", settings.directions)->capture_default_str();
  app.add_option("--rounds", settings.rounds)->capture_default_str();
  app.add_flag("!--no-rays", settings.rays, "leave out the rays");
  app.add_option("--picture", settings.picture,
                 "write PREFIX_layers.png and PREFIX_depth.png of the first direction, and end");
  app.add_flag("--variants", settings.variants, "measure the ways to a stored A-buffer instead");
  app.add_flag("--profile", settings.profile, "print where the time goes");
  CLI11_PARSE(app, argc, argv);
  try {
    Bench(settings).run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
  return 0;
}
