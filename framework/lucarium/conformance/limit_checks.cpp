// SPDX-License-Identifier: Apache-2.0
// Checks of budgets, memory and cancelling. Declared in checks.h.
#include <algorithm>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/stopwatch.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/conformance/checks.h"

namespace lucarium::check {
namespace {

constexpr double time_budget = 0.2;       // asked for [s]
constexpr double allowed_overrun = 1;     // of a budget, and after a cancellation [s]
constexpr double allowed_estimate = 1.1;  // memory taken / memory stated

/// Bytes held now by others than scene and hierarchy.
size_t own_bytes(const MemoryAccount& memory) {
  size_t bytes = 0;
  for (const auto& [owner, held] : memory.by_owner()) {
    if (owner != "scene" && owner != "bvh") bytes += held;
  }
  return bytes;
}

}  // namespace

Outcome check_memory(CheckContext& context) {
  const MemoryAccount& memory = context.device->memory();
  const size_t before = memory.used_bytes();
  size_t during = 0;
  const Scene scene = context.plain_scene();
  for (int i = 0; i < 2; ++i) {
    RenderSession session = context.session(scene);
    context.run_short(session);
    session.restart(2);
    context.run_short(session);
    during = memory.used_bytes();
  }
  const size_t after = memory.used_bytes();
  return verdict_of(after == before, fmt::format("{} before, {} during, {} after two runs", format_bytes(before),
                                                 format_bytes(during), format_bytes(after)) +
                                         (after == before ? "" : memory.holders()));
}

Outcome check_estimate(CheckContext& context) {
  const Scene scene = context.plain_scene();
  RenderSettings settings = context.settings(scene);
  settings.width = settings.height = 256;
  const size_t others = own_bytes(context.device->memory());
  RenderSession session = context.session(scene, settings);
  session.run({.iterations = 1});
  const size_t taken = own_bytes(context.device->memory()) - others;
  const size_t stated = session.technique().estimate_bytes(session.scene(), session.settings());
  return verdict_of(static_cast<double>(taken) <= allowed_estimate * static_cast<double>(stated),
                    fmt::format("uses {}, estimates {} at 256×256", format_bytes(taken), format_bytes(stated)));
}

Outcome check_iterations(CheckContext& context) {
  RenderSession session = context.session(context.plain_scene());
  constexpr uint64_t asked = 6;
  double longest = 0;
  uint64_t samples = 0;
  Stopwatch watch;
  bool counts = true;
  session.run({.iterations = asked}, [&](const IterationResult& now) {
    session.scheduler().finish();
    longest = std::max(longest, watch.seconds());
    counts = counts && (now.samples >= samples || now.progress >= 0);
    samples = now.samples;
    watch.restart();
    return true;
  });
  const uint64_t iterations = session.iterations();
  const bool done = session.last().converged || iterations == asked;
  // What a technique does before its first sample may take more iterations.
  if (samples == 0 && session.last().progress >= 0) {
    session.run({.iterations = CheckContext::longest_lead, .samples = 1});
    samples = session.last().samples;
  }
  return verdict_of(done && counts && samples > 0,
                    fmt::format("{} of {} iterations, {} samples; the longest took {:.1f} ms", iterations, asked,
                                samples, 1e3 * longest));
}

Outcome check_seconds(CheckContext& context) {
  RenderSession session = context.session(context.plain_scene());
  const Stopwatch watch;
  session.run({.seconds = time_budget});
  session.scheduler().finish();
  const double seconds = watch.seconds();
  return verdict_of(
      seconds <= time_budget + allowed_overrun,
      fmt::format("budget {:.2f} s, used {:.2f} s, {} iterations", time_budget, seconds, session.iterations()));
}

/// Cancels an iteration at its first request, then at its second, and so on, in growing steps from the 200th, until one
/// gets through.
Outcome check_cancellation(CheckContext& context) {
  constexpr int max_requests = 5000, one_by_one = 200, steps_grow = 32;
  const Scene scene = context.plain_scene();
  RenderSession session = context.session(scene), reference = context.session(scene);
  const Picture before = context.run_short(session, 2), complete = context.run_short(reference, 3);
  const uint64_t samples = session.last().samples;
  double longest = 0;
  int cancelled = 0, times = 0;
  bool through = session.last().converged;
  for (; cancelled < max_requests && !through; cancelled += 1 + std::max(0, cancelled - one_by_one) / steps_grow) {
    int requests = 0;
    Stopwatch asked;
    session.scheduler().set_cancel([&] {
      if (requests == cancelled) asked.restart();
      return requests++ >= cancelled;
    });
    session.iterate();
    session.scheduler().finish();
    if (requests > cancelled) longest = std::max(longest, asked.seconds());
    session.scheduler().set_cancel(interrupt_requested);
    through = requests <= cancelled || session.last().samples != samples;
    if (through) break;
    ++times;
    const std::string traces = difference(context.picture(session), before);
    if (!traces.empty())
      return verdict_of(
          false, fmt::format("cancelled at request {}, the iteration changed the image: {}", cancelled + 1, traces));
  }
  if (longest > allowed_overrun)
    return verdict_of(false, fmt::format("ran on for {:.2f} s after the request to cancel", longest));
  if (!through)
    return verdict_of(false, fmt::format("no iteration completed when cancelled at its request {}", max_requests));
  const std::string different = difference(context.picture(session), complete);
  if (!different.empty())
    return verdict_of(false, "after cancelled iterations, the image differs from an undisturbed run: " + different);
  return verdict_of(
      true, fmt::format("{} cancelled, image unchanged, at most {:.1f} ms after the request", times, 1e3 * longest));
}

}  // namespace lucarium::check
