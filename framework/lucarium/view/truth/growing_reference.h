// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "lucarium/metrics/metrics.h"
#include "lucarium/session/session.h"

namespace lucarium {

/// A reference of certain light paths at the present view, by path_tracing, that grows iteration by iteration. Errors
/// are measured against its image at the last doubling of its samples, so that those of one time can be compared.
class GrowingReference {
 public:
  /// `settings`: those of the pictures; the samples are others. `unwanted`: asked between passes.
  GrowingReference(std::shared_ptr<Device> device, std::shared_ptr<SceneOnDevice> scene, const TechniqueType& type,
                   const RenderSettings& settings, const PathSet& paths, RenderSession::OnPreparing on_preparing,
                   std::function<bool()> unwanted);

  /// An iteration; at twice the samples the image that errors are measured against is replaced.
  void work();
  /// Whether more samples are of use.
  bool has_work() const;

  uint64_t samples() const { return session_.last().samples; }
  uint64_t measured_samples() const { return measured_samples_; }  ///< of that image; 0: there is none
  double own_relmse() const { return own_relmse_; }                ///< of that image; NaN: unknown
  /// relMSE of an RGB image of its size.
  double relmse(const std::vector<float>& image) const;
  /// Mean LDR-FLIP, at the reference's exposure.
  double flip(const std::vector<float>& image) const;
  /// relMSE that pixels of that variance make. Relative to the reference, as relmse(): a picture of few samples has its
  /// noise where it is brightest.
  double noise(const std::vector<float>& variance) const;

 private:
  void replace_image();

  RenderSession session_;
  uint64_t measured_samples_ = 0;
  double own_relmse_;
  std::vector<float> image_;
  std::unique_ptr<MetricReference> metrics_;
  std::unique_ptr<FlipReference> flip_;
};

}  // namespace lucarium
