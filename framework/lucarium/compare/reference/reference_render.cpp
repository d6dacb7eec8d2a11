// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/reference/reference_render.h"

#include <algorithm>
#include <array>

#include "lucarium/base/error.h"
#include "lucarium/base/hash.h"
#include "lucarium/session/counted_seconds.h"

namespace lucarium {
namespace {

constexpr int replicates = 16;
constexpr double no_time = 1e-9;         // one iteration; 0 would be no limit
constexpr uint64_t largest_round = 256;  // samples per pixel: what a sudden end can lose

uint64_t round_seed(uint64_t seed, uint64_t round) { return Hasher().add(seed).add(round).finish().low; }

/// Samples of the next round of a half that holds `done`: as many again, within limits and the goal.
uint64_t next_round(uint64_t done, uint64_t goal_samples) {
  uint64_t size = std::clamp(done / reference_batch * reference_batch, reference_batch, largest_round);
  if (goal_samples > 0) {
    const uint64_t half_goal = (goal_samples + 2 * reference_batch - 1) / (2 * reference_batch) * reference_batch;
    size = std::min(size, half_goal > done ? half_goal - done : reference_batch);
  }
  return size;
}

}  // namespace

bool is_reached(const ReferenceImage& image, const ReferenceGoal& goal, double seconds) {
  if (goal.samples > 0 && image.samples() >= goal.samples) return true;
  if (goal.seconds > 0 && seconds >= goal.seconds) return true;
  return goal.relmse > 0 && image.error_known() && image.samples(0) == image.samples(1) &&
         image.error().relmse <= goal.relmse;
}

double reached_fraction(const ReferenceGoal& goal, const ReferenceError& error, bool error_known,
                        uint64_t measured_samples, uint64_t samples, double seconds) {
  double fraction = 0;
  if (goal.samples > 0) fraction = std::max(fraction, static_cast<double>(samples) / static_cast<double>(goal.samples));
  if (goal.seconds > 0) fraction = std::max(fraction, seconds / goal.seconds);
  // The error of independent samples falls as one over their number.
  if (goal.relmse > 0 && error_known && error.relmse > 0 && measured_samples > 0) {
    fraction = std::max(
        fraction, goal.relmse / error.relmse * static_cast<double>(samples) / static_cast<double>(measured_samples));
  }
  return std::min(fraction, 1.0);
}

std::vector<ReferenceRound> plan_rounds(const ReferenceImage& image, const ReferenceGoal& goal, uint64_t seed,
                                        size_t count) {
  std::array<uint64_t, ReferenceImage::halves> samples = {image.samples(0), image.samples(1)};
  std::vector<ReferenceRound> rounds;
  while (rounds.size() < count && (goal.samples == 0 || samples[0] + samples[1] < goal.samples)) {
    const size_t half = samples[1] < samples[0] ? 1 : 0;
    rounds.push_back({half, next_round(samples[half], goal.samples), round_seed(seed, image.rounds() + rounds.size())});
    samples[half] += rounds.back().samples;
  }
  return rounds;
}

std::vector<std::pair<std::string, std::string>> reference_parameters(const PathSet& set) {
  std::vector<std::pair<std::string, std::string>> parameters = set.technique_parameters();
  parameters.emplace_back("replicates", std::to_string(replicates));
  parameters.emplace_back("samples_per_iteration", std::to_string(reference_batch));
  return parameters;
}

bool extend_reference(RenderSession& session, ReferenceImage& image, const ReferenceGoal& goal, uint64_t seed,
                      const std::function<void(ReferenceImage&)>& keep,
                      const std::function<void(const ReferenceProgress&)>& on_progress) {
  if (goal.relmse <= 0 && goal.samples == 0 && goal.seconds <= 0) {
    throw Error(ErrorClass::internal, "a reference needs a number of samples, seconds or a relMSE");
  }
  while (image.samples() == 0 || !is_reached(image, goal, counted_seconds(session.clocks()))) {
    const ReferenceRound round = plan_rounds(image, goal, seed, 1).front();
    const ReferenceError error = image.error();
    const uint64_t before = image.samples();
    session.restart(round.seed);
    RenderBudget budget;
    budget.samples = round.samples;
    if (goal.seconds > 0) budget.seconds = std::max(no_time, goal.seconds - counted_seconds(session.clocks()));
    const bool interrupted = session.run(budget, [&](const IterationResult& now) {
      if (!on_progress) return true;
      const double spent = counted_seconds(session.clocks());
      const uint64_t samples = before + now.samples;
      on_progress({reached_fraction(goal, error, image.error_known(), before, samples, spent), samples, spent});
      return true;
    });
    if (session.last().samples > 0) {
      image.add(session.resolve(), session.last().samples, round.half);
      keep(image);
    }
    if (interrupted) return false;
  }
  return true;
}

}  // namespace lucarium
