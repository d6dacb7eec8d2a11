// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/run/shared_reference.h"

#include <algorithm>
#include <map>
#include <optional>

#include "lucarium/base/error.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/film/image_io.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr size_t max_rounds = 1000;  // handed out at once
constexpr const char* round_prefix = "round";
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
    missing_.clear();
    ended_.clear();
    next_ = 0;
    for (size_t i = 0; i < rounds.size(); ++i) {
      PieceTask task;
      task.name = fmt::format("{}{}", round_prefix, image_.rounds() + i + 1);
      task.job = job_;
      task.job.seed = rounds[i].seed;
      auto work = std::get<ReferenceWork>(job_.work);
      work.round_samples = rounds[i].samples;
      work.output = folder / (task.name + ".exr");
      task.job.work = work;
      tasks_.push_back(std::move(task));
    }
  }

  /// Takes the rounds that an earlier start left, since one before them had not ended; returns how many there are.
  size_t take_left() {
    for (size_t i = 0; i < tasks_.size(); ++i) {
      if (const std::optional<double> seconds = seconds_of_left(i)) ended_[i] = *seconds;
    }
    const size_t left = ended_.size();
    for (size_t i = 0; i < tasks_.size(); ++i)
      if (!ended_.contains(i)) missing_.push_back(i);
    add_ended();
    return left;
  }

  /// Those that must be rendered, after take_left().
  std::vector<PieceTask> missing() const {
    std::vector<PieceTask> tasks;
    for (const size_t task : missing_) tasks.push_back(tasks_[task]);
    return tasks;
  }

  /// `index`: in missing().
  void add(size_t index, const PieceEnd& end) {
    const size_t task = missing_[index];
    const bool cut_off = end.child.exit_code == static_cast<int>(ErrorClass::interrupted);
    if ((cut_off || !end.failure.empty()) && interrupt_requested()) return;
    if (cut_off)
      throw_error(ErrorClass::interrupted,
                  "{} was stopped by a signal that did not reach this process; what is kept can be extended",
                  tasks_[task].name);
    if (!end.failure.empty())
      throw_error(class_of_end(end.child), "{} was not rendered: {}", tasks_[task].name, end.failure);
    ended_[task] = nlohmann::json::parse(end.child.out).at("seconds");
    add_ended();
  }

 private:
  const fs::path& file_of(size_t task) const { return std::get<ReferenceWork>(tasks_[task].job.work).output; }

  /// How long the round took that lies there already; nothing where there is none, or another.
  std::optional<double> seconds_of_left(size_t task) const {
    if (!fs::exists(file_of(task))) return std::nullopt;
    try {
      const Film film = read_image(file_of(task));
      const auto& metadata = film.metadata;
      if (metadata.at("seed") != std::to_string(rounds_[task].seed) ||
          metadata.at("samples") != std::to_string(rounds_[task].samples) || film.width() != image_.film().width() ||
          film.height() != image_.film().height())
        return std::nullopt;
      return std::stod(metadata.at("seconds"));
    } catch (const std::exception&) {  // damaged: it is rendered again
      return std::nullopt;
    }
  }

  void add_ended() {
    while (ended_.contains(next_) && !is_reached(image_, goal_, 0)) add_next();
  }

  void add_next() {
    const fs::path file = file_of(next_);
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
  std::vector<size_t> missing_;     ///< of tasks_
  std::map<size_t, double> ended_;  ///< seconds of each that has ended
  size_t next_ = 0;                 ///< to be added
  double seconds_ = 0;
};

/// Whether rounds lie there that ended before those ahead of them.
bool has_rounds(const fs::path& folder) {
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder(folder, failure))
    if (entry.path().filename().string().starts_with(round_prefix)) return true;
  return false;
}

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
  heard.how_to_attach = "--extend attaches to them again";
  heard.progress = [](double, const std::string&) {};  // samples say more
  while (!is_reached(image, goal, 0) && !interrupt_requested()) {
    fs::create_directories(folder);
    rounds.plan(plan_rounds(image, goal, job.seed, count_rounds(image, goal, executor.width())), folder);
    const size_t left = rounds.take_left();
    if (left > 0) events.say(fmt::format("{} there already", counted(left, "round")));
    const std::vector<PieceTask> missing = rounds.missing();
    if (!missing.empty() && !is_reached(image, goal, 0)) executor.run(missing, heard);
  }
  const bool done = is_reached(image, goal, 0);
  std::error_code ignored;
  if (done || !(executor.keeps_tasks() || has_rounds(folder))) fs::remove_all(folder, ignored);
  return done;
}

}  // namespace lucarium
