// SPDX-License-Identifier: Apache-2.0
#include "budgets/render_budget.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "lucarium/base/log.h"
#include "lucarium/base/progress.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/session/counted_seconds.h"

namespace lucarium::app {
namespace {

constexpr uint64_t default_samples = 64;
constexpr double no_time = 1e-9;  // 0 would be no limit

/// Seconds left for iterating; warns where nothing is left.
double seconds_left_of(const char* option, double seconds, double spent, const std::string& of_it = "") {
  if (spent >= seconds)
    log_warning("{} {:g} was over before the first iteration: what comes before took {:.1f} s{}", option, seconds,
                spent, of_it);
  return std::max(no_time, seconds - spent);
}

/// "0.84 Msamples/s", or of slow ones "1200 samples/s".
std::string sample_rate(double per_second) {
  return per_second < 1e4 ? fmt::format("{:.0f} samples/s", per_second)
                          : fmt::format("{:.2f} Msamples/s", per_second / 1e6);
}

/// A budget of the session, and the option that its time is of.
struct SessionBudget : RenderBudget {
  const char* time_option = "--time";
};

SessionBudget make_budget(const BudgetArguments& arguments, const RenderSession& session,
                          const Stopwatch& since_start) {
  SessionBudget budget{{0, arguments.iterations, arguments.samples}};
  const RenderSession::Clocks& clocks = session.clocks();
  if (arguments.seconds > 0) budget.seconds = seconds_left_of("--time", arguments.seconds, counted_seconds(clocks));
  if (arguments.wall_seconds > 0) {
    const double spent = since_start.seconds();
    const double left = seconds_left_of("--wall-time", arguments.wall_seconds, spent,
                                        fmt::format(" ({:.1f} s of it for kernels)", clocks.compile + clocks.warm_up));
    if (budget.seconds <= 0 || left < budget.seconds) {
      budget.seconds = left;
      budget.time_option = "--wall-time";
    }
  }
  const bool none = arguments.work_iterations == 0 && budget.seconds <= 0 && budget.iterations == 0 &&
                    budget.samples == 0 && arguments.relmse <= 0;
  if (none) budget.samples = default_samples;
  return budget;
}

std::string ended_by(const SessionBudget& budget, const RenderSession& session, bool accurate) {
  const IterationResult& last = session.last();
  if (last.converged) return last.phase.empty() ? "the technique" : last.phase;
  if (accurate) return "--relmse";
  if (budget.samples > 0 && last.samples >= budget.samples) return "--spp";
  if (budget.iterations > 0 && session.iterations() >= budget.iterations) return "--iterations";
  return budget.time_option;
}

constexpr double start_seconds = 1;   // of the program: devices, the scene's file, kernels from the cache
constexpr double min_seconds = 1e-3;  // what is planned for where the start takes all

/// Whether --wall-time is used up before --time.
bool is_wall_time(const BudgetArguments& arguments) {
  return arguments.wall_seconds > 0 &&
         (arguments.seconds <= 0 || arguments.wall_seconds - start_seconds <= arguments.seconds);
}

/// The option that is used up first.
std::string time_option(const BudgetArguments& arguments) {
  return is_wall_time(arguments) ? fmt::format("--wall-time {:g}", arguments.wall_seconds)
                                 : fmt::format("--time {:g}", arguments.seconds);
}

/// Two figures, and whole seconds from 10 on.
std::string about(double seconds) {
  return seconds < 10 ? fmt::format("{:.2g}", seconds) : fmt::format("{:.0f}", seconds);
}

/// When there was a first picture [s], on the clocks of --time and --wall-time.
struct FirstPicture {
  double counted = 0, wall = 0;
};

/// After a budget that was too small for the first picture: which one would have done.
void tell_first_picture(const BudgetArguments& arguments, const FirstPicture& picture) {
  std::vector<std::string> enough;
  const auto add = [&](const char* option, double budget, double seconds) {
    if (budget > 0 && seconds > budget) enough.push_back(fmt::format("{} {}", option, about(1.1 * seconds)));
  };
  add("--time", arguments.seconds, picture.counted);
  add("--wall-time", arguments.wall_seconds, picture.wall);
  if (!enough.empty())
    log_warning("the first picture came later than the budget: {} would have given it", fmt::join(enough, " and "));
}

}  // namespace

TimeBudget planned_time(const BudgetArguments& arguments) {
  const double seconds =
      is_wall_time(arguments) ? std::max(arguments.wall_seconds - start_seconds, min_seconds) : arguments.seconds;
  return {seconds, seconds > 0};
}

void tell_plan(const BudgetArguments& arguments, const BudgetPlan& plan, const std::string& technique) {
  if (!plan.changes.empty())
    log_warning("{}: for {}: {}; half of it is for the first whole picture, which would take about {} s otherwise",
                technique, time_option(arguments), plan.changes_text(), about(plan.default_seconds));
  if (plan.budget_seconds > 0 && !plan.fits())
    log_warning("{}: {} is too short for a whole picture; about {} s would do", technique, time_option(arguments),
                about(plan.sufficient_seconds + (is_wall_time(arguments) ? start_seconds : 0)));
}

bool finish_light(RenderSession& session, bool quiet) {
  Progress progress("propagating", quiet ? Progress::Style::quiet : Progress::Style::automatic);
  bool warned = false;
  return session.finish_light([&](const IterationResult& now) {
    if (now.progress < 0 && !now.light_done && !std::exchange(warned, true))
      log_warning(
          "when its light will be finished is unknown, perhaps never, and what follows waits for it; give it an "
          "end, as directions=N, or press Ctrl-C");
    progress.update(now.progress, now.phase);
  });
}

RenderEnd render_within_budget(const BudgetArguments& arguments, RenderSession& session, bool quiet,
                               const std::function<std::optional<double>(RenderSession&)>& relmse,
                               const Stopwatch& since_start) {
  const SessionBudget budget = make_budget(arguments, session, since_start);
  Progress progress("rendering", quiet ? Progress::Style::quiet : Progress::Style::automatic);
  TimeLeft left;
  left.update(0, 0);
  bool accurate = false;
  const auto nothing_yet = [&] {
    return session.last().samples == 0 && !session.last().visible && !session.last().converged;
  };
  std::optional<FirstPicture> first;
  uint64_t work_iterations = 0;
  std::string phase_told;
  const auto on_progress = [&](const IterationResult& now) {
    if (!first && !nothing_yet()) first = {counted_seconds(session.clocks()), since_start.seconds()};
    const double seconds = session.clocks().iterate;
    left.update(now.progress, seconds);
    double fraction = now.progress;
    const auto used = [&fraction](double part, double whole) {
      if (whole > 0) fraction = std::max(fraction, part / whole);
    };
    used(static_cast<double>(now.samples), static_cast<double>(budget.samples));
    used(static_cast<double>(session.iterations()), static_cast<double>(budget.iterations));
    used(seconds, budget.seconds);
    const double rate = static_cast<double>(now.samples) * session.settings().width * session.settings().height /
                        std::max(1e-9, seconds);
    const std::string phase = now.phase.empty() ? "" : now.phase + ", ";
    progress.update(fraction,
                    fmt::format("{}{} per pixel, {}", phase, counted(now.samples, "sample"), sample_rate(rate)));
    const std::optional<double> error = relmse(session);
    accurate = error && arguments.relmse > 0 && *error <= arguments.relmse;
    if (now.phase != phase_told) log_info("stage '{}' at {:.2f} s of iterating", now.phase, seconds);
    phase_told = now.phase;
    if (now.progress != 0) ++work_iterations;
    return !accurate && (arguments.work_iterations == 0 || work_iterations < arguments.work_iterations);
  };
  RenderEnd end;
  end.interrupted = session.run(budget, on_progress);
  if (!end.interrupted && nothing_yet()) {
    log_warning("the budget ended before there was any picture; going on to the first one");
    end.interrupted = session.run({}, [&](const IterationResult& now) { return on_progress(now) && nothing_yet(); });
  }
  if (first && !end.interrupted) tell_first_picture(arguments, *first);
  end.by = end.interrupted ? "Ctrl-C" : ended_by(budget, session, accurate);
  if (!session.last().converged) end.seconds_left = left.estimate();
  log_info("ended by {} after {}, {} per pixel, {:.2f} s of iterating", end.by,
           counted(session.iterations(), "iteration"), counted(session.last().samples, "sample"),
           session.clocks().iterate);
  return end;
}

}  // namespace lucarium::app
