// SPDX-License-Identifier: Apache-2.0
// A scene, its atlas and the exchange along bundles, without the technique around them.
#pragma once
#include <functional>
#include <memory>

#include "bundle_transfer.h"
#include "direction_sequence.h"
#include "lucarium/scene/builtin_builder.h"
#include "slot_means.h"

namespace lucarium::test {

class BundleRig {
 public:
  BundleRig(Scene scene, uint64_t texels, float pixel_size, bundle::Channels channels = {})
      : channels_(channels),
        scene_(std::move(scene)),
        device_(Device::open()),
        scheduler_(device_),
        buffers_(*device_, scene_),
        atlas_(*device_, scheduler_, scene_, buffers_, options(texels), "test"),
        records_(*device_, "test", "records", size_t{atlas_.info().texel_count} * 2 * channels.count),
        transfer_(*device_, scheduler_, scene_, buffers_, atlas_, records_, channels, pixel_size) {}

  /// What slots send in channel 0; sums are cleared.
  void send(const std::function<glm::vec3(uint32_t slot)>& radiance) {
    std::vector<float4> values(records_.count());
    for (uint32_t slot = 0; slot < slots(); ++slot) values[size_t{slot} * 2 * channels_.count] = float4(radiance(slot), 0.f);
    records_.upload(values);
  }
  void run(const bundle::DirectionSequence& sequence, uint64_t count, uint64_t first = 0) {
    for (uint64_t i = first; i < first + count; ++i) transfer_.exchange(sequence.at(i), static_cast<uint32_t>(i + 1));
    scheduler_.finish();
  }
  /// xyz: sum of w L of channel 0, w: sum of w.
  std::vector<float4> sums() const {
    const std::vector<float4> values = records_.download();
    std::vector<float4> result(slots());
    for (uint32_t slot = 0; slot < slots(); ++slot) result[slot] = values[size_t{slot} * 2 * channels_.count + 1];
    return result;
  }
  uint32_t slots() const { return atlas_.info().texel_count; }
  std::vector<AtlasTexel> texels() const { return atlas_.texels().download(); }
  std::vector<SurfacePoint> points() const { return atlas_.surface_points().download(); }
  const Scene& scene() const { return scene_; }
  /// Instance that a world triangle belongs to.
  uint32_t instance_of(uint32_t triangle) const { return buffers_.scene_triangles.download(triangle, 1).front().instance; }

 private:
  static SurfaceAtlasOptions options(uint64_t texels) {
    SurfaceAtlasOptions result;
    result.texel_count = texels;
    return result;
  }
  bundle::Channels channels_;
  Scene scene_;
  std::shared_ptr<Device> device_;
  KernelScheduler scheduler_;
  SceneBuffers buffers_;
  SurfaceAtlas atlas_;
  TypedBuffer<float4> records_;
  bundle::BundleTransfer transfer_;
};

}  // namespace lucarium::test
