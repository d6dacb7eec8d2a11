// SPDX-License-Identifier: Apache-2.0
//
// my_technique: direct light
// --------------------------
//
// Idea. Per iteration and pixel: find the point that the pixel sees (G-buffer; mirrors and clear glass are looked
// through), sample the light that reaches it once (DirectLight), and add what the eye sees shine by itself with a
// kernel of our own, add_emission.cl. Replace this by your idea, its equations, and the paper they come from.
//
// What is counted. Layers `emission` and `direct`; no indirect light, whatever --max-bounces says. path_set() below
// says the same to the program, which renders the reference of a comparison with exactly those paths.
//
// Error. Unbiased: the mean over the samples converges to the reference.
#include <algorithm>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/technique/plugin.h"

/// The .cl files of this folder, embedded at build time under the names my_technique/….cl.
const lucarium::EmbeddedSources& my_technique_kernels();

namespace {
using namespace lucarium;

const char* const owner = "my_technique";  // pays for the memory in the account of the device

// ---- options: name, default, range, unit and meaning, each said once

struct Options {
  bool emission = true;

  template <class V>
  void describe(V& v) {
    v.flag("emission", emission, "compute the layer emission: lamps and sky as the eye sees them");
  }
};

// ---- what it can do: `lucarium check` tests every claim

TechniqueInfo describe_technique() {
  TechniqueInfo info;
  info.name = "my_technique";
  info.version = "0.1";
  info.summary = "direct light, one light sample and one BSDF sample per iteration and pixel";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = {MaterialKind::diffuse, MaterialKind::glossy, MaterialKind::mirror,
                                 MaterialKind::mask,    MaterialKind::blend,  MaterialKind::normal_map};
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.layers = {"emission", "direct"};
  return info;
}

// ---- code

class Renderer : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings&) const override {
    PathSet set;
    set.emission = options_.emission;
    set.indirect = false;
    set.max_bounces = 0;
    return set;
  }

  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override {
    return {"it computes direct light only"};
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    const size_t pixels = size_t{settings.width} * settings.height;
    return GBuffer::estimate_bytes(settings.width, settings.height) + DirectLight::estimate_bytes(pixels) +
           2 * pixels * sizeof(float4);
  }

  void prepare(const TechniqueContext& context) override {
    context_ = std::make_unique<TechniqueContext>(context);
    SourceLibrary library;
    library.add(my_technique_kernels());
    program_ = Program(*context.device, library, {owner, {"my_technique/add_emission.cl"}, {}});
    build();
  }

  void update(const SceneChange& change) override {
    if (change.only_camera()) {
      restart();  // nothing here depends on the view but the G-buffer
    } else if (change.any()) {
      build();  // buffers of the scene and its hierarchy may have been replaced
    }
  }

  IterationResult iterate() override {
    if (add_sample()) ++samples_;
    IterationResult result;
    result.samples = samples_;
    result.progress = -1;  // how much there is to do is unknown
    result.phase = "sample";
    return result;
  }

  void resolve(Film& film) override {
    context_->scheduler.finish();
    if (options_.emission) write_layer(film, "emission", emission_.download());
    write_layer(film, "direct", direct_.download());
  }

  void reset(uint64_t seed) override {
    seed_ = seed;
    restart();
  }

  void warm_up() override {
    gbuffer_->warm_up();
    direct_light_->warm_up(gbuffer_->points(), direct_);
    context_->scheduler.warm_up(schedule_);
  }

 private:
  /// One sample per pixel, or none at all: false when cancelled, and the sums are then as before.
  bool add_sample() {
    const auto index = static_cast<uint32_t>(samples_);
    if (!gbuffer_->render(index)) return false;
    if (!direct_light_->accumulate_radiance(gbuffer_->points(), direct_, index, kernel_seed(seed_))) return false;
    context_->scheduler.run_to_end(schedule_);  // both sums hold the same samples, also after Ctrl-C
    return true;
  }

  /// Everything that refers to the scene's buffers.
  void build() {
    Device& device = *context_->device;
    schedule_ = {};  // what refers to memory goes before the memory
    direct_light_.reset();
    gbuffer_.reset();
    const uint32_t pixels = context_->settings.width * context_->settings.height;
    gbuffer_ = std::make_unique<GBuffer>(device, context_->scheduler, context_->scene_buffers, context_->bvh(),
                                         make_frame(context_->settings), owner);
    direct_light_ =
        std::make_unique<DirectLight>(device, context_->scheduler, context_->scene_buffers, context_->bvh(), owner);
    emission_ = TypedBuffer<float4>(device, owner, "emission", pixels, "lower --size");
    direct_ = TypedBuffer<float4>(device, owner, "direct light", pixels, "lower --size");

    // Arguments are bound by name; what a kernel reads and writes follows from its signature.
    ScheduleRecorder recorder = context_->scheduler.record("add emission", owner);
    recorder.pass("add emission", program_, "add_emission")
        .global(pixels)
        .arg("points", gbuffer_->points())
        .arg("count", pixels)
        .arg("emission", emission_);
    schedule_ = recorder.compile();
    reset(context_->settings.seed);
  }

  /// From zero samples, with the present camera and seed.
  void restart() {
    Frame frame = make_frame(context_->settings);
    frame.seed = kernel_seed(seed_);
    gbuffer_->set_frame(frame);
    samples_ = 0;
    emission_.fill_zero();
    direct_.fill_zero();
  }

  void write_layer(Film& film, const char* name, const std::vector<float4>& sums) const {
    const float samples = static_cast<float>(std::max<uint64_t>(samples_, 1));
    FilmLayer& layer = film.layer(name, {"R", "G", "B"}, true);  // part of the sum that is the image
    for (size_t i = 0; i < sums.size(); ++i) {
      layer.pixels[3 * i] = sums[i].x / samples;
      layer.pixels[3 * i + 1] = sums[i].y / samples;
      layer.pixels[3 * i + 2] = sums[i].z / samples;
    }
  }

  Options options_;
  ParameterTable table_ = make_parameter_table(options_);
  std::unique_ptr<TechniqueContext> context_;
  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  std::unique_ptr<DirectLight> direct_light_;
  TypedBuffer<float4> emission_, direct_;  ///< sums per pixel [cd/m²]
  Schedule schedule_;
  uint64_t samples_ = 0, seed_ = 1;
};

std::unique_ptr<Technique> create_technique() { return std::make_unique<Renderer>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(describe_technique, create_technique)
