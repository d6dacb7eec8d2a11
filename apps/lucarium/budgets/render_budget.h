// SPDX-License-Identifier: Apache-2.0
// How long `lucarium render` goes on, and what ended it.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "lucarium/base/stopwatch.h"
#include "lucarium/session/session.h"

namespace lucarium::app {

/// What a picture may take; 0: no limit. Whichever ends first counts; none: 64 samples per pixel.
struct BudgetArguments {
  uint64_t samples = 0, iterations = 0;
  double seconds = 0;            ///< counted_seconds()
  double wall_seconds = 0;       ///< of the clock on the wall, from the start of the program or from the picture before
  double relmse = 0;             ///< of the image against a reference
  uint64_t work_iterations = 0;  ///< as RenderWork
};

/// What parameters are planned for: a budget of time is used to its end. One of an error alone is not: who cannot get
/// there must end.
TimeBudget planned_time(const BudgetArguments& arguments);
/// Says what was changed for that time, or that no change is enough.
void tell_plan(const BudgetArguments& arguments, const BudgetPlan& plan, const std::string& technique);

/// RenderSession::finish_light(), with its progress; returns whether it was interrupted.
bool finish_light(RenderSession& session, bool quiet);

/// How a rendering went.
struct RenderEnd {
  bool interrupted = false;
  std::string by;                      ///< the option whose budget is used up, "Ctrl-C", or what the technique says
  std::optional<double> seconds_left;  ///< until the technique ends by itself, where that is known
};

/// Renders one picture within the budget, or if that is over before, up to the first picture, with a warning.
/// `relmse` gives the image's present error where it is known.
RenderEnd render_within_budget(const BudgetArguments& arguments, RenderSession& session, bool quiet,
                               const std::function<std::optional<double>(RenderSession&)>& relmse,
                               const Stopwatch& since_start);

}  // namespace lucarium::app
