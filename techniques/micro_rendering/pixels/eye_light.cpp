// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/pixels/eye_light.h"

#include "lucarium/compute/program/source_library.h"
#include "lucarium/film/film.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

void resolve_sum(Film& film, const char* name, const TypedBuffer<float4>& sums) {
  FilmLayer& layer = film.layer(name, {"R", "G", "B"}, true);
  const std::vector<float4> values = sums.download();
  for (size_t i = 0; i < values.size(); ++i) {
    const float scale = values[i].w > 0 ? 1 / values[i].w : 0;
    for (size_t c = 0; c < 3; ++c) layer.pixels[3 * i + c] = scale * (&values[i].x)[c];
  }
}

}  // namespace

EyeLight::EyeLight(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                   const Intersector& intersector, const Frame& frame, uint32_t kinds, uint32_t direct_samples,
                   const std::string& owner)
    : scheduler_(scheduler),
      direct_samples_(direct_samples),
      seed_(frame.seed),
      gbuffer_(device, scheduler, scene, intersector, frame, owner),
      direct_light_(device, scheduler, scene, intersector, owner, kinds) {
  const uint32_t pixels = frame.width * frame.height;
  emission_ = TypedBuffer<float4>(device, owner, "emission", pixels, "lower --size");
  direct_ = TypedBuffer<float4>(device, owner, "direct light", pixels, "lower --size");
  frame_direct_ = TypedBuffer<float4>(device, owner, "direct light of a frame", pixels, "lower --size");
  SourceLibrary library;
  library.add(micro_rendering_kernels());
  program_ = Program(device, library, {"micro_rendering/pixels", {"micro_rendering/pixels/micro_pixels.cl"}, {}});
  ScheduleRecorder recorder = scheduler.record("add emission and direct light", owner);
  recorder.pass("add emission and direct light", program_, "mr_add_direct")
      .global(pixels)
      .local(64)
      .arg("points", points())
      .arg("count", pixels)
      .arg("frame_direct", frame_direct_)
      .arg("emission", emission_)
      .arg("direct", direct_);
  add_ = recorder.compile();
}

void EyeLight::set_frame(const Frame& frame) {
  seed_ = frame.seed;
  gbuffer_.set_frame(frame);
}

bool EyeLight::add(uint32_t frame) {
  scheduler_.finish();
  frame_direct_.fill_zero();
  for (uint32_t s = 0; s < direct_samples_; ++s)
    if (!direct_light_.accumulate_radiance(points(), frame_direct_, frame * direct_samples_ + s, seed_)) return false;
  scheduler_.run_to_end(add_);
  return true;
}

void EyeLight::restart() {
  emission_.fill_zero();
  direct_.fill_zero();
}

void EyeLight::warm_up() {
  gbuffer_.warm_up();
  direct_light_.warm_up(points(), frame_direct_);
  scheduler_.warm_up(add_);
}

void EyeLight::resolve(Film& film) const {
  resolve_sum(film, "emission", emission_);
  resolve_sum(film, "direct", direct_);
}

size_t EyeLight::estimate_bytes(uint32_t width, uint32_t height) {
  const size_t pixels = size_t{width} * height;
  return GBuffer::estimate_bytes(width, height) + DirectLight::estimate_bytes(pixels) + 3 * pixels * sizeof(float4);
}

}  // namespace lucarium::micro
