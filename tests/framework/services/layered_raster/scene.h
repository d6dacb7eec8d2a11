// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstring>
#include <span>
#include <tuple>
#include <vector>

#include "../bvh/triangle_soups.h"
#include "lucarium/scene/scene.h"
#include "lucarium/services/layered_raster/layered_raster.h"

namespace lucarium::test {

/// A scene of one mesh with one white material.
inline Scene scene_of(const Soup& soup, SceneMaterial material = {}) {
  Scene scene;
  Mesh mesh;
  for (const Vertex& vertex : soup.vertices) {
    mesh.positions.push_back(vertex.position.xyz());
    mesh.normals.emplace_back(0, 0, 1);
  }
  for (const Triangle& triangle : soup.triangles) mesh.triangles.emplace_back(triangle.v0, triangle.v1, triangle.v2);
  scene.meshes.push_back(std::move(mesh));
  scene.materials.push_back(material);
  SceneInstance instance;
  instance.mesh = 0;
  instance.material = 0;
  scene.instances.push_back(instance);
  return scene;
}

/// World x, y are pixel coordinates and z is the depth within ±depth, so that positions on the grid of 1/256 pixel are
/// projected without rounding.
inline LayeredView pixel_view(uint32_t width, uint32_t height, float depth = 16) {
  LayeredView view{};
  view.row_x = float4(1, 0, 0, 0);
  view.row_y = float4(0, 1, 0, 0);
  view.row_w = float4(0, 0, 1, 0);
  view.depth_min = -depth;
  view.depth_scale = 1 / (2 * depth);
  view.width = width;
  view.height = height;
  view.seed = 1;
  return view;
}

/// Large and small triangles all over an image, unrelated to the grid of pixels.
inline Soup image_triangles(uint32_t count, float width, float height, uint32_t seed) {
  Soup soup;
  Random random(seed);
  for (uint32_t i = 0; i < count; ++i) {
    const glm::vec3 center(random.uniform(-0.2f, 1.2f) * width, random.uniform(-0.2f, 1.2f) * height,
                           random.uniform(-9, 9));
    const float size = width * std::exp(random.uniform(-4, 0.3f));
    const auto corner = [&] { return center + glm::vec3(size, size, 5) * random.in_cube(1); };
    soup.add_triangle(corner(), corner(), corner());
  }
  return soup;
}

/// A stored A-buffer on the host.
struct HostLayers {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> pixel_start;
  std::vector<LayeredFragment> fragments;
  uint32_t dropped = 0;

  std::span<const LayeredFragment> at(uint32_t x, uint32_t y) const {
    const uint32_t pixel = y * width + x;
    return {fragments.data() + pixel_start[pixel], fragments.data() + pixel_start[pixel + 1]};
  }
};

template <class T>
std::vector<T> vector_of(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// Device, scene and raster for one set of triangles.
class LayeredScene {
 public:
  LayeredScene(const Scene& scene, const LayeredRasterOptions& options, const DeviceOptions& device = {},
               const SchedulerOptions& scheduling = {})
      : scheduler_(Device::open(device), scheduling),
        buffers_(scheduler_.device(), scene),
        raster_(scheduler_, buffers_, options) {}

  /// `classes`: with LayeredRasterOptions::classes, the class byte of every triangle.
  HostLayers store(const LayeredView& view, const LayeredStoreOptions& options = {},
                   std::vector<uint8_t> classes = {}) {
    const TypedBuffer<LayeredView> views(scheduler_.device(), "test", "views", std::vector<LayeredView>{view});
    ScheduleRecorder recorder = scheduler_.record("store", "test");
    LayeredRaster::ViewRef ref{views, recorder.variable("view", 0u)};
    if (!classes.empty()) {
      classes.resize(LayeredRaster::class_bytes(classes.size()));
      ref.classes = TypedBuffer<uint8_t>(scheduler_.device(), "test", "classes", classes);
    }
    const LayeredRaster::Stored stored = raster_.record_stored(recorder, "layers", ref, options);
    HostLayers layers{view.width, view.height, {}, {}};
    recorder.read_back("starts", stored.pixel_start,
                       [&](auto bytes) { layers.pixel_start = vector_of<uint32_t>(bytes); });
    recorder.read_back("fragments", stored.fragments,
                       [&](auto bytes) { layers.fragments = vector_of<LayeredFragment>(bytes); });
    recorder.read_back("dropped", stored.dropped, [&](auto bytes) { layers.dropped = vector_of<uint32_t>(bytes)[0]; });
    Schedule schedule = recorder.compile();
    scheduler_.run(schedule);
    scheduler_.finish();
    return layers;
  }

  struct Nearest {
    std::vector<float> depth;
    std::vector<uint32_t> triangle;
  };
  Nearest nearest(const LayeredView& view) {
    const TypedBuffer<LayeredView> views(scheduler_.device(), "test", "views", std::vector<LayeredView>{view});
    const TypedBuffer<float> depth(scheduler_.device(), "test", "depth", size_t{view.width} * view.height);
    const TypedBuffer<uint32_t> triangle(scheduler_.device(), "test", "triangle", size_t{view.width} * view.height);
    ScheduleRecorder recorder = scheduler_.record("nearest", "test");
    raster_.record_nearest(recorder, "nearest", {views, recorder.variable("view", 0u)}, depth, triangle);
    Schedule schedule = recorder.compile();
    scheduler_.run(schedule);
    scheduler_.finish();
    return {depth.download(), triangle.download()};
  }

  void update(const Scene& scene, const SceneChange& change) {
    buffers_.update(scene, change);
    raster_.update();
  }

  KernelScheduler& scheduler() { return scheduler_; }
  const SceneBuffers& buffers() const { return buffers_; }
  const LayeredRaster& raster() const { return raster_; }

 private:
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  LayeredRaster raster_;
};

inline bool same_layers(const HostLayers& a, const HostLayers& b) {
  return a.pixel_start == b.pixel_start && a.fragments.size() == b.fragments.size() &&
         std::memcmp(a.fragments.data(), b.fragments.data(), a.fragments.size() * sizeof(LayeredFragment)) == 0;
}

}  // namespace lucarium::test
