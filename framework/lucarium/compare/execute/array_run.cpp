// SPDX-License-Identifier: Apache-2.0
// Submits, watches, takes and retries. What is on disk decides: a run that was killed at any point is taken up by the
// next one, which finds the batches in the folder and asks the queue for them by their names.
#include "lucarium/compare/execute/array_run.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <random>
#include <thread>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/execute/array_task.h"
#include "lucarium/compare/execute/slurm_executor.h"
#include "lucarium/compare/execute/warm_up.h"

namespace lucarium {
namespace fs = std::filesystem;
namespace {

constexpr const char* run_file = "run.txt";
constexpr std::string_view batch_prefix = "batch";
constexpr unsigned looks_until_lost = 2;
constexpr unsigned looks_per_accounting = 10;  // at what is not in the queue
// A shared folder may show late what a node wrote: NFS keeps what it knows of a folder for up to a minute (acdirmax).
constexpr double late_files = 90;   // [s]
constexpr unsigned late_looks = 5;  // at least: each asks the folder again
constexpr size_t bad_node_failures = 3;

// Looking at the queue costs the site's controller: a fiftieth of its time at most.
constexpr double look_costs = 50, shortest_look = 1, longest_look = 60;  // [s]
constexpr double submission_pause = 30;                                  // [s], after a refusal
constexpr std::chrono::milliseconds pause{200};

std::optional<size_t> number_of_batch(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (!name.starts_with(batch_prefix)) return std::nullopt;
  size_t number = 0;
  const char* const end = name.data() + name.size();
  const auto [read, failure] = std::from_chars(name.data() + batch_prefix.size(), end, number);
  if (failure != std::errc() || read != end) return std::nullopt;
  return number;
}

std::string random_name() {
  std::random_device random;
  return fmt::format("lucarium-{:08x}", static_cast<uint32_t>(random()));
}

}  // namespace

ArrayRun::ArrayRun(const fs::path& program, const fs::path& folder, const std::vector<std::string>& options,
                   const std::vector<PieceTask>& tasks, const PieceEvents& events)
    : program_(program), folder_(folder), options_(options), tasks_(tasks), events_(events), pieces_(tasks.size()) {
  for (size_t i = 0; i < tasks.size(); ++i) by_name_[tasks[i].name] = i;
}

void ArrayRun::run() {
  open_folder();
  attach();
  largest_ = largest_array();
  bool told_leaving = false;
  while (ended_ < pieces_.size()) {
    if (interrupt_requested()) {
      leave();
      told_leaving = true;
      break;
    }
    try {
      submit_waiting();
      const double interval = std::clamp(look_costs * look_seconds_, shortest_look, longest_look);
      if (since_look_.seconds() >= interval) look();
      take_ended();
    } catch (...) {
      leave();
      throw;
    }
    show_progress();
    if (ended_ < pieces_.size()) std::this_thread::sleep_for(pause);
  }
  if (!told_leaving) clean_up();
}

// ---- what is on disk

void ArrayRun::open_folder() {
  fs::create_directories(folder_);
  const fs::path file = folder_ / run_file;
  if (!fs::exists(file)) write_file_atomically(file, random_name());
  run_name_ = read_file(file);
}

void ArrayRun::add_batch(size_t number, const std::vector<std::vector<BatchPiece>>& tasks) {
  Batch batch{
      SlurmBatch(folder_ / fmt::format("{}{}", batch_prefix, number)), fmt::format("{}-{}", run_name_, number), {}};
  for (size_t index = 0; index < tasks.size(); ++index) {
    for (const BatchPiece& item : tasks[index]) {
      const auto found = by_name_.find(item.name);
      // One of another state of the comparison is of no use.
      if (found == by_name_.end() || batch.files.piece_of(tasks_[found->second]) != item) continue;
      Piece& piece = pieces_[found->second];
      batch.index[item.name] = index;
      piece.state = Piece::State::submitted;
      piece.batch = number;
      piece.index = index;
      piece.seen();
      ++piece.attempts;
    }
  }
  batches_.emplace(number, std::move(batch));
}

/// Takes up what an earlier run left.
void ArrayRun::attach() {
  std::set<size_t> numbers;
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder(folder_, failure)) {
    if (const std::optional<size_t> number = number_of_batch(entry.path())) numbers.insert(*number);
  }
  for (const size_t number : numbers) {
    last_number_ = number;
    try {
      add_batch(number, SlurmBatch(folder_ / fmt::format("{}{}", batch_prefix, number)).read());
    } catch (const std::exception&) {
      // Killed before the batch was whole: it was not submitted. What is there and cannot be read may have jobs.
      const fs::path batch = folder_ / fmt::format("{}{}", batch_prefix, number);
      if (SlurmBatch(batch).is_whole()) throw;
      fs::remove_all(batch, failure);
    }
  }
  // Each run may try once more, however many were interrupted before it.
  for (Piece& piece : pieces_) piece.attempts = std::min(piece.attempts, slurm_attempts - 1);
  const auto attached = std::count_if(pieces_.begin(), pieces_.end(),
                                      [](const Piece& piece) { return piece.state == Piece::State::submitted; });
  if (attached > 0)
    events_.say(fmt::format("attached to {} with Slurm", counted(static_cast<uint64_t>(attached), "job")));
  since_look_.restart();
}

