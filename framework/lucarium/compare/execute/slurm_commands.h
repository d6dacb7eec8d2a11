// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lucarium {

/// One task of an array as Slurm sees it.
struct SlurmTaskState {
  std::string state;    ///< "RUNNING", "NODE_FAIL", …
  std::string node;     ///< empty before it has one
  std::string reason;   ///< "Resources", "None", …
  std::string id;       ///< as scancel takes it; empty: unknown
  bool active() const;  ///< waits, runs, or is about to
  /// Waits for a person: its node could not start it, and Slurm holds it.
  bool stuck() const;
};

/// Name of the array's job and index of the task.
using SlurmTaskId = std::pair<std::string, size_t>;

/// What sbatch is asked for.
struct SlurmSubmission {
  std::string name;                  ///< of the job
  size_t tasks = 0;                  ///< of the array
  std::filesystem::path log_folder;  ///< one file per task, named by its index
  bool exclusive = false;
  std::vector<std::string> excluded_nodes;
  std::vector<std::string> options;  ///< "partition=long", "exclusive": as sbatch takes them behind "--"
  std::string script;
};

/// Throws Error{usage} for an option of sbatch that the program sets itself.
void check_slurm_options(const std::vector<std::string>& options);

/// sbatch. Returns why Slurm did not take it; empty: it did, also where the answer was lost. Throws Error{input} where
/// there is no sbatch.
std::string submit_array(const SlurmSubmission& submission);

/// squeue: the states of all tasks of the jobs with these names that Slurm remembers; nothing: it did not answer.
std::optional<std::map<SlurmTaskId, SlurmTaskState>> query_arrays(const std::vector<std::string>& names);

/// sacct, for tasks that squeue has forgotten; what it says, or empty where there is no accounting.
std::map<SlurmTaskId, SlurmTaskState> query_accounting(const std::vector<std::string>& names);

/// scancel of one task, by its id; failures are ignored.
void cancel_task(const std::string& id);

/// The largest array that Slurm takes, by scontrol; 1000 where that does not answer.
size_t largest_array();

/// How to end the jobs whose names begin so, for people.
std::string cancel_hint(const std::vector<std::string>& names);

}  // namespace lucarium
