// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "bundle_exchange/senders/side_means.h"

namespace lucarium::bundle {

/// What directions are for at present.
enum class Phase {
  light,          ///< texels do not know yet the direct light that they are to send
  exchange,       ///< directions carry all light
  emission_only,  ///< reflected light is known well enough: they carry the emitted light alone
  done,           ///< used up, as accurate as wanted, or of no use
};

/// Directions of the batch that begins with direction `directions`: few at first, when much is learnt from each, and
/// none across a boundary of what they carry.
uint32_t batch_size(const Parameters& parameters, const SideMeans& means, uint64_t directions);

/// Directions of an iteration of about 100 ms. `largest_image`: of a direction [pixels]; `gathers`: pixels gather along
/// them.
uint32_t directions_per_iteration(const Parameters& parameters, double largest_image, bool gathers);

/// Where an iteration is.
struct IterationStep {
  bool begun = false, seen = false;
  bool eye_only = false;        ///< a camera sample and nothing else
  bool eye = false;             ///< it has a camera sample
  double eye_earned = 0;        ///< camera samples that are earned at its end, its own included
  uint32_t light_runs = 0;      ///< left to do
  uint64_t begin = 0, end = 0;  ///< position() at first, and when it is done
};

/// The batch that is under way.
struct BatchStep {
  uint32_t count = 0, done = 0;  ///< directions
};

/// Whether the error is as wanted. With pingpong it is that of one bounce, with fixed shares light is missing before
/// the end: both use up their directions.
bool is_accurate(const Parameters& parameters, const SideMeans& means, uint64_t directions);

/// How far the exchange alone is, 0…1, since what it has found is kept when the camera moves; negative: unknown, as
/// directions, or behind them samples of pixels, have no limit.
double progress_of(Phase phase, const Parameters& parameters, uint64_t directions);

/// The phase for people: "light", "exchange".
std::string describe(Phase phase, const SideMeans& means);

/// Whether an image of so many camera samples has all that are wanted.
bool has_samples(const Parameters& parameters, uint64_t camera_samples);

/// Why an image has converged, for people. `exchanges`: bundles carry anything; camera_samples: of the image.
std::string why_converged(const Parameters& parameters, const SideMeans& means, uint64_t directions, bool exchanges,
                          uint32_t camera_samples);

}  // namespace lucarium::bundle
