// SPDX-License-Identifier: Apache-2.0
#include "pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "lucarium/film/image_io.h"

namespace lucarium {

namespace {

void write_gray(const std::string& file, const LayeredView& view, const std::vector<float>& values) {
  std::vector<float> rgb;
  for (const float value : values) rgb.insert(rgb.end(), 3, value);
  write_png(file, view.width, view.height, rgb);
}

}  // namespace

void write_pictures(KernelScheduler& scheduler, const LayeredRaster& raster, const LayeredView& view,
                    const std::string& prefix) {
  const size_t pixels = size_t{view.width} * view.height;
  const TypedBuffer<LayeredView> views(scheduler.device(), "bench", "views", std::vector<LayeredView>{view});
  const TypedBuffer<float> depth(scheduler.device(), "bench", "depth", pixels);
  const TypedBuffer<uint32_t> triangle(scheduler.device(), "bench", "triangle", pixels);
  std::vector<uint32_t> starts(pixels + 1);
  ScheduleRecorder recorder = scheduler.record("pictures", "bench");
  const LayeredRaster::ViewRef ref{views, recorder.variable("view", 0u)};
  const LayeredRaster::Stored stored = raster.record_stored(recorder, "layers", ref);
  raster.record_nearest(recorder, "nearest", ref, depth, triangle);
  recorder.read_back("starts", stored.pixel_start, [&](std::span<const std::byte> bytes) {
    std::memcpy(starts.data(), bytes.data(), starts.size() * sizeof(uint32_t));
  });
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();

  std::vector<float> layers(pixels), nearness = depth.download();
  uint32_t largest = 1;
  for (size_t i = 0; i < pixels; ++i) largest = std::max(largest, starts[i + 1] - starts[i]);
  for (size_t i = 0; i < pixels; ++i) {
    layers[i] = static_cast<float>(starts[i + 1] - starts[i]) / static_cast<float>(largest);
    nearness[i] = std::isinf(nearness[i]) ? 0.f : 1 - (nearness[i] - view.depth_min) * view.depth_scale;
  }
  write_gray(prefix + "_layers.png", view, layers);
  write_gray(prefix + "_depth.png", view, nearness);
  fmt::print("{} fragments, at most {} in a pixel\n", starts.back(), largest);
}

}  // namespace lucarium
