// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/shared_reference.h"

#include <algorithm>
#include <map>
#include <optional>

#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr size_t max_rounds = 1000;  // handed out at once
constexpr double usual_round = 256;  // samples per pixel, except the first few

/// How many rounds to hand out: all of a goal of samples; of a goal of error half of what it seems to need, since
/// rounds behind its end are rendered in vain.
size_t count_rounds(const ReferenceImage& image, const ReferenceGoal& goal, size_t width) {
  if (goal.relmse <= 0) return max_rounds;
  if (!image.error_known()) return std::max<size_t>(width, 2);
  const double samples = static_cast<double>(image.samples()) * (image.error().relmse / goal.relmse - 1);
  const double rounds = std::min(0.5 * samples / usual_round, static_cast<double>(max_rounds));
  return std::max(width, static_cast<size_t>(std::max(rounds, 1.0)));
}

/// One list of rounds on its way into the image, in order, whenever they end.
class Rounds {
 public:
  Rounds(const Job& job, ReferenceImage& image, const ReferenceGoal& goal, const SharedReferenceEvents& events)
      : job_(job), image_(image), goal_(goal), events_(events) {}

  void plan(const std::vector<ReferenceRound>& rounds, const fs::path& folder) {
    rounds_ = rounds;
    tasks_.clear();
    ended_.clear();
    next_ = 0;
    for (size_t i = 0; i < rounds.size(); ++i) {
      PieceTask task;
      task.name = fmt::format("round{}", image_.rounds() + i + 1);
      task.job = job_;
      task.job.seed = rounds[i].seed;
      auto work = std::get<ReferenceWork>(job_.work);
      work.round_samples = rounds[i].samples;
      work.output = folder / (task.name + ".exr");
      task.job.work = work;
      tasks_.push_back(std::move(task));
    }
  }

  const std::vector<PieceTask>& tasks() const { return tasks_; }

  void add(size_t task, const PieceEnd& end) {
    const bool cut_off = end.child.exit_code == static_cast<int>(ErrorClass::interrupted);
    if ((cut_off || !end.failure.empty()) && interrupt_requested()) return;
    if (cut_off)
      throw_error(ErrorClass::interrupted,
                  "{} was stopped by a signal that did not reach this process; what is kept can be extended",
                  tasks_[task].name);
    if (!end.failure.empty())
      throw_error(class_of_end(end.child), "{} was not rendered: {}", tasks_[task].name, end.failure);
    ended_[task] = nlohmann::json::parse(end.child.out).at("seconds");
    while (ended_.contains(next_) && !is_reached(image_, goal_, 0)) add_next();
  }

 private:
  void add_next() {
    const fs::path file = std::get<ReferenceWork>(tasks_[next_].job.work).output;
    const Film round = read_image(file);
    image_.add(round, rounds_[next_].samples, rounds_[next_].half);
    seconds_ += ended_[next_];
    events_.keep(image_, round, seconds_);
    fs::remove(file);
    ++next_;
    const bool known = image_.error_known();
    events_.progress({reached_fraction(goal_, image_.error(), known, image_.samples(), image_.samples(), 0),
                      image_.samples(), seconds_});
  }

  const Job& job_;
  ReferenceImage& image_;
  const ReferenceGoal& goal_;
  const SharedReferenceEvents& events_;
  std::vector<ReferenceRound> rounds_;
  std::vector<PieceTask> tasks_;
  std::map<size_t, double> ended_;  ///< seconds of each that has ended
  size_t next_ = 0;                 ///< to be added
  double seconds_ = 0;
};

}  // namespace

bool extend_shared_reference(PieceExecutor& executor, const Job& job, ReferenceImage& image, const ReferenceGoal& goal,
                             const fs::path& folder, const SharedReferenceEvents& events) {
  if (goal.seconds > 0)
    throw_error(ErrorClass::usage,
                "rounds that are shared out have no clock in common; give --spp or --relmse, not --time");
  Rounds rounds(job, image, goal, events);
  PieceEvents heard;
  heard.on_start = [](size_t) {};
  heard.on_line = [](size_t, std::string_view) {};
  heard.on_end = [&](size_t task, const PieceEnd& end) { rounds.add(task, end); };
  heard.say = events.say;
  heard.progress = [](double, const std::string&) {};  // samples say more
  while (!is_reached(image, goal, 0) && !interrupt_requested()) {
    fs::create_directories(folder);
    rounds.plan(plan_rounds(image, goal, job.seed, count_rounds(image, goal, executor.width())), folder);
    executor.run(rounds.tasks(), heard);
  }
  const bool done = is_reached(image, goal, 0);
  std::error_code ignored;
  if (done || !executor.keeps_tasks()) fs::remove_all(folder, ignored);
  return done;
}

}  // namespace lucarium
