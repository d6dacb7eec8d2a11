// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/gbuffer/gbuffer.h"

#include <cstring>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/remedies.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/primitives/primitives.h"
#include "lucarium/services/ray_ends.h"
#include "lucarium/shared/ray.h"

namespace lucarium {
namespace {

std::map<std::string, std::string> defines(const Intersector& intersector, bool first_surface) {
  std::map<std::string, std::string> result = ray_end_defines(intersector);
  if (first_surface) result["LUCARIUM_GBUFFER_FIRST_SURFACE"] = "";
  return result;
}

}  // namespace

struct GBuffer::State {
  State(Device& device, KernelScheduler& scheduler_, const SceneBuffers& scene_, const Intersector& intersector_,
        const Frame& frame_, const std::string& owner_, bool first_surface)
      : scheduler(scheduler_),
        scene(scene_),
        intersector(intersector_),
        frame(frame_),
        owner(owner_),
        pixels(frame_.width * frame_.height),
        primitives(device),
        program(device, SourceLibrary(),
                {"services/gbuffer",
                 {"lucarium/services/gbuffer/generate_camera_rays.cl", "lucarium/services/gbuffer/fill_gbuffer.cl",
                  "lucarium/services/path_integrator/advance_paths.cl"},
                 defines(intersector, first_surface)}),
        points(device, owner, "G-buffer", pixels, remedies::lower_size),
        rays(device, owner, "G-buffer rays", pixels, remedies::lower_size),
        ends(make_ray_ends(device, intersector, owner, "ends of G-buffer rays", pixels, remedies::lower_size)),
        queue(device, owner, "G-buffer queue", pixels, remedies::lower_size),
        active(device, owner, "active G-buffer rays", 1) {
    record_start();
    record_follow();
  }

  void record_start();
  void record_follow();

