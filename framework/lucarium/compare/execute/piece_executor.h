// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lucarium/base/child_process.h"
#include "lucarium/compare/results/machine.h"
#include "lucarium/job/job.h"

namespace lucarium {

/// A job that is independent of the others of its list.
struct PieceTask {
  std::string name;  ///< of its files, unique in the list
  Job job;
  std::filesystem::path lock;  ///< held while it runs, beside an output that other processes may write; empty: none
  std::string like;  ///< tasks with the same text have their times compared: they run alike, one after another
};

/// How a task ended. Its output is where the job says.
struct PieceEnd {
  ChildResult child;
  std::string failure;  ///< empty: it did what it should; else how it ended, where several attempts were made, and what
                        ///< it said last
  PieceMachine machine;
};

/// What a PieceExecutor reports, all of it in the thread that called run().
struct PieceEvents {
  std::function<void(size_t task)> on_start;                        ///< as far as this is seen from here
  std::function<void(size_t task, std::string_view line)> on_line;  ///< of its standard error
  std::function<void(size_t task, PieceEnd end)> on_end;
  std::function<void(const std::string& line)> say;                        ///< for people, about the whole
  std::function<void(double fraction, const std::string& text)> progress;  ///< of the whole, for one line
  std::string how_to_attach = "--resume attaches to them again";           ///< to tasks that an interrupt leaves
};

/// Runs jobs, each in a process of its own, on whatever machines it has.
class PieceExecutor {
 public:
  virtual ~PieceExecutor() = default;
  /// Returns when all tasks have ended, and early after an interrupt; on_end is then called for those alone that ended.
  /// What an event throws stops the tasks and is thrown from here. Throws Error{input} where nothing can be started.
  virtual void run(const std::vector<PieceTask>& tasks, const PieceEvents& events) = 0;
  /// Tasks that are sensible at the same time.
  virtual size_t width() const = 0;
  /// Whether PieceEvents::progress is called, so that lines about each task are too many.
  virtual bool shows_progress() const { return false; }
  /// Whether tasks go on after an interrupt, for a later run() to take.
  virtual bool keeps_tasks() const { return false; }
};

struct ExecutorOptions {
  enum class Kind { local, slurm } kind = Kind::local;
  std::vector<std::string> devices;  ///< local: as --device takes them, shared by the tasks; empty: each job's own
  std::vector<std::string> slurm;    ///< options of sbatch, "partition=long"
};

/// `program`: the lucarium executable. `folder`: of the files of jobs that others run; made when it is needed. Throws
/// Error{usage} for options that cannot be.
std::unique_ptr<PieceExecutor> make_executor(const ExecutorOptions& options, const std::filesystem::path& program,
                                             const std::filesystem::path& folder);

}  // namespace lucarium
