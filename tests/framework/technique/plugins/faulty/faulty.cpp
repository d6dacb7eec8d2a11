// SPDX-License-Identifier: Apache-2.0
//
// faulty: a path tracer that breaks one promise at a time
//
// With fault=none and gain=1 it is right. Each other value of `fault` breaks what one check of the conformance kit
// looks at, so that the kit's own test can see every check fail; `late` breaks none, but begins late.
// FAULTY_DECLARATION and BIASED change what it declares.
#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"
#include "lucarium/services/path_integrator/path_integrator.h"
#include "lucarium/technique/plugin.h"

const lucarium::EmbeddedSources& faulty_kernels();

namespace lucarium {
namespace {

enum class Fault {
  none,
  undocumented,
  extra_layer,
  nan,
  unseeded,
  sticky_seed,
  resolve_counts,
  thread_count,
  rebuild,
  deaf,
  leak,
  understated,
  uncounted,
  slow,
  late,
  traces,
  deaf_to_cancel,
  outside,
  turned_sky,
  one_sided,
  no_coat
};

struct FaultyParameters {
  Fault fault = Fault::none;
  float gain = 1;
  float admits = -1;
  int unnamed = 0;

  template <class V>
  void describe(V& v) {
    v.choice("fault", fault,
             {{"none", Fault::none},
              {"undocumented", Fault::undocumented},
              {"extra_layer", Fault::extra_layer},
              {"nan", Fault::nan},
              {"unseeded", Fault::unseeded},
              {"sticky_seed", Fault::sticky_seed},
              {"resolve_counts", Fault::resolve_counts},
              {"thread_count", Fault::thread_count},
              {"rebuild", Fault::rebuild},
              {"deaf", Fault::deaf},
              {"leak", Fault::leak},
              {"understated", Fault::understated},
              {"uncounted", Fault::uncounted},
              {"slow", Fault::slow},
              {"late", Fault::late},
              {"traces", Fault::traces},
              {"deaf_to_cancel", Fault::deaf_to_cancel},
              {"outside", Fault::outside},
              {"turned_sky", Fault::turned_sky},
              {"one_sided", Fault::one_sided},
              {"no_coat", Fault::no_coat}},
             "promise that is broken");
    v.number("gain", gain, 0.f, 10.f, "", "factor on all light");
#if defined(BIASED)
    v.number("admits", admits, -1.f, 10.f, "", "bias that is admitted; -1: what is declared");
#endif
    if (fault == Fault::undocumented) v.number("unnamed", unnamed, 0, 1, "", "");
  }
};

TechniqueInfo faulty_info() {
  TechniqueInfo info;
  info.name = "faulty";
  info.version = "1.0";
  info.summary = "breaks one promise at a time, for tests";
  info.capabilities.lights = all_kinds<LightKind>();
  info.capabilities.materials = all_kinds<MaterialKind>();
  info.capabilities.changes = all_kinds<ChangeKind>();
  info.layers = {"emission", "direct", "indirect"};
#if defined(FAULTY_DECLARATION)
  info.name = "faulty_declaration";
  info.version = "";
  info.capabilities.lights.push_back(LightKind::point);  // twice
  info.check_parameters = {{"fault", "nan"}};
#elif defined(BIASED)
  info.name = "biased";
  info.capabilities.bias = 0.05;
#endif
  return info;
}

class Faulty : public Technique {
 public:
  ParameterTable& parameters() override {
    if (is(Fault::undocumented) && table_.entries().size() < 3) table_ = make_parameter_table(parameters_);
    return table_;
  }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set;
    set.max_bounces = settings.max_bounces;
    return set;
  }

  double admitted_bias(double declared) const override {
    return parameters_.admits < 0 ? declared : parameters_.admits;
  }

  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override { return {}; }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    return is(Fault::understated) ? 0 : PathIntegrator::estimate_bytes(settings.width, settings.height, {});
  }

  void prepare(const TechniqueContext& context) override {
    static std::atomic<uint64_t> instances{0};
    instance_ = ++instances;
    context_ = std::make_unique<TechniqueContext>(context);
    seed_ = context.settings.seed;
    make_integrator();
    if (is(Fault::leak)) leak();
    if (is(Fault::outside)) record_outside();
  }

  void update(const SceneChange& change) override {
    if (is(Fault::deaf)) return;
    if (change.only_camera() && !is(Fault::rebuild))
      integrator_->set_frame(make_frame(context_->settings));
    else
      make_integrator();
  }