// ---- submitting

void ArrayRun::submit_waiting() {
  if (!refusal_.empty() && since_submission_.seconds() < submission_pause) return;
  // One array each: for nodes of one's own or not, without these nodes.
  std::map<std::pair<bool, std::set<std::string>>, std::map<std::string, std::vector<size_t>>> groups;
  for (size_t i = 0; i < pieces_.size(); ++i) {
    if (pieces_[i].state != Piece::State::waiting) continue;
    std::set<std::string> excluded = pieces_[i].failed_on;
    excluded.insert(bad_nodes_.begin(), bad_nodes_.end());
    // A key that keeps the order of the list.
    const std::string& like = tasks_[i].like;
    auto& group = groups[{!like.empty(), excluded}];
    group[like.empty() ? fmt::format("{:012}", i) : like].push_back(i);
  }
  refusal_.clear();
  for (const auto& [kind, by_like] : groups) {
    Array array;
    for (const auto& [unused, members] : by_like) array.push_back(members);
    std::sort(array.begin(), array.end());
    for (size_t first = 0; first < array.size(); first += largest_) {
      const auto begin = array.begin() + static_cast<std::ptrdiff_t>(first);
      const auto count = static_cast<std::ptrdiff_t>(std::min(largest_, array.size() - first));
      submit(Array(begin, begin + count), kind.first, kind.second);
      if (!refusal_.empty()) return;
    }
  }
}

void ArrayRun::submit(const Array& array, bool exclusive, const std::set<std::string>& excluded) {
  const size_t number = ++last_number_;  // never twice: an array that was refused may be with Slurm all the same
  const SlurmBatch batch(folder_ / fmt::format("{}{}", batch_prefix, number));
  std::vector<std::vector<BatchPiece>> tasks;
  for (const std::vector<size_t>& members : array) {
    tasks.emplace_back();
    for (const size_t member : members) tasks.back().push_back(batch.piece_of(tasks_[member]));
  }
  batch.write(tasks);
  SlurmSubmission submission;
  submission.name = fmt::format("{}-{}", run_name_, number);
  submission.tasks = array.size();
  submission.log_folder = batch.log_folder();
  submission.exclusive = exclusive;
  submission.excluded_nodes = {excluded.begin(), excluded.end()};
  submission.options = options_;
  submission.script = batch.script(program_);
  std::string refusal = submit_array(submission);
  if (!refusal.empty() && !excluded.empty() && !interrupt_requested()) {  // without these there may be none left
    submission.excluded_nodes.clear();
    refusal = submit_array(submission);
  }
  since_submission_.restart();
  if (!refusal.empty() && interrupt_requested()) return;  // attach() takes up what Slurm may have taken
  if (refusal.empty()) {
    for (const std::vector<size_t>& members : array)
      for (const size_t member : members) events_.on_start(member);
    add_batch(number, tasks);
    return;
  }
  std::error_code ignored;
  fs::remove_all(batch.folder(), ignored);
  const bool others = std::any_of(pieces_.begin(), pieces_.end(),
                                  [](const Piece& piece) { return piece.state == Piece::State::submitted; });
  if (!others && ended_ == 0) throw_error(ErrorClass::input, "Slurm does not take the jobs: {}", refusal);
  if (refusal_ != refusal) events_.say(fmt::format("Slurm takes no more jobs for now: {}", refusal));
  refusal_ = refusal;
}

