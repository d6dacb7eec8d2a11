// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <optional>
#include <set>

#include "lucarium/base/stopwatch.h"
#include "lucarium/compare/execute/piece_executor.h"
#include "lucarium/compare/execute/slurm_batch.h"
#include "lucarium/compare/execute/slurm_commands.h"

namespace lucarium {

/// One list of tasks on its way through Slurm: SlurmExecutor::run() makes one.
class ArrayRun {
 public:
  ArrayRun(const std::filesystem::path& program, const std::filesystem::path& folder,
           const std::vector<std::string>& options, const std::vector<PieceTask>& tasks, const PieceEvents& events);
  void run();

 private:
  /// A task of the list.
  struct Piece {
    enum class State { waiting, submitted, ended } state = State::waiting;
    size_t attempts = 0;
    size_t batch = 0, index = 0;   ///< of the newest attempt
    unsigned unseen = 0;           ///< looks at the queue in a row that did not show it
    Stopwatch since_unseen;        ///< since the first of them
    unsigned next_accounting = 0;  ///< the unseen look from which accounting is asked again
    std::optional<SlurmTaskState> accounted;
    std::vector<std::string> notes;   ///< how each attempt failed
    std::set<std::string> failed_on;  ///< nodes
    void seen() { unseen = next_accounting = 0, accounted.reset(); }
  };
  struct Batch {
    SlurmBatch files;
    std::string name;                     ///< of Slurm's job
    std::map<std::string, size_t> index;  ///< of the array's task, by the piece's name
  };
  using Array = std::vector<std::vector<size_t>>;  ///< the pieces of each task of an array

  void open_folder();
  void attach();
  void add_batch(size_t number, const std::vector<std::vector<BatchPiece>>& tasks);
  void submit_waiting();
  void submit(const Array& array, bool exclusive, const std::set<std::string>& excluded);
  void take_ended();
  void take(size_t piece, Batch& batch, const std::string& name);
  void look();
  void lose(size_t piece, const SlurmTaskState* state);
  void fail(size_t piece, const std::string& note, const std::string& node, ChildResult child, PieceMachine machine);
  void blame(const Piece& piece);
  void show_progress();
  void leave();
  void clean_up();
  std::vector<std::string> names() const;

  const std::filesystem::path& program_;
  const std::filesystem::path& folder_;
  const std::vector<std::string>& options_;
  const std::vector<PieceTask>& tasks_;
  const PieceEvents& events_;

  std::string run_name_;
  std::vector<Piece> pieces_;
  std::map<std::string, size_t> by_name_;
  std::map<size_t, Batch> batches_;
  size_t last_number_ = 0;                        ///< of a batch
  std::map<SlurmTaskId, SlurmTaskState> states_;  ///< at the last look
  std::map<std::string, size_t> node_failures_;   ///< that others made good
  std::set<std::string> bad_nodes_;
  size_t largest_ = 0, ended_ = 0, failed_ = 0;
  bool silent_ = false;  ///< squeue does not answer
  std::string refusal_;  ///< of sbatch, for the time being
  Stopwatch since_look_, since_submission_;
  double look_seconds_ = 0;  ///< that the last one cost the site
};

}  // namespace lucarium
