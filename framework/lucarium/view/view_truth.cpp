// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/view_truth.h"

#include <algorithm>
#include <cmath>

#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/technique/plugin.h"

namespace lucarium {

using nlohmann::ordered_json;

namespace {

constexpr size_t max_references = 3;  // sets of light paths at once: each has buffers of its own

}  // namespace

ViewTruth::ViewTruth(ViewSurroundings& around, const TechniqueRegistry& registry, std::function<bool()> unwanted)
    : around_(around), registry_(registry), unwanted_(std::move(unwanted)) {}

void ViewTruth::begin(std::shared_ptr<SceneOnDevice> scene) {
  scene_ = std::move(scene);
  references_.clear();
  obstacles_.clear();
  obstacle_.clear();
  history_ = {};
  spent_ = 0;
}

void ViewTruth::switch_to(bool on) {
  if (on_ && !on) begin();
  on_ = on;
}

/// Why there is none; empty: there is.
std::string ViewTruth::start(const PathSet& paths, const std::string& text) {
  if (!paths.light_transport()) return "what this technique shows is not light: there is no reference of it";
  if (references_.size() >= max_references) return "there are references of three other sets of light paths already";
  try {
    references_[text] =
        std::make_unique<GrowingReference>(around_.device, scene_, registry_.find("path_tracing"), around_.settings,
                                           paths, RenderSession::OnPreparing{}, unwanted_);
    return {};
  } catch (const Error& error) {
    references_.erase(text);
    return error.what();
  }
}

bool ViewTruth::watch(ViewSide& side) {
  RenderSession* const session = side.whole();
  if (!on_ || !session || session->last().samples == 0 || session->iterations() == 0) return false;
  const PathSet paths =
      session->technique().path_set(session->scene(), session->settings()).simplified(session->scene());
  const std::string text = paths.to_string();
  if (!references_.contains(text) && !obstacles_.contains(text)) {
    const std::string obstacle = start(paths, text);
    if (!obstacle.empty()) obstacles_[text] = obstacle;
  }
  const auto found = obstacles_.find(text);
  const std::string before = std::exchange(obstacle_, found == obstacles_.end() ? "" : found->second);
  if (!obstacle_.empty()) return before != obstacle_;
  const double seconds = side.seconds();
  if (history_.wants(side.technique(), seconds, side.stage() == ViewSide::Stage::done)) {
    Film film(session->settings().width, session->settings().height);
    session->technique().resolve(film);  // unchecked: pages see pixels that are no numbers, too
    history_.keep(side.technique(), text, seconds, session->last().samples, film);
  }
  return false;
}

GrowingReference* ViewTruth::next() const {
  GrowingReference* next = nullptr;
  for (const auto& [paths, reference] : references_)
    if (reference->has_work() && (!next || reference->samples() < next->samples())) next = reference.get();
  return next;
}

bool ViewTruth::has_work() const { return on_ && next(); }

void ViewTruth::work() {
  const Stopwatch watch;
  try {
    const bool measured = std::any_of(references_.begin(), references_.end(), [&](const auto& entry) {
      return history_.measure_one(entry.first, *entry.second);
    });
    GrowingReference* const reference = measured ? nullptr : next();
    if (reference) reference->work();
  } catch (const Error& error) {  // what is being watched goes on
    begin();
    on_ = false;
    obstacle_ = error.what();
  }
  spent_ += watch.seconds();
}

ordered_json ViewTruth::status() const {
  ordered_json status = {{"on", on_}, {"obstacle", obstacle_}, {"references", ordered_json::array()}};
  for (const auto& [paths, reference] : references_) {
    const double own = reference->own_relmse();
    status["references"].push_back({{"paths", paths},
                                    {"samples", reference->samples()},
                                    {"measured", reference->measured_samples()},
                                    {"relmse", std::isfinite(own) ? ordered_json(own) : ordered_json(nullptr)}});
  }
  status["curves"] = history_.describe();
  return status;
}

}  // namespace lucarium
