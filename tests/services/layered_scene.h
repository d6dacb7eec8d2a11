// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstring>
#include <span>
#include <tuple>
#include <vector>

#include "lucarium/scene/scene.h"
#include "lucarium/services/layered_raster.h"
#include "triangle_soups.h"

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

/// A stored A-buffer on the host.
struct HostLayers {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> pixel_start;
  std::vector<LayeredFragment> fragments;

  std::span<const LayeredFragment> at(uint32_t x, uint32_t y) const {
    const uint32_t pixel = y * width + x;
    return {fragments.data() + pixel_start[pixel], fragments.data() + pixel_start[pixel + 1]};
  }
};

template <class T>
std::vector<T> vector_of(std::span<const std::byte> bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

/// Device, scene and raster for one set of triangles.
class LayeredScene {
 public:
  LayeredScene(const Scene& scene, const LayeredRasterOptions& options)
      : scheduler_(Device::open()), buffers_(scheduler_.device(), scene), raster_(scheduler_, buffers_, options) {}

  HostLayers store(const LayeredView& view) {
    const TypedBuffer<LayeredView> views(scheduler_.device(), "test", "views", std::vector<LayeredView>{view});
    ScheduleRecorder recorder = scheduler_.record("store", "test");
    const LayeredRaster::ViewRef ref{views, recorder.variable("view", 0u)};
    const LayeredRaster::Stored stored = raster_.record_stored(recorder, "layers", ref);
    HostLayers layers{view.width, view.height, {}, {}};
    recorder.read_back("starts", stored.pixel_start, [&](auto bytes) { layers.pixel_start = vector_of<uint32_t>(bytes); });
    recorder.read_back("fragments", stored.fragments,
                       [&](auto bytes) { layers.fragments = vector_of<LayeredFragment>(bytes); });
    Schedule schedule = recorder.compile();
    scheduler_.run(schedule);
    scheduler_.finish();
    return layers;
  }

  KernelScheduler& scheduler() { return scheduler_; }
  const SceneBuffers& buffers() const { return buffers_; }
  const LayeredRaster& raster() const { return raster_; }

 private:
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  LayeredRaster raster_;
};

}  // namespace lucarium::test