// ---- what comes back

void ArrayRun::take_ended() {
  for (auto& [number, batch] : batches_) {
    if (batch.index.empty()) continue;
    for (const std::string& name : batch.files.list_ended()) {
      const auto found = by_name_.find(name);
      if (found == by_name_.end() || !batch.index.contains(name)) continue;
      if (pieces_[found->second].state == Piece::State::ended) {
        batch.files.remove_ended(name);  // an attempt that was given up, and came all the same
      } else {
        take(found->second, batch, name);
      }
      batch.index.erase(name);
    }
  }
}

void ArrayRun::take(size_t index, Batch& batch, const std::string& name) {
  Piece& piece = pieces_[index];
  EndedPiece ended = batch.files.read_ended(name);
  const ChildResult& child = ended.child;
  if (child.exit_code == 0) {
    batch.files.take_image(tasks_[index]);
    blame(piece);
    piece.state = Piece::State::ended;
    ++ended_;
    events_.on_end(index, {child, "", ended.machine});
    batch.files.remove_ended(name);
    return;
  }
  batch.files.remove_ended(name);
  const std::string note = fmt::format("{}{}: {}", describe_end(child), ended.node.empty() ? "" : " on " + ended.node,
                                       child.last_words.empty() ? "no message" : child.last_words.back());
  if (piece.batch == number_of_batch(batch.files.folder())) fail(index, note, ended.node, child, ended.machine);
}

void ArrayRun::look() {
  const Stopwatch asking;
  const auto states = query_arrays(names());
  look_seconds_ = asking.seconds();
  since_look_.restart();
  if (!states) {
    if (!silent_) events_.say("squeue does not answer; waiting");
    silent_ = true;
    return;
  }
  if (silent_) events_.say("squeue answers again");
  silent_ = false;
  states_ = *states;
  take_ended();  // first, so that nothing that has ended counts as lost
  std::optional<std::map<SlurmTaskId, SlurmTaskState>> accounting;
  std::set<size_t> renewed;  // batches
  for (size_t i = 0; i < pieces_.size(); ++i) {
    Piece& piece = pieces_[i];
    if (piece.state != Piece::State::submitted) continue;
    const SlurmTaskId id{batches_.at(piece.batch).name, piece.index};
    const auto found = states_.find(id);
    const bool stuck = found != states_.end() && found->second.stuck();
    if (stuck) cancel_task(found->second.id);
    if (found != states_.end() && found->second.active() && !stuck) {
      piece.seen();
      continue;
    }
    if (piece.unseen == 0) piece.since_unseen.restart();
    if (!stuck && ++piece.unseen < looks_until_lost) continue;
    const SlurmTaskState* state = found == states_.end() ? nullptr : &found->second;
    if (!state && !piece.accounted && piece.unseen >= piece.next_accounting) {
      if (!accounting) {
        const Stopwatch accounts;
        accounting = query_accounting(names());
        look_seconds_ += accounts.seconds();
      }
      piece.next_accounting = piece.unseen + looks_per_accounting;
      if (const auto known = accounting->find(id); known != accounting->end()) piece.accounted = known->second;
    }
    if (!state && piece.accounted) state = &*piece.accounted;
    // Whatever completed has left its files; of what is gone nobody knows.
    const bool may_come = !state || state->state == "COMPLETED";
    if (may_come && (piece.since_unseen.seconds() < late_files || piece.unseen < late_looks)) {
      if (renewed.insert(piece.batch).second) batches_.at(piece.batch).files.renew_view();
      continue;
    }
    lose(i, state);
  }
}

