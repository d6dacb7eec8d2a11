// SPDX-License-Identifier: Apache-2.0
//
// my_technique: direct light
// --------------------------
//
// Idea. Per iteration and pixel: find the point that the pixel sees (G-buffer; mirrors and clear glass are looked
// through), sample the light that reaches it once (DirectLight), and add what the camera sees emit with a
// kernel of our own, add_emission.cl. Replace this by your idea, its equations, and the paper they come from.
//
// What is counted. Layers `emission` and `direct`; no indirect light, whatever --max-bounces says. path_set() below
// says the same to the program, which renders the reference of a comparison with exactly those paths.
//
// Error. Unbiased: the mean over the samples converges to the reference.
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/direct_light/direct_light.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/services/layer_sums/layer_sums.h"
#include "lucarium/technique/plugin.h"
#include "lucarium/technique/technique_base.h"

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
    v.flag("emission", emission, "compute the layer emission (lamps and sky that the camera sees)");
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

class Renderer : public TechniqueBase<Options> {
 public:
  PathSet path_set(const Scene&, const RenderSettings&) const override {
    PathSet set;
    set.emission = parameters_.emission;
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
           LayerSums::estimate_bytes(pixels, 2);
  }

 protected:
  /// Once, for all scenes.
  void compile() override { program_ = make_program(device(), my_technique_kernels(), {"my_technique/add_emission"}); }

  /// Everything that refers to the scene's buffers. Called again when they may have been replaced.
  void build() override {
    schedule_ = {};  // what refers to memory goes before the memory
    direct_light_.reset();
    gbuffer_.reset();
    gbuffer_ = std::make_unique<GBuffer>(device(), scheduler(), scene_buffers(), bvh(), frame(), owner);
    direct_light_ = std::make_unique<DirectLight>(device(), scheduler(), scene_buffers(), bvh(), owner);
    sums_ = LayerSums(device(), owner, pixels(), layers());
    if (!parameters_.emission) return;

    // Arguments are bound by name; what a kernel reads and writes follows from its signature.
    ScheduleRecorder recorder = scheduler().record("add emission", owner);
    recorder.pass("add emission", program_, "add_emission")
        .global(pixels())
        .arg("points", gbuffer_->points())
        .arg("count", pixels())
        .arg("emission", sums_["emission"]);
    schedule_ = recorder.compile();
  }

  /// From zero samples, with the present camera and seed.
  void restart() override {
    gbuffer_->set_frame(frame());
    sums_.clear();
  }

  /// One sample per pixel, or none at all: false when cancelled, and the sums are then as before.
  bool step() override {
    const auto index = static_cast<uint32_t>(samples());
    if (!gbuffer_->render(index)) return false;
    if (!direct_light_->accumulate_radiance(gbuffer_->points(), sums_["direct"], index, seed())) return false;
    if (schedule_) scheduler().run_to_end(schedule_);  // both sums hold the same samples, also after Ctrl-C
    return true;
  }

  void write(Film& film) override { sums_.write(film); }

  void warm_up_kernels() override {
    gbuffer_->warm_up();
    direct_light_->warm_up(gbuffer_->points(), sums_["direct"]);
    if (schedule_) scheduler().warm_up(schedule_);
  }

 private:
  std::vector<std::string> layers() const {
    return parameters_.emission ? std::vector<std::string>{"emission", "direct"} : std::vector<std::string>{"direct"};
  }

  Program program_;
  std::unique_ptr<GBuffer> gbuffer_;
  std::unique_ptr<DirectLight> direct_light_;
  LayerSums sums_;
  Schedule schedule_;  ///< empty with emission=off
};

std::unique_ptr<Technique> create_technique() { return std::make_unique<Renderer>(); }

}  // namespace

LUCARIUM_EXPORT_TECHNIQUE(describe_technique, create_technique)
