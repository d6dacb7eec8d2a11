// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/truth/growing_reference.h"

#include <cmath>
#include <numeric>

#include "lucarium/base/hash.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/compare/reference/reference_image.h"
#include "lucarium/film/exposure.h"

namespace lucarium {

namespace {

constexpr uint64_t replicates = 16;           // sample sets: each has a sample before the first image is taken
constexpr uint64_t max_samples = 1ull << 20;  // per pixel; far below what a picture can show

/// The samples are never those of a picture: with the same seed its noise would be the reference's.
RenderSettings reference_settings(RenderSettings settings, const PathSet& paths) {
  settings.max_bounces = paths.max_bounces;  // a technique may have fewer than are asked for
  settings.seed = Hasher().add(settings.seed).add(uint64_t{1}).finish().low;
  return settings;
}

/// Small iterations: the device is shared with what is being watched.
std::vector<std::pair<std::string, std::string>> parameters_of(const PathSet& paths) {
  std::vector<std::pair<std::string, std::string>> parameters = paths.technique_parameters();
  parameters.emplace_back("replicates", std::to_string(replicates));
  return parameters;
}

}  // namespace

GrowingReference::GrowingReference(std::shared_ptr<Device> device, std::shared_ptr<SceneOnDevice> scene,
                                   const TechniqueType& type, const RenderSettings& settings, const PathSet& paths,
                                   RenderSession::OnPreparing on_preparing, std::function<bool()> unwanted)
    : session_(std::move(device), std::move(scene), type, reference_settings(settings, paths), parameters_of(paths),
               std::move(on_preparing)),
      own_relmse_(NAN) {
  session_.scheduler().set_cancel([unwanted = std::move(unwanted)] { return interrupt_requested() || unwanted(); });
}

bool GrowingReference::has_work() const { return !session_.last().converged && samples() < max_samples; }

void GrowingReference::work() {
  session_.iterate();
  if (samples() >= std::max(replicates, 2 * measured_samples_)) replace_image();
}

void GrowingReference::replace_image() {
  const Film film = session_.resolve();
  image_ = film.image();
  metrics_ = std::make_unique<MetricReference>(film.width(), film.height(), image_, MetricOptions{0, false});
  const FlipView view{automatic_exposure(image_), false};
  flip_ = std::make_unique<FlipReference>(film.width(), film.height(), image_, std::vector<FlipView>{view});
  ReferenceError own;
  own_relmse_ = estimate_reference_error(film, own) ? own.relmse : NAN;
  measured_samples_ = samples();
}

double GrowingReference::relmse(const std::vector<float>& image) const { return metrics_->relmse(image); }

double GrowingReference::flip(const std::vector<float>& image) const {
  const std::vector<float> map = flip_->error_map(image);
  return std::accumulate(map.begin(), map.end(), 0.0) / static_cast<double>(map.size());
}

/// A picture that is off by one standard deviation everywhere has the expected squared error.
double GrowingReference::noise(const std::vector<float>& variance) const {
  std::vector<float> off = image_;
  for (size_t i = 0; i < off.size(); ++i) off[i] += std::sqrt(variance[i]);
  return relmse(off);
}

}  // namespace lucarium
