// SPDX-License-Identifier: Apache-2.0
#include "lucarium/technique/technique_base.h"

#include "lucarium/base/error.h"
#include "lucarium/services/bvh/bvh.h"

namespace lucarium {

void TechniqueLifeCycle::prepare(const TechniqueContext& context) {
  context_ = std::make_unique<TechniqueContext>(context);
  seed_ = context.settings.seed;
  compile();
  rebuild();
}

void TechniqueLifeCycle::rebuild() {
  attempt([&] {
    built_ = held_ = resting_ = false;
    build();
    scene_generation_ = scene_buffers().generation();
    if (uses_bvh_) bvh_generation_ = bvh().generation();
    samples_ = 0;
    restart();
    built_ = true;
    interrupted_ = false;
  });
}

void TechniqueLifeCycle::restart_samples() {
  attempt([&] {
    samples_ = 0;
    restart();
  });
}

void TechniqueLifeCycle::attempt(const std::function<void()>& part) {
  try {
    part();
  } catch (const Error& error) {
    built_ = false;
    interrupted_ = error.error_class() == ErrorClass::interrupted;
    throw;
  } catch (...) {
    built_ = interrupted_ = false;
    throw;
  }
}

void TechniqueLifeCycle::update(const SceneChange& change) {
  if (!change.any()) return;
  try {
    attempt([&] {  // what follow() began is not whole either
      if (!follow(change) || !built_) rebuild();
    });
  } catch (const Error&) {
    if (!interrupted_) throw;
  }
}

bool TechniqueLifeCycle::follow(const SceneChange& change) {
  if (!built_ || !change.only_camera()) return false;
  restart_samples();
  return true;
}

IterationResult TechniqueLifeCycle::iterate() {
  if (!built_) rebuild();  // the last attempt failed
  if (step()) ++samples_;
  return state();
}

IterationResult TechniqueLifeCycle::state() const {
  IterationResult result;
  result.samples = samples_;
  result.progress = -1;
  return result;
}

void TechniqueLifeCycle::resolve(Film& film) {
  if (!built_ && interrupted_)
    throw Error(ErrorClass::interrupted, "interrupted while applying the last change of the scene; there is no image");
  if (!built_) throw Error(ErrorClass::input, "the last change of the scene could not be applied; there is no image");
  scheduler().finish();
  write(film);
}

void TechniqueLifeCycle::reset(uint64_t seed) {
  seed_ = seed;
  held_ = resting_ = false;
  built_ ? restart_samples() : rebuild();
}

void TechniqueLifeCycle::warm_up() {
  if (!built_) rebuild();
  warm_up_kernels();
}

void TechniqueLifeCycle::save_state(StateWriter& chunks) {
  if (!built_) throw Error(ErrorClass::input, "the last change of the scene could not be applied; there is no state");
  scheduler().finish();
  save(chunks);
}

void TechniqueLifeCycle::load_state(const StateReader& chunks) {
  if (!built_) rebuild();
  attempt([&] { load(chunks); });
  context_->state = nullptr;
  held_ = true;
}

void TechniqueLifeCycle::save(StateWriter& chunks) { Technique::save_state(chunks); }

void TechniqueLifeCycle::load(const StateReader& chunks) { Technique::load_state(chunks); }

bool TechniqueLifeCycle::buffers_replaced() const {
  return scene_generation_ != scene_buffers().generation() ||
         (uses_bvh_ && bvh_generation_ != context_->bvh().generation());
}

Bvh& TechniqueLifeCycle::bvh() {
  uses_bvh_ = true;
  return context_->bvh();
}

Frame TechniqueLifeCycle::frame() const {
  Frame frame = make_frame(settings());
  frame.seed = seed();
  return frame;
}

}  // namespace lucarium
