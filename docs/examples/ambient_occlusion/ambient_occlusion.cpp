// SPDX-License-Identifier: Apache-2.0
//
// ambient_occlusion: share of the hemisphere of a surface point that is not occluded
// -----------------------------------------------------------------------------------
//
// Idea. The accessibility of a point x with normal n is
//
//   A(x) = 1/π ∫ V(x, ω, d) (n·ω) dω
//
// over the hemisphere of n, where V is 1 when a ray from x along ω meets nothing within the distance d (Zhukov, Iones
// and Kronin, An Ambient Light Illumination Model, Rendering Techniques 1998, with a step as falloff). Directions with
// density cos/π make every sample simply V.
//
// What is counted. No light: the technique's path set is empty, and a comparison with a reference means nothing. Its
// one layer is `ambient_occlusion`, 0 (closed) to 1 (open); pixels that see no surface are 1. Mirrors and clear glass
// are looked through, as by every technique that uses the G-buffer.
//
// Error. Unbiased for the given distance; the sum of up to 2^24 samples is exact.
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/layer_sums/layer_sums.h"
#include "lucarium/shared/ray.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"

const lucarium::EmbeddedSources& ambient_occlusion_kernels();

namespace {
using namespace lucarium;

const char* const owner = "ambient_occlusion";  // pays for the memory in the account of the device

// ---- options: name, default, range, unit and meaning, each said once

struct Options {
  float distance = 0.25f;

  template <class V>
  void describe(V& v) {
    v.number("distance", distance, 1e-6f, 1e6f, "scene radii", "distance beyond which surfaces do not occlude");
  }
};

// ---- what it can do: `lucarium check` tests every claim

TechniqueInfo describe_technique() {
  TechniqueInfo info;
  info.name = "ambient_occlusion";
  info.version = "1.0";
  info.summary = "ambient occlusion of every visible point within a distance; no light";
  info.citation = "S. Zhukov, A. Iones and G. Kronin, An Ambient Light Illumination Model, Rendering Techniques 1998";
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.layers = {"ambient_occlusion"};
  return info;
}

// ---- code

class AmbientOcclusion : public TechniqueBase<Options> {
 public:
  PathSet path_set(const Scene&, const RenderSettings&) const override { return PathSet::no_light_transport(); }

  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override {
    return {"computes accessibility, not light"};
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    const size_t pixels = size_t{settings.width} * settings.height;
    return GBuffer::estimate_bytes(settings.width, settings.height) + LayerSums::estimate_bytes(pixels, 1) +
           pixels * (sizeof(Ray) + sizeof(uint32_t));
  }

 protected:
  void compile() override {
    program_ = make_program(device(), ambient_occlusion_kernels(), {"ambient_occlusion/occlusion"});
  }

  void build() override {
    schedule_ = {};  // what refers to memory goes before the memory
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device(), scheduler(), scene_buffers(), bvh(), frame(), owner);
    sums_ = LayerSums(device(), owner, pixels(), {"ambient_occlusion"});
    count_ = TypedBuffer<uint32_t>(device(), owner, "pixels", std::vector<uint32_t>{pixels()});
    record();
  }

  void restart() override {
    gbuffer_->set_frame(frame());
    sums_.clear();
  }

  /// The sums change in the last pass alone, so that a cancelled iteration leaves them as they were.
  bool step() override {
    const auto index = static_cast<uint32_t>(samples());
    schedule_.set(sample_index_, index);
    schedule_.set(seed_, seed());
    return gbuffer_->render(index) && scheduler().run(schedule_) == RunResult::done;
  }

  void write(Film& film) override { sums_.write(film); }

  void warm_up_kernels() override {
    gbuffer_->warm_up();
    scheduler().warm_up(schedule_);
  }

 private:
  void record() {
    ScheduleRecorder recorder = scheduler().record("occlusion", owner);
    sample_index_ = recorder.variable("sample_index", 0u);
    seed_ = recorder.variable("seed", 0u);
    const BufferRef rays = recorder.transient<Ray>("occlusion rays", pixels(), "lower --size");
    const BufferRef occluded = recorder.transient<uint32_t>("occluded", pixels(), "lower --size");
    PassBuilder generate = recorder.pass("generate occlusion rays", program_, "generate_occlusion_rays");
    scene_buffers().bind(generate);
    generate.global(pixels())
        .arg("points", gbuffer_->points())
        .arg("count", pixels())
        .arg("sample_index", sample_index_)
        .arg("seed", seed_)
        .arg("reach", parameters_.distance * scene().bounds().radius())
        .arg("rays", rays);
    bvh().record_any(recorder, "occlusion rays", {rays, count_, 0, pixels()}, occluded);
    recorder.pass("add open rays", program_, "add_open_rays")
        .global(pixels())
        .arg("count", pixels())
        .arg("occluded", occluded)
        .arg("open", sums_["ambient_occlusion"]);
    schedule_ = recorder.compile();
  }

  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  LayerSums sums_;               ///< per pixel: rays that met nothing
  TypedBuffer<uint32_t> count_;  ///< one element: rays of a pass, as the intersector takes it
  Schedule schedule_;
  Variable<uint32_t> sample_index_, seed_;
};

std::unique_ptr<Technique> create_technique() { return std::make_unique<AmbientOcclusion>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(describe_technique, create_technique)
