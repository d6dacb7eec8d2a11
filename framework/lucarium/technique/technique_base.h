// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "lucarium/technique/technique.h"
#include "lucarium/technique/technique_state.h"

namespace lucarium {

/// Behaviour that most techniques share. It keeps context and seed; builds everything that refers to the scene's
/// buffers, and builds it again after a change that cannot be followed or where the last attempt failed; and counts no
/// sample that was cancelled. Optional: the framework asks for a Technique only.
class TechniqueLifeCycle : public Technique {
 public:
  void prepare(const TechniqueContext& context) override;
  /// When interrupted while building, it leaves that to the next iterate(): there is no image until then.
  void update(const SceneChange& change) override;
  IterationResult iterate() override;
  void resolve(Film& film) override;
  void reset(uint64_t seed) override;
  void warm_up() override;
  void hold_light() override { held_ = true; }
  void rest_light(bool rests) override { resting_ = rests; }
  void save_state(StateWriter& chunks) override;
  void load_state(const StateReader& chunks) override;

 protected:
  /// Compiles programs that all scenes share. Called once, before the first build().
  virtual void compile() {}
  /// Builds everything that refers to the scene's buffers, after releasing the old. May throw: built() is false then,
  /// and the next call of the framework tries again.
  virtual void build() = 0;
  /// Follows a change of the scene without build(), false where that is not possible. By default a change of the
  /// camera alone is one that restart() follows. Called for every change, also while built() is false; build() comes
  /// behind it then, whatever it returns.
  virtual bool follow(const SceneChange& change);
  /// Goes back to zero samples, with the present camera and seed. Comes behind build().
  virtual void restart() = 0;
  /// One iteration. False when it was cancelled or has not completed a sample: none is counted then, and write() shows
  /// what it would have shown before. To have that, add to sums in one go, in a schedule that run_to_end() runs.
  virtual bool step() = 0;
  /// Writes the layers; nothing runs on the device meanwhile.
  virtual void write(Film& film) = 0;
  /// Launches every kernel once (Technique::warm_up).
  virtual void warm_up_kernels() = 0;
  /// Progress after an iteration; by default samples() of an unknown number.
  virtual IterationResult state() const;
  /// What does not depend on the camera, of techniques whose state_refusal() is empty: put, and, between build() with
  /// restart() and the first step(), taken.
  virtual void save(StateWriter& chunks);
  virtual void load(const StateReader& chunks);

  /// The same for follow(), which has no more to do.
  void restart_samples();

  bool built() const { return built_; }
  /// What does not depend on the camera stays as it is (Technique::hold_light, rest_light).
  bool light_held() const { return held_ || resting_; }
  bool light_rests() const { return resting_; }
  uint64_t samples() const { return samples_; }  ///< steps that were completed since restart()
  /// Whether buffers of the scene or of its hierarchy were replaced since build(), so that schedules that name them
  /// must be recorded again.
  bool buffers_replaced() const;

  const TechniqueContext& context() const { return *context_; }
  Device& device() const { return *context_->device; }
  KernelScheduler& scheduler() const { return context_->scheduler; }
  const Scene& scene() const { return context_->scene; }
  const SceneBuffers& scene_buffers() const { return context_->scene_buffers; }
  const RenderSettings& settings() const { return context_->settings; }
  /// The scene's hierarchy. The framework keeps it up to date.
  Bvh& bvh();
  uint32_t pixels() const { return settings().width * settings().height; }
  /// The 32 bits of the seed that kernels get.
  uint32_t seed() const { return kernel_seed(seed_); }
  uint64_t full_seed() const { return seed_; }
  /// The settings as kernels see them, with the present camera and seed.
  Frame frame() const;

 private:
  void rebuild();
  /// Runs a part of the life cycle. Where it throws, nothing is built any more, and why is remembered.
  void attempt(const std::function<void()>& part);
  std::unique_ptr<TechniqueContext> context_;
  uint64_t seed_ = 1, samples_ = 0;
  bool built_ = false, uses_bvh_ = false, held_ = false, resting_ = false;
  bool interrupted_ = false;                            ///< that is why it is not built
  uint64_t scene_generation_ = 0, bvh_generation_ = 0;  ///< at build()
};

/// The same with the technique's parameters: plain data with a describe() (technique/parameters.h).
template <class Parameters>
class TechniqueBase : public TechniqueLifeCycle {
 public:
  ParameterTable& parameters() override { return table_; }

 protected:
  Parameters parameters_;

 private:
  ParameterTable table_ = make_parameter_table(parameters_);
};

}  // namespace lucarium