/// The task is gone, and nothing came of the piece.
void ArrayRun::lose(size_t index, const SlurmTaskState* state) {
  const Piece& piece = pieces_[index];
  const std::string said = batches_.at(piece.batch).files.last_words(piece.index);
  const std::string node = state ? state->node : "";
  const std::string what = state ? state->state + (state->stuck() ? ", " + state->reason : "") : "gone from the queue";
  const std::string note =
      fmt::format("{}{}{}", what, node.empty() ? "" : " on " + node, said.empty() ? "" : ": " + said);
  ChildResult child;
  child.last_words = {fmt::format("{}{}", error_prefix, note)};
  fail(index, note, node, child, {});
}

void ArrayRun::fail(size_t index, const std::string& note, const std::string& node, ChildResult child,
                    PieceMachine machine) {
  Piece& piece = pieces_[index];
  piece.notes.push_back(note);
  if (!node.empty()) piece.failed_on.insert(node);
  if (piece.attempts < slurm_attempts) {
    piece.state = Piece::State::waiting;
    return;
  }
  piece.state = Piece::State::ended;
  ++ended_;
  ++failed_;
  const bool same =
      std::all_of(piece.notes.begin(), piece.notes.end(), [&](const auto& other) { return other == note; });
  events_.on_end(index, {std::move(child),
                         fmt::format("{}: {}", counted(piece.attempts, "attempt"),
                                     same ? note : fmt::format("{}", fmt::join(piece.notes, "; "))),
                         std::move(machine)});
}

/// What failed on a node and succeeded elsewhere is the node's fault.
void ArrayRun::blame(const Piece& piece) {
  for (const std::string& node : piece.failed_on) {
    if (++node_failures_[node] != bad_node_failures) continue;
    bad_nodes_.insert(node);
    events_.say(
        fmt::format("node {} gets nothing more: others could do {} jobs that failed there", node, bad_node_failures));
  }
}

void ArrayRun::show_progress() {
  size_t running = 0, retried = 0;
  std::string reason;
  for (const auto& [id, state] : states_) {
    running += state.state == "RUNNING" || state.state == "COMPLETING";
    if (state.state == "PENDING" && state.reason != "None") reason = " (" + state.reason + ")";
  }
  for (const Piece& piece : pieces_) retried += piece.state != Piece::State::ended && piece.attempts > 1;
  const size_t left = pieces_.size() - ended_;
  running = std::min(running, left);
  std::string text = fmt::format("{} of {} pieces, {} running, {} waiting{}", ended_, pieces_.size(), running,
                                 left - running, left > running ? reason : "");
  if (retried > 0) text += fmt::format(", {} tried again", retried);
  if (failed_ > 0) text += fmt::format(", {} failed", failed_);
  events_.progress(static_cast<double>(ended_) / static_cast<double>(pieces_.size()), text);
}

std::vector<std::string> ArrayRun::names() const {
  std::vector<std::string> all;
  for (const auto& [number, batch] : batches_) all.push_back(batch.name);
  return all;
}

/// Jobs that are left alone must be said.
void ArrayRun::leave() {
  const auto open = std::count_if(pieces_.begin(), pieces_.end(),
                                  [](const Piece& piece) { return piece.state == Piece::State::submitted; });
  if (open == 0) return;
  events_.say(fmt::format("{} with Slurm go on; {}, {} ends them", counted(static_cast<uint64_t>(open), "job"),
                          events_.how_to_attach, cancel_hint(names())));
}

/// Removes what is of no use any more: all, unless an attempt that was given up still runs.
void ArrayRun::clean_up() {
  const auto states = query_arrays(names());
  if (!states) return;
  bool all = true;
  std::error_code ignored;
  for (const auto& [number, batch] : batches_) {
    const std::string& name = batch.name;
    const bool runs = std::any_of(states->begin(), states->end(), [&](const auto& entry) {
      return entry.first.first == name && entry.second.active() && entry.second.state != "COMPLETING";
    });
    const bool taken = batch.index.empty();
    if (runs && !taken) {
      all = false;
    } else {
      fs::remove_all(batch.files.folder(), ignored);
    }
  }
  if (!all) return;
  fs::remove_all(folder_ / warm_folder, ignored);
  fs::remove(folder_ / run_file, ignored);
  fs::remove(folder_, ignored);
}

}  // namespace lucarium