  KernelScheduler& scheduler;
  const SceneBuffers& scene;
  const Intersector& intersector;
  Frame frame;
  std::string owner;
  uint32_t pixels;
  Primitives primitives;
  Program program;
  TypedBuffer<GBufferPoint> points;
  TypedBuffer<Ray> rays;
  TypedBuffer<RayEnds> ends;     ///< empty where the intersector wants none
  TypedBuffer<uint32_t> queue;   ///< pixel of ray i
  TypedBuffer<uint32_t> active;  ///< one element: rays in the queue
  Schedule start, follow;
  Variable<Frame> start_frame, follow_frame;
  Variable<uint32_t> start_sample, follow_sample, follow_first;
  uint32_t remaining = 0;  ///< read back after every segment
};

void GBuffer::State::record_start() {
  ScheduleRecorder recorder = scheduler.record("start G-buffer", owner);
  start_frame = recorder.variable("frame", frame);
  start_sample = recorder.variable("sample", 0u);
  recorder.pass("generate G-buffer rays", program, "generate_camera_rays")
      .global((pixels + LUCARIUM_CAMERA_RAYS_EACH - 1) / LUCARIUM_CAMERA_RAYS_EACH)
      .arg("frame", start_frame)
      .arg("sample_index", start_sample)
      .arg("rays", rays)
      .arg_if_present("ends", ends)
      .arg("active", active);
  start = recorder.compile();
}

void GBuffer::State::record_follow() {
  ScheduleRecorder recorder = scheduler.record("follow G-buffer rays", owner);
  follow_frame = recorder.variable("frame", frame);
  follow_sample = recorder.variable("sample", 0u);
  follow_first = recorder.variable("first", 1u);
  const BufferRef hits = recorder.transient<Hit>("hits", pixels, remedies::lower_size);
  const BufferRef next_rays = recorder.transient<Ray>("next rays", pixels, remedies::lower_size);
  const BufferRef next_ends =
      transient_ray_ends(recorder, intersector, "ends of next rays", pixels, remedies::lower_size);
  const BufferRef next_queue = recorder.transient<uint32_t>("next queue", pixels, remedies::lower_size);
  const BufferRef alive = recorder.transient<uint32_t>("alive", pixels, remedies::lower_size);
  const BufferRef survivors = recorder.transient<uint32_t>("survivors", pixels, remedies::lower_size);
  const BufferRef next_active = recorder.transient<uint32_t>("next active", 1);
  intersector.record_closest(recorder, "closest hit", {rays, active, 0, pixels, ends, frame.width}, hits);
  PassBuilder fill = recorder.pass("fill G-buffer", program, "fill_gbuffer");
  scene.bind(fill);
  fill.global_by(active)
      .arg("frame", follow_frame)
      .arg("sample_index", follow_sample)
      .arg("first", follow_first)
      .arg("rays", rays)
      .arg("hits", hits)
      .arg("queue", queue)
      .arg("active", active)
      .arg("points", points)
      .arg("next_rays", next_rays)
      .arg_if_present("next_ends", next_ends)
      .arg("next_queue", next_queue)
      .arg("alive", alive);
  primitives.record_compact(recorder, "compact rays", alive, survivors, next_active, 0, active, 0, pixels);
  recorder.pass("advance rays", program, "advance_paths")
      .global_by(active)
      .arg("survivors", survivors)
      .arg("next_active", next_active)
      .arg("next_rays", next_rays)
      .arg("next_queue", next_queue)
      .arg_if_present("next_ends", next_ends)
      .arg_if_present("ends", ends)
      .arg("rays", rays)
      .arg("queue", queue)
      .arg("active", active);
  recorder.read_back("active rays", active, [this](std::span<const std::byte> bytes) {
    std::memcpy(&remaining, bytes.data(), sizeof remaining);
  });
  follow = recorder.compile();
}

GBuffer::GBuffer(Device& device, KernelScheduler& scheduler, const SceneBuffers& scene, const Intersector& intersector,
                 const Frame& frame, const std::string& owner, bool first_surface)
    : state_(std::make_unique<State>(device, scheduler, scene, intersector, frame, owner, first_surface)) {}

GBuffer::~GBuffer() = default;

bool GBuffer::render(uint32_t sample_index) {
  State& s = *state_;
  s.start.set(s.start_frame, s.frame);
  s.start.set(s.start_sample, sample_index);
  s.follow.set(s.follow_frame, s.frame);
  s.follow.set(s.follow_sample, sample_index);
  if (s.scheduler.run(s.start) == RunResult::cancelled) return false;
  s.remaining = s.pixels;
  s.follow.set(s.follow_first, 1u);
  while (s.remaining > 0) {
    if (s.scheduler.run(s.follow) == RunResult::cancelled) return false;
    s.follow.set(s.follow_first, 0u);
  }
  return true;
}

void GBuffer::set_frame(const Frame& frame) {
  if (frame.width != state_->frame.width || frame.height != state_->frame.height)
    throw Error(ErrorClass::internal, "GBuffer::set_frame: the image size cannot change");
  state_->frame = frame;
}

void GBuffer::warm_up() {
  for (Schedule* schedule : {&state_->start, &state_->follow}) state_->scheduler.warm_up(*schedule);
}

const TypedBuffer<GBufferPoint>& GBuffer::points() const { return state_->points; }

void GBuffer::resolve(Film& film) const {
  const State& s = *state_;
  if (film.pixel_count() != s.pixels) throw Error(ErrorClass::internal, "the film has another size than the G-buffer");
  s.scheduler.finish();
  const std::vector<GBufferPoint> points = s.points.download();
  const auto write = [&](const char* name, const std::vector<std::string>& channels, float4 GBufferPoint::*member) {
    FilmLayer& layer = film.layer(name, channels);
    layer.pixels.resize(points.size() * 3);
    for (size_t p = 0; p < points.size(); ++p) {
      const float4& value = points[p].*member;
      const bool surface = points[p].state == LUCARIUM_GBUFFER_SURFACE;
      for (size_t c = 0; c < 3; ++c) layer.pixels[3 * p + c] = surface ? (&value.x)[c] : 0.f;
    }
  };
  write("Albedo", {"R", "G", "B"}, &GBufferPoint::albedo);
  write("P", {"X", "Y", "Z"}, &GBufferPoint::position);
  write("N", {"X", "Y", "Z"}, &GBufferPoint::normal);
  write("Ns", {"X", "Y", "Z"}, &GBufferPoint::shading);
}

size_t GBuffer::estimate_bytes(uint32_t width, uint32_t height, bool ray_ends) {
  return size_t{width} * height *
         (sizeof(GBufferPoint) + 2 * (sizeof(Ray) + (ray_ends ? sizeof(RayEnds) : 0)) + sizeof(Hit) +
          4 * sizeof(uint32_t));
}

}  // namespace lucarium
