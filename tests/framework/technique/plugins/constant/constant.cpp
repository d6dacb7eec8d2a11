// SPDX-License-Identifier: Apache-2.0
//
// constant: a technique for tests of everything around techniques
//
// Every sample of every pixel is the colour given by its parameters, so that the image is known exactly. Further
// parameters make it slow, fail, or give a NaN at a chosen iteration.
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/technique/plugin.h"

const lucarium::EmbeddedSources& constant_kernels();

namespace lucarium {
namespace {

enum class Failure { none, error, exception, nan, negative };

struct ConstantParameters {
  float red = 0.25f, green = 0.5f, blue = 1;
  int sleep = 0, fail_at = 0, converge_at = 0;
  Failure failure = Failure::none;
  int extra_megabytes = 0;

  template <class V>
  void describe(V& v) {
    v.number("red", red, 0.f, 100.f, "cd/m²", "radiance of every pixel");
    v.number("green", green, 0.f, 100.f, "cd/m²", "radiance of every pixel");
    v.number("blue", blue, 0.f, 100.f, "cd/m²", "radiance of every pixel");
    v.number("sleep", sleep, 0, 60000, "ms", "pause in every iteration");
    v.number("converge_at", converge_at, 0, 1000000, "iterations",
             "iteration at which it reports convergence; 0: never");
    v.number("fail_at", fail_at, 0, 1000000, "iterations", "iteration at which `failure` happens");
    v.choice("failure", failure,
             {{"none", Failure::none},
              {"error", Failure::error},
              {"exception", Failure::exception},
              {"nan", Failure::nan},
              {"negative", Failure::negative}},
             "what goes wrong");
    v.number("extra_megabytes", extra_megabytes, 0, 1 << 30, "MB", "memory that it declares");
  }
};

TechniqueInfo constant_info() {
  TechniqueInfo info;
  info.name = "constant";
  info.version = "1.0";
  info.summary = "one colour everywhere, for tests";
  info.capabilities.lights = {LightKind::point};
  info.capabilities.changes = {ChangeKind::camera};
  info.capabilities.max_bounces = 3;
  info.capabilities.uses_bvh = false;
  info.layers = {"direct", "count"};
  return info;
}

class Constant : public Technique {
 public:
  ParameterTable& parameters() override { return table_; }

  PathSet path_set(const Scene&, const RenderSettings& settings) const override {
    PathSet set;
    set.max_bounces = settings.max_bounces;
    set.indirect = false;
    return set;
  }

  std::vector<std::string> limitations(const Scene&, const RenderSettings&) const override {
    return {"the scene is ignored"};
  }

  size_t estimate_bytes(const Scene&, const RenderSettings& settings) const override {
    return sizeof(glm::vec4) * settings.width * settings.height + (size_t(parameters_.extra_megabytes) << 20);
  }

  void prepare(const TechniqueContext& context) override {
    scheduler_ = &context.scheduler;
    pixels_ = context.settings.width * context.settings.height;
    sum_ = TypedBuffer<glm::vec4>(*context.device, "constant", "sum", pixels_);
    SourceLibrary library;
    library.add(constant_kernels());
    ProgramSpec spec;
    spec.name = "constant";
    spec.files = {"constant/fill_constant.cl"};
    program_ = Program(*context.device, library, spec);
    ScheduleRecorder recorder = context.scheduler.record("constant", "constant");
    const float4 colour(parameters_.red, parameters_.green, parameters_.blue, 0);
    recorder.pass("fill", program_, "fill_constant")
        .global(pixels_)
        .arg("sum", sum_)
        .arg("colour", colour)
        .arg("pixels", pixels_);
    schedule_ = recorder.compile();
  }

  void update(const SceneChange&) override { restart(); }

  IterationResult iterate() override {
    std::this_thread::sleep_for(std::chrono::milliseconds(parameters_.sleep));
    if (samples_ + 1 == static_cast<uint64_t>(parameters_.fail_at)) fail();
    if (scheduler_->run(schedule_) == RunResult::done) ++samples_;  // else cancelled, as if it had not begun
    IterationResult result;
    result.samples = samples_;
    result.converged = samples_ == static_cast<uint64_t>(parameters_.converge_at);
    result.progress = parameters_.converge_at > 0 ? static_cast<double>(samples_) / parameters_.converge_at : -1;
    result.phase = result.converged ? "converge_at is reached" : "fill";
    return result;
  }

  void resolve(Film& film) override {
    scheduler_->finish();
    const std::vector<glm::vec4> sum = sum_.download();
    const float count_of_samples = samples_ ? static_cast<float>(samples_) : 1.f;  // division is exact, unlike 1/n
    FilmLayer& direct = film.layer("direct", {"R", "G", "B"}, true);
    FilmLayer& count = film.layer("count", {"Y"});
    for (size_t p = 0; p < sum.size(); ++p) {
      for (size_t c = 0; c < 3; ++c) direct.pixels[3 * p + c] = sum[p][static_cast<int>(c)] / count_of_samples;
      count.pixels[p] = static_cast<float>(samples_);
    }
    if (bad_ != 0) direct.pixels[3 * (film.width() + 1)] = bad_;
  }

  InspectedValues inspect(const SeenPoint& point) const override {
    return {{"colour", fmt::format("{} {} {}", parameters_.red, parameters_.green, parameters_.blue)},
            {"seen at", fmt::format("{} {} of triangle {}", point.x, point.y, point.triangle)}};
  }

  void reset(uint64_t) override { restart(); }
  void warm_up() override { scheduler_->warm_up(schedule_); }
  std::map<std::string, double> counters() const override { return {{"samples", static_cast<double>(samples_)}}; }

 private:
  void fail() {
    switch (parameters_.failure) {
      case Failure::none: break;
      case Failure::error: throw_error(ErrorClass::technique, "it fails as requested");
      case Failure::exception: throw std::runtime_error("an exception that is no Error");
      case Failure::nan: bad_ = std::numeric_limits<float>::quiet_NaN(); break;
      case Failure::negative: bad_ = -1; break;
    }
  }

  void restart() {
    samples_ = 0;
    sum_.fill_zero();
  }

  ConstantParameters parameters_;
  ParameterTable table_ = make_parameter_table(parameters_);
  KernelScheduler* scheduler_ = nullptr;
  uint32_t pixels_ = 0;
  TypedBuffer<glm::vec4> sum_;
  Program program_;
  Schedule schedule_;
  uint64_t samples_ = 0;
  float bad_ = 0;
};

std::unique_ptr<Technique> constant_create() { return std::make_unique<Constant>(); }

}  // namespace
}  // namespace lucarium

LUCARIUM_EXPORT_TECHNIQUE(lucarium::constant_info, lucarium::constant_create)
