// SPDX-License-Identifier: Apache-2.0
//
// ambient_occlusion: how open to its surroundings a surface point is
// ------------------------------------------------------------------
//
// Idea. The openness of a point x with normal n is
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
#include <algorithm>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/shared/ray.h"
#include "lucarium/technique/plugin.h"

const lucarium::EmbeddedSources& ambient_occlusion_kernels();

namespace {
using namespace lucarium;

// ---- options

struct AmbientOcclusionParameters {
  float distance = 0.25f;

  template <class V>
  void describe(V& v) {
    v.number("distance", distance, 1e-6f, 1e6f, "scene radii", "what lies farther away does not occlude");
  }
};

// ---- what it reads and writes

TechniqueInfo ambient_occlusion_info() {
  TechniqueInfo info;
  info.name = "ambient_occlusion";
  info.version = "1.0";
  info.summary = "openness of every visible point within a distance; no light";
  info.citation = "S. Zhukov, A. Iones and G. Kronin, An Ambient Light Illumination Model, Rendering Techniques 1998";
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.layers = {"ambient_occlusion"};
  return info;
}

// ---- code

class AmbientOcclusion : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings&) const override { return PathSet::no_light_transport(); }

  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override {
    return {"it shows openness, not light"};
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    const size_t pixels = size_t{settings.width} * settings.height;
    return GBuffer::estimate_bytes(settings.width, settings.height) +
           pixels * (sizeof(Ray) + sizeof(uint32_t) + sizeof(float));
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    SourceLibrary library;
    library.add(ambient_occlusion_kernels());
    program_ = Program(*context.device, library, {"ambient_occlusion", {"ambient_occlusion/occlusion.cl"}, {}});
    build();
  }

  void update(const SceneChange& change) override {
    if (change.only_camera()) {
      gbuffer_->set_frame(make_frame(context_->settings));
      restart();
    } else if (change.any()) {
      build();  // buffers of scene and hierarchy may have been replaced
    }
  }

  IterationResult iterate() override {
    const auto sample = static_cast<uint32_t>(samples_);
    schedule_.set(sample_index_, sample);
    schedule_.set(seed_, kernel_seed(seed_value_));
    // The sums change in the last pass alone, so that a cancelled iteration leaves them as they were.
    if (gbuffer_->render(sample) && context_->scheduler.run(schedule_) == RunResult::done) ++samples_;
    IterationResult result;
    result.progress = -1;
    result.samples = samples_;
    result.phase = "occlusion";
    return result;
  }

  void resolve(Film& film) override {
    context_->scheduler.finish();
    const std::vector<float> open = open_.download();
    const float samples = static_cast<float>(std::max<uint64_t>(samples_, 1));
    FilmLayer& layer = film.layer("ambient_occlusion", {"R", "G", "B"}, true);
    for (size_t i = 0; i < open.size(); ++i) std::fill_n(layer.pixels.begin() + 3 * i, 3, open[i] / samples);
  }

  void reset(uint64_t seed) override {
    seed_value_ = seed;
    Frame frame = make_frame(context_->settings);
    frame.seed = kernel_seed(seed);
    gbuffer_->set_frame(frame);
    restart();
  }

  void warm_up() override {
    gbuffer_->warm_up();
    context_->scheduler.warm_up(schedule_);
  }

 private:
  void build() {
    Device& device = *context_->device;
    schedule_ = {};  // what refers to memory goes before the memory
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device, context_->scheduler, context_->scene_buffers, context_->bvh(),
                                         make_frame(context_->settings), "ambient_occlusion");
    const uint32_t pixels = context_->settings.width * context_->settings.height;
    open_ = TypedBuffer<float>(device, "ambient_occlusion", "open rays", pixels, "lower --size");
    count_ = TypedBuffer<uint32_t>(device, "ambient_occlusion", "pixels", std::vector<uint32_t>{pixels});
    record(pixels);
    reset(context_->settings.seed);
  }

  void record(uint32_t pixels) {
    ScheduleRecorder recorder = context_->scheduler.record("occlusion", "ambient_occlusion");
    sample_index_ = recorder.variable("sample_index", 0u);
    seed_ = recorder.variable("seed", 0u);
    const BufferRef rays = recorder.transient<Ray>("occlusion rays", pixels, "lower --size");
    const BufferRef occluded = recorder.transient<uint32_t>("occluded", pixels, "lower --size");
    PassBuilder generate = recorder.pass("generate occlusion rays", program_, "generate_occlusion_rays");
    context_->scene_buffers.bind(generate, program_, "generate_occlusion_rays");
    generate.global(pixels)
        .arg("points", gbuffer_->points())
        .arg("count", pixels)
        .arg("sample_index", sample_index_)
        .arg("seed", seed_)
        .arg("reach", parameters_.distance * context_->scene.bounds().radius())
        .arg("rays", rays);
    context_->bvh().record_any(recorder, "occlusion rays", rays, occluded, count_, 0, pixels);
    recorder.pass("add open rays", program_, "add_open_rays")
        .global(pixels)
        .arg("count", pixels)
        .arg("occluded", occluded)
        .arg("open", open_);
    schedule_ = recorder.compile();
  }

  void restart() {
    samples_ = 0;
    open_.fill_zero();
  }

  AmbientOcclusionParameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  std::unique_ptr<TechniqueContext> context_;
  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  TypedBuffer<float> open_;      ///< per pixel: rays that met nothing
  TypedBuffer<uint32_t> count_;  ///< one element: rays of a pass, as the intersector wants it
  Schedule schedule_;
  Variable<uint32_t> sample_index_, seed_;
  uint64_t samples_ = 0, seed_value_ = 1;
};

std::unique_ptr<Technique> create_ambient_occlusion() { return std::make_unique<AmbientOcclusion>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(ambient_occlusion_info, create_ambient_occlusion)