  IterationResult iterate() override {
    if (is(Fault::slow)) std::this_thread::sleep_for(std::chrono::milliseconds(1300));
    if (outside_) context_->scheduler.run(outside_);
    if (is(Fault::late) && waited_ < late_iterations) return wait();
    if (!integrator_->iterate()) {
      if (is(Fault::traces)) trace_ *= 1.01f;
      if (is(Fault::deaf_to_cancel)) std::this_thread::sleep_for(std::chrono::milliseconds(1300));
    }
    IterationResult result;
    result.samples = is(Fault::uncounted) ? 0 : integrator_->samples();
    result.progress = -1;
    return result;
  }

  void resolve(Film& film) override {
    integrator_->resolve(film);
    float factor = parameters_.gain * trace_;
    if (is(Fault::resolve_counts)) factor *= 1 + 0.01f * static_cast<float>(resolves_++);
    if (is(Fault::thread_count)) factor *= 1 + 0.01f * static_cast<float>(context_->device->info().compute_units);
    for (const char* name : {"emission", "direct", "indirect"}) {
      for (float& value : film.layer(name, {"R", "G", "B"}, true).pixels) value *= factor;
    }
    if (is(Fault::nan)) film.layer("direct", {"R", "G", "B"}, true).pixels[7] = std::numeric_limits<float>::quiet_NaN();
    if (is(Fault::extra_layer)) film.layer("secret", {"Y"});
  }

  void reset(uint64_t seed) override {
    if (!is(Fault::sticky_seed)) seed_ = seed;
    integrator_->reset(used_seed());
  }

  void warm_up() override { integrator_->warm_up(); }

 private:
  static constexpr int late_iterations = 70;

  bool is(Fault fault) const { return parameters_.fault == fault; }
  uint64_t used_seed() const { return is(Fault::unseeded) ? seed_ + 1000 * instance_ : seed_; }

  /// An iteration of many without which there is no light; no fault.
  IterationResult wait() {
    IterationResult result;
    result.progress = 0.5 * ++waited_ / late_iterations;
    return result;
  }

  void make_integrator() {
    integrator_.reset();
    PathIntegratorOptions options;
    options.path_set = path_set(context_->scene, context_->settings);
    if (is(Fault::turned_sky) || is(Fault::one_sided) || is(Fault::no_coat)) make_wrong_scene();
    integrator_ = std::make_unique<PathIntegrator>(
        *context_->device, context_->scheduler, wrong_buffers_ ? *wrong_buffers_ : context_->scene_buffers,
        wrong_bvh_ ? *wrong_bvh_ : context_->bvh(), make_frame(context_->settings), options, "faulty");
    integrator_->reset(used_seed());
  }

  /// What a technique makes of a scene that takes the sky from the opposite direction, surfaces for one-sided, or the
  /// ideal lobe of a coat for nothing.
  void make_wrong_scene() {
    wrong_scene_ = context_->scene;
    if (is(Fault::turned_sky) && wrong_scene_.environment) wrong_scene_.environment->environment_from_world *= -1.f;
    for (SceneMaterial& material : wrong_scene_.materials) {
      if (is(Fault::one_sided)) material.double_sided = false;
      if (is(Fault::no_coat) && material.metallic == 0 && material.transmission == 0) material.ior = 1;
    }
    wrong_bvh_.reset();
    wrong_buffers_ = std::make_unique<SceneBuffers>(*context_->device, wrong_scene_);
    wrong_bvh_ = std::make_unique<Bvh>(*context_->device, wrong_scene_, *wrong_buffers_);
  }

  void leak() {
    static std::vector<Buffer> forgotten;
    forgotten.emplace_back(*context_->device, "faulty", "forgotten", 4096);
  }

  void record_outside() {
    SourceLibrary library;
    library.add(faulty_kernels());
    program_ = Program(*context_->device, library, {"faulty", {"faulty/write_outside.cl"}, {}});
    values_ = TypedBuffer<float>(*context_->device, "faulty", "values", 64);
    ScheduleRecorder recorder = context_->scheduler.record("outside", "faulty");
    recorder.pass("write outside", program_, "write_outside").global(64).arg("values", values_).arg("count", 64u);
    outside_ = recorder.compile();
  }

  FaultyParameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  std::unique_ptr<TechniqueContext> context_;
  uint64_t seed_ = 1, instance_ = 0;
  int resolves_ = 0, waited_ = 0;
  float trace_ = 1;
  Program program_;
  TypedBuffer<float> values_;
  Schedule outside_;
  Scene wrong_scene_;
  std::unique_ptr<SceneBuffers> wrong_buffers_;
  std::unique_ptr<Bvh> wrong_bvh_;
  std::unique_ptr<PathIntegrator> integrator_;
};

std::unique_ptr<Technique> create_faulty() { return std::make_unique<Faulty>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::faulty_info, lucarium::create_faulty)
