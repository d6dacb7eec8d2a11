// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "lucarium/compare/reference/reference_image.h"
#include "lucarium/services/path_set.h"
#include "lucarium/session/session.h"

namespace lucarium {

/// When a reference is done: whichever comes first; 0: not asked for.
struct ReferenceGoal {
  double relmse = 0;     ///< its own estimated relMSE; looked at when both halves hold the same number of samples
  uint64_t samples = 0;  ///< per pixel, of both halves together
  double seconds = 0;    ///< of preparing and iterating, by the session
};

/// Samples per pixel of one iteration of the parameters below; rounds are multiples of it.
inline constexpr uint64_t reference_batch = 16;

/// Parameters of path_tracing with which references are rendered: exactly the light paths of `set` (max_bounces is the
/// session's), 16 replicates for the variance per pixel, and large batches, which trace faster.
std::vector<std::pair<std::string, std::string>> reference_parameters(const PathSet& set);

/// State of a reference in progress, for people.
struct ReferenceProgress {
  double fraction = 0;   ///< of the goal, estimated; 0 … 1
  uint64_t samples = 0;  ///< per pixel, summed over rounds
  double seconds = 0;    ///< of this call
};

/// One round: independent of all others, whoever renders it.
struct ReferenceRound {
  size_t half = 0;  ///< to which it belongs
  uint64_t samples = 0, seed = 0;
};

/// The next rounds of an image, `count` at most: fewer where a goal of samples is reached with them.
std::vector<ReferenceRound> plan_rounds(const ReferenceImage& image, const ReferenceGoal& goal, uint64_t seed,
                                        size_t count);

/// Whether an image on which that time was spent is done.
bool is_reached(const ReferenceImage& image, const ReferenceGoal& goal, double seconds);

/// Share of the goal that an image had reached with `samples` of which `measured_samples` gave the error; 0 … 1.
double reached_fraction(const ReferenceGoal& goal, const ReferenceError& error, bool error_known,
                        uint64_t measured_samples, uint64_t samples, double seconds);

/// Adds rounds to `image` until the goal is reached; returns false when interrupted, with the samples done until then
/// in the image. Rounds double from 16 to 256 samples per pixel and go to the half that has fewer; their seeds come
/// from `seed` and their number, so that a reference extended later is the one rendered at once. `keep` is called after
/// every round, since only written rounds survive a sudden end.
bool extend_reference(RenderSession& session, ReferenceImage& image, const ReferenceGoal& goal, uint64_t seed,
                      const std::function<void(ReferenceImage&)>& keep,
                      const std::function<void(const ReferenceProgress&)>& on_progress = {});

}  // namespace lucarium
