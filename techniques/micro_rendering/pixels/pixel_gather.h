// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "lucarium/film/film.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/sub_images/sub_images.h"
#include "lucarium/shared/gbuffer.h"
#include "micro_rendering/gather/gather_pass.h"

namespace lucarium::micro {

/// Gathers at the points of a G-buffer, sub-image by sub-image, and sums what pixels reflect. A frame is done when
/// every sub-image was.
class PixelGather {
 public:
  /// `deviations`: per pixel, of the light that add() adds (LayerSpread). `transmits`: some surface is rough and lets
  /// light through; such pixels gather on their far sides too.
  PixelGather(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
              const TypedBuffer<GBufferPoint>& points, uint32_t width, uint32_t height, const PointForest& forest,
              const GatherPass& gather, const DynamicShading& shading, const MicroParameters& parameters,
              bool transmits, const TypedBuffer<float>& deviations, const std::string& owner);

  /// Sub-images of a frame; one where only some pixels gather and the others are interpolated.
  uint32_t batches() const { return interpolates() ? 1 : sub_images_.count(); }
  void set_camera(const Camera& camera);
  /// Gathers at the pixels of one sub-image. False when cancelled; nothing has changed then that resolve() shows.
  bool gather(uint32_t batch, uint32_t frame, uint32_t seed);
  /// By pixel [lx]: what add() takes for gathered where gather() was not called.
  TypedBuffer<float4>& irradiance() { return results_.irradiance; }
  /// Adds what the last gather() found to the sums; to its end, whatever is cancelled.
  void add(uint32_t batch, uint32_t frame);
  void restart();
  void warm_up();
  /// Adds what gathers have seen of the environment to the layer `direct`, which exists; writes the layers `indirect`,
  /// `cut_level`, `list_length`, `node_visits`, with `failures` `upsampling_failed`, and `micro_buffer` where a pixel
  /// is inspected. Pixels that no batch has reached yet show the nearest of the sub-images before.
  void resolve(Film& film, bool failures) const;
  /// Sums of the layer `indirect`, and with gather_env of what gathers see of the environment.
  const TypedBuffer<float4>& sums() const { return indirect_; }
  const TypedBuffer<float4>& sky_sums() const { return sky_; }
  const std::map<std::string, double>& counters() const { return counters_; }
  static size_t estimate_bytes(uint32_t width, uint32_t height, const MicroParameters& parameters, bool transmits);

 private:
  bool interpolates() const { return parameters_.gather_step > 1; }
  /// The pixels that gather in a batch. Where the others are interpolated every frame has another lattice, so that
  /// their mean shows none.
  SubImage sub_image(uint32_t batch, uint32_t frame) const {
    return interpolates() ? sub_images_.lattice(frame) : sub_images_.at(batch);
  }
  /// The pixels that get light by a batch.
  SubImage added_image(uint32_t batch) const { return interpolates() ? sub_images_.whole() : sub_images_.at(batch); }
  uint32_t inspected(uint32_t batch, uint32_t frame) const;
  void record_gather();
  void record_upsample(ScheduleRecorder& recorder);
  void list_gathers(ScheduleRecorder& recorder, const BufferRef& keys, const BufferRef& values, const BufferRef& count,
                    uint32_t capacity, bool failed);
  void record_add();
  void count(std::span<const std::byte> sums);
  void resolve_micro_buffer(Film& film) const;

  Device& device_;
  KernelScheduler& scheduler_;
  const SceneBuffers& scene_;
  TypedBuffer<GBufferPoint> points_;
  uint32_t width_, height_;
  SubImages sub_images_;
  uint32_t capacity_ = 0, added_ = 0, sides_ = 1, inspect_ = 0xffffffffu;
  const PointForest& forest_;
  const GatherPass& gather_;
  const DynamicShading& shading_;
  MicroParameters parameters_;
  std::string owner_;
  Program program_;
  Primitives primitives_;
  GatherResults results_;
  TypedBuffer<uint32_t> gather_count_, failed_count_, failed_;
  TypedBuffer<float4> indirect_, inspected_, kept_micro_buffer_;
  TypedBuffer<float> deviations_;
  TypedBuffer<float4> sky_;  ///< as indirect_, of the environment; with gather_env
  Schedule gather_schedule_, add_schedule_, keep_schedule_;
  Variable<SubImage> gather_sub_, add_sub_, lattice_;
  Variable<MicroSettings> settings_;
  Variable<float2> footprint_;
  std::map<std::string, double> counters_;
};

}  // namespace lucarium::micro
