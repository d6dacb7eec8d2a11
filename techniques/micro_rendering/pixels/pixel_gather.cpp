// SPDX-License-Identifier: Apache-2.0
#include "micro_rendering/pixels/pixel_gather.h"

#include <algorithm>
#include <cstring>
#include <glm/glm.hpp>

#include "lucarium/base/files/embedded_files.h"
#include "lucarium/base/seed.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/compute/program/source_library.h"

const lucarium::EmbeddedSources& micro_rendering_kernels();

namespace lucarium::micro {
namespace {

constexpr uint32_t kRun = 256;  // pixels whose statistics one work-item sums
constexpr size_t kMicroPixels = 64 * 64;

Program pixel_program(Device& device, const MicroParameters& parameters) {
  return make_program(device, micro_rendering_kernels(),
                      {"micro_rendering/pixels/list_gathers", "micro_rendering/pixels/upsample_gathers",
                       "micro_rendering/pixels/add_indirect_light", "micro_rendering/pixels/sum_statistics",
                       "micro_rendering/pixels/keep_micro_buffer"},
                      {{"MICRO_GATHER_ENV", parameters.gather_env ? "1" : "0"},
                       {"MICRO_LEVELS", parameters.keeps_levels() ? "1" : "0"}});
}

}  // namespace

PixelGather::PixelGather(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene,
                         const TypedBuffer<GBufferPoint>& points, uint32_t width, uint32_t height,
                         const PointForest& forest, const GatherPass& gather, const DynamicShading& shading,
                         const MicroParameters& parameters, bool transmits, const TypedBuffer<float>& deviations,
                         const std::string& owner)
    : device_(device),
      scheduler_(scheduler),
      scene_(scene),
      points_(points),
      width_(width),
      height_(height),
      sub_images_(width, height,
                  parameters.gather_step > 1
                      ? SubImages::stride_within(width, height, static_cast<uint32_t>(parameters.gather_step))
                      : SubImages::stride_for(width, height, static_cast<uint32_t>(parameters.batch_gathers))),
      forest_(forest),
      gather_(gather),
      shading_(shading),
      parameters_(parameters),
      owner_(owner),
      program_(pixel_program(device, parameters)),
      primitives_(device),
      deviations_(deviations) {
  const size_t pixels = size_t{width} * height;
  capacity_ = sub_images_.capacity();
  sides_ = transmits ? 2 : 1;
  const auto inside = [](int x, uint32_t size) { return x >= 0 && static_cast<uint32_t>(x) < size; };
  if (inside(parameters.inspect_x, width) && inside(parameters.inspect_y, height))
    inspect_ = static_cast<uint32_t>(parameters.inspect_y) * width + static_cast<uint32_t>(parameters.inspect_x);
  results_ = GatherResults(device, owner, "pixels'", sides_ * pixels, true, parameters.gather_env);
  if (parameters.keeps_levels())
    results_.levels =
        TypedBuffer<float4>(device, owner, "levels of micro-buffers", sides_ * pixels, remedies::lower_size);
  added_ = interpolates() ? width * height : capacity_;
  failed_ = TypedBuffer<uint32_t>(device, owner, "failed interpolations", pixels, remedies::lower_size);
  failed_count_ = TypedBuffer<uint32_t>(device, owner, "number of failed interpolations", 1);
  gather_count_ = TypedBuffer<uint32_t>(device, owner, "number of gathers", 1);
  indirect_ = TypedBuffer<float4>(device, owner, "indirect light", pixels, remedies::lower_size);
  inspected_ = TypedBuffer<float4>(device, owner, "inspected sums", pixels, remedies::lower_size);
  if (parameters.gather_env)
    sky_ = TypedBuffer<float4>(device, owner, "light of the environment", pixels, remedies::lower_size);
  kept_micro_buffer_ = TypedBuffer<float4>(device, owner, "kept micro-buffer", kMicroPixels);
  record_gather();
  record_add();
}

void PixelGather::set_camera(const Camera& camera) {
  if (!interpolates()) return;
  const auto size = [&](const float4& v) { return 2 * glm::length(v.xyz()) / static_cast<float>(width_); };
  gather_schedule_.set(footprint_,
                       float2(size(camera.direction_dx) / std::max(glm::length(camera.direction.xyz()), 1e-20f),
                              size(camera.origin_dx)));
}

/// The pixel whose gather a batch shows in `micro_buffer`: the inspected one, or the one that it lies beside.
uint32_t PixelGather::inspected(uint32_t batch, uint32_t frame) const {
  if (inspect_ == LUCARIUM_NONE) return LUCARIUM_NONE;
  const SubImage sub = sub_image(batch, frame);
  const auto line = [&](uint32_t x, uint32_t offset) { return x < offset ? offset : x - (x - offset) % sub.stride; };
  const uint32_t x = line(inspect_ % width_, sub.offset_x), y = line(inspect_ / width_, sub.offset_y);
  const bool beside = x >= width_ || y >= height_ || (!interpolates() && y * width_ + x != inspect_);
  return beside ? LUCARIUM_NONE : y * width_ + x;
}

void PixelGather::record_gather() {
  ScheduleRecorder recorder = scheduler_.record("gather at pixels", owner_);
  gather_sub_ = recorder.variable("sub_image", SubImage{});
  settings_ = recorder.variable("settings", MicroSettings{});
  const BufferRef keys =
      recorder.transient<uint32_t>("keys of pixels", size_t{sides_} * capacity_, remedies::lower_size);
  const BufferRef values =
      recorder.transient<uint32_t>("sorted pixels", size_t{sides_} * capacity_, remedies::lower_size);
  PassBuilder keying = recorder.pass("keys of pixels", program_, "make_gather_keys");
  scene_.bind(keying);
  keying.global(capacity_)
      .arg("points", points_)
      .arg("sub", gather_sub_)
      .arg("morton", parameters_.morton ? 1u : 0u)
      .arg("capacity", capacity_)
      .arg("pixels", width_ * height_)
      .arg("sides", sides_)
      .arg("statistics", results_.statistics)
      .arg("keys", keys)
      .arg("values", values);
  list_gathers(recorder, keys, values, gather_count_, sides_ * capacity_, false);
  if (interpolates()) record_upsample(recorder);
  gather_schedule_ = recorder.compile();
}

/// From keys of pixels to gathers in their order, and the gathers themselves. `failed`: where interpolation failed.
void PixelGather::list_gathers(ScheduleRecorder& recorder, const BufferRef& keys, const BufferRef& values,
                               const BufferRef& count, uint32_t capacity, bool failed) {
  const BufferRef gathers = recorder.transient<MicroGather>("gathers", capacity, remedies::lower_size);
  primitives_.record_sort_pairs(recorder, "sort pixels", keys, values, capacity, 31);
  PassBuilder fill = recorder.pass("list gathers", program_, "list_gathers");
  scene_.bind(fill);
  fill.global(capacity)
      .arg("points", points_)
      .arg("keys", keys)
      .arg("values", values)
      .arg("count", capacity)
      .arg("pixels", width_ * height_)
      .arg("micro_size", static_cast<uint32_t>(parameters_.micro_size))
      .arg("triangle_edges", forest_.triangle_edges)
      .arg("gathers", gathers)
      .arg("gather_count", count);
  if (parameters_.keeps_levels())
    fill.arg("levels", results_.levels)
        .arg("adaptive", failed ? -1.f : parameters_.adaptive)
        .arg("larger", static_cast<uint32_t>(parameters_.largest_edge()));
  gather_.record(recorder, "gather", scene_, forest_, gathers, count, 0, settings_, results_, shading_);
}

/// Pixels between gathers are interpolated; those where that fails gather themselves.
void PixelGather::record_upsample(ScheduleRecorder& recorder) {
  const uint32_t pixels = width_ * height_;
  footprint_ = recorder.variable("footprint", float2(0, 0));
  const BufferRef keys =
      recorder.transient<uint32_t>("keys of failed pixels", size_t{sides_} * pixels, remedies::lower_size);
  const BufferRef values =
      recorder.transient<uint32_t>("sorted failed pixels", size_t{sides_} * pixels, remedies::lower_size);
  PassBuilder pass = recorder.pass("upsample", program_, "upsample_gathers");
  scene_.bind(pass);
  pass.global(pixels)
      .arg("points", points_)
      .arg("height", height_)
      .arg("sub", gather_sub_)
      .arg("min_weight", parameters_.upsample_fail)
      .arg("footprint", footprint_)
      .arg("morton", parameters_.morton ? 1u : 0u)
      .arg("irradiance", results_.irradiance)
      .arg("specular", results_.specular)
      .arg("statistics", results_.statistics)
      .arg("sides", sides_)
      .arg("keys", keys)
      .arg("values", values)
      .arg("failed", failed_);
  if (parameters_.gather_env) pass.arg("sky", results_.sky);
  list_gathers(recorder, keys, values, failed_count_, sides_ * pixels, true);
}

void PixelGather::record_add() {
  ScheduleRecorder recorder = scheduler_.record("add indirect light", owner_);
  add_sub_ = recorder.variable("sub_image", SubImage{});
  lattice_ = recorder.variable("lattice", SubImage{});
  PassBuilder pass = recorder.pass("add indirect light", program_, "add_indirect_light");
  scene_.bind(pass);
  pass.global(added_)
      .arg("points", points_)
      .arg("sub", add_sub_)
      .arg("lattice", lattice_)
      .arg("irradiance", results_.irradiance)
      .arg("specular", results_.specular)
      .arg("statistics", results_.statistics)
      .arg("failed", failed_)
      .arg("pixels", width_ * height_)
      .arg("sides", sides_)
      .arg("indirect", indirect_)
      .arg("deviations", deviations_)
      .arg("inspected", inspected_);
  if (parameters_.gather_env) pass.arg("sky", results_.sky).arg("sky_light", sky_);
  if (parameters_.keeps_levels()) pass.arg("levels", results_.levels);
  const uint32_t runs = (added_ + kRun - 1) / kRun;
  const BufferRef sums = recorder.transient<MicroStatistics>("sums of statistics", runs);
  recorder.pass("sum statistics", program_, "sum_statistics")
      .global(runs)
      .local(1)
      .arg("points", points_)
      .arg("sub", add_sub_)
      .arg("run", kRun)
      .arg("statistics", results_.statistics)
      .arg("pixels", width_ * height_)
      .arg("sides", sides_)
      .arg("sums", sums);
  recorder.read_back("statistics", sums, [this](std::span<const std::byte> bytes) { count(bytes); });
  add_schedule_ = recorder.compile();

  ScheduleRecorder keeper = scheduler_.record("keep micro-buffer", owner_);
  keeper.pass("keep micro-buffer", program_, "keep_micro_buffer")
      .global(kMicroPixels)
      .arg("micro_buffer", results_.micro_buffer)
      .arg("count", static_cast<uint32_t>(kMicroPixels))
      .arg("kept", kept_micro_buffer_);
  keep_schedule_ = keeper.compile();
}

void PixelGather::count(std::span<const std::byte> sums) {
  for (size_t offset = 0; offset + sizeof(MicroStatistics) <= sums.size(); offset += sizeof(MicroStatistics)) {
    MicroStatistics s;
    std::memcpy(&s, sums.data() + offset, sizeof s);
    counters_["node visits"] += s.visits;
    counters_["splats"] += s.splats;
    counters_["listed leaves"] += s.listed;
    counters_["disc tests"] += s.disc_tests;
    counters_["holes"] += s.holes;
    counters_["list flushes"] += s.flushes;
    counters_["gathers with a list"] += s.levels;
    counters_["gathers"] += s.uneven;
  }
}

bool PixelGather::gather(uint32_t batch, uint32_t frame, uint32_t seed) {
  gather_schedule_.set(gather_sub_, sub_image(batch, frame));
  gather_schedule_.set(settings_,
                       GatherPass::settings(parameters_, frame_seed(seed, frame), inspected(batch, frame), inspect_));
  return scheduler_.run(gather_schedule_) == RunResult::done;
}

void PixelGather::add(uint32_t batch, uint32_t frame) {
  add_schedule_.set(add_sub_, added_image(batch));
  add_schedule_.set(lattice_, sub_image(batch, frame));
  scheduler_.run_to_end(add_schedule_);
  if (inspected(batch, frame) != LUCARIUM_NONE) scheduler_.run_to_end(keep_schedule_);
}

void PixelGather::restart() {
  scheduler_.finish();
  indirect_.fill_zero();
  inspected_.fill_zero();
  if (parameters_.gather_env) sky_.fill_zero();
  if (parameters_.keeps_levels()) results_.levels.fill_zero();
  for (TypedBuffer<float4>* buffer : {&results_.micro_buffer, &kept_micro_buffer_}) buffer->fill_zero();
}

void PixelGather::warm_up() {
  for (Schedule* schedule : {&gather_schedule_, &add_schedule_, &keep_schedule_}) scheduler_.warm_up(*schedule);
}

void PixelGather::resolve(Film& film, bool failures) const {
  scheduler_.finish();
  const std::vector<float4> indirect = indirect_.download(), inspected = inspected_.download();
  const std::vector<float4> sky = parameters_.gather_env ? sky_.download() : std::vector<float4>();
  FilmLayer* const direct = sky.empty() ? nullptr : &film.layer("direct", {"R", "G", "B"}, true);
  FilmLayer& light = film.layer("indirect", {"R", "G", "B"}, true);
  FilmLayer& level = film.layer("cut_level", {"Y"});
  FilmLayer& listed = film.layer("list_length", {"Y"});
  FilmLayer& visits = film.layer("node_visits", {"Y"});
  FilmLayer* const failed = failures ? &film.layer("upsampling_failed", {"Y"}) : nullptr;
  for (uint32_t y = 0; y < height_; ++y) {
    for (uint32_t x = 0; x < width_; ++x) {
      const size_t pixel = size_t{y} * width_ + x;
      const size_t source = sub_images_.nearest_reached(x, y, [&](size_t p) { return indirect[p].w != 0; });
      const float scale = indirect[source].w > 0 ? 1 / indirect[source].w : 0;
      for (size_t c = 0; c < 3; ++c) light.pixels[3 * pixel + c] = scale * (&indirect[source].x)[c];
      if (direct)
        for (size_t c = 0; c < 3; ++c) direct->pixels[3 * pixel + c] += scale * (&sky[source].x)[c];
      const float4& sums = inspected[source];
      level.pixels[pixel] = scale * sums.x;
      listed.pixels[pixel] = scale * sums.y;
      visits.pixels[pixel] = scale * sums.z;
      if (failed) failed->pixels[pixel] = scale * sums.w;
    }
  }
  if (inspect_ != LUCARIUM_NONE) resolve_micro_buffer(film);
}

/// The micro-buffer in the upper left corner of a layer, enlarged as far as the image allows: radiances [cd/m²] towards
/// the point, as seen in the last frame, holes included; 0 where a micro-pixel is empty. Of a surface with two lobes it
/// is the buffer of the larger one. Left to right and top to bottom are the two coordinates of the lobe's map, no
/// compass directions (warp=nusselt: the unit disc in its square, seen along the normal).
void PixelGather::resolve_micro_buffer(Film& film) const {
  const std::vector<float4> buffer = kept_micro_buffer_.download();
  const auto edge = static_cast<uint32_t>(parameters_.largest_edge());
  const uint32_t enlarged = std::max(1u, std::min(width_, height_) / edge);
  FilmLayer& layer = film.layer("micro_buffer");
  for (uint32_t y = 0; y < std::min(height_, edge * enlarged); ++y) {
    for (uint32_t x = 0; x < std::min(width_, edge * enlarged); ++x) {
      const float4& value = buffer[y / enlarged * edge + x / enlarged];
      for (size_t c = 0; c < 3; ++c) layer.pixels[3 * (size_t{y} * width_ + x) + c] = (&value.x)[c];
    }
  }
}

size_t PixelGather::estimate_bytes(uint32_t width, uint32_t height, const MicroParameters& parameters, bool transmits) {
  const size_t pixels = size_t{width} * height, sides = transmits ? 2 : 1;
  const size_t batch =
      parameters.gather_step > 1 ? 2 * pixels : std::min(pixels, static_cast<size_t>(parameters.batch_gathers));
  const bool sky = parameters.gather_env, levels = parameters.keeps_levels();
  return GatherResults::estimate_bytes(sides * pixels, true, sky) +
         pixels * ((2 + sky + (levels ? sides : 0)) * sizeof(float4) + sizeof(uint32_t)) +
         kMicroPixels * sizeof(float4) + sides * batch * (4 * sizeof(uint32_t) + sizeof(MicroGather)) +
         (size_t{1} << 18);
}

}  // namespace lucarium::micro
