// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/slurm_commands.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/text/text_values.h"

namespace lucarium {
namespace {

constexpr size_t usual_array = 1000;

// Set here, or of no use for arrays whose tasks are retried by name.
constexpr std::array own_options = {"array",   "output",       "error",  "job-name", "open-mode",
                                    "requeue", "no-requeue",   "wrap",   "parsable", "test-only",
                                    "wait",    "get-user-env", "export", "chdir",    "dependency"};

constexpr std::array active_states = {"PENDING",      "RUNNING",  "SUSPENDED",    "COMPLETING",   "CONFIGURING",
                                      "RESIZING",     "REQUEUED", "REQUEUE_FED",  "SIGNALING",    "STAGE_OUT",
                                      "REQUEUE_HOLD", "STOPPED",  "SPECIAL_EXIT", "RESV_DEL_HOLD"};

std::string last_line(const ChildResult& child) {
  return child.last_words.empty() ? describe_end(child) : child.last_words.back();
}

std::optional<size_t> read_index(std::string_view text) {
  size_t index = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return index;
}

}  // namespace

bool SlurmTaskState::active() const {
  return std::any_of(active_states.begin(), active_states.end(), [this](const char* name) { return state == name; });
}

bool SlurmTaskState::stuck() const {
  return (state == "PENDING" || state == "REQUEUE_HOLD" || state == "SPECIAL_EXIT") &&
         (reason.starts_with("launch_failed") || reason.starts_with("launch failed"));
}

void check_slurm_options(const std::vector<std::string>& options) {
  for (const std::string& option : options) {
    const std::string name = option.substr(0, option.find('='));
    if (name.empty() || name.front() == '-')
      throw_error(ErrorClass::usage, "--slurm '{}': give an option of sbatch without dashes, as in partition=long",
                  option);
    if (std::find(own_options.begin(), own_options.end(), name) != own_options.end())
      throw_error(ErrorClass::usage, "--slurm {}: {} is set by the program", option, name);
  }
}

std::string submit_array(const SlurmSubmission& submission) {
  std::vector<std::string> arguments = {"sbatch",
                                        "--parsable",
                                        "--job-name=" + submission.name,
                                        fmt::format("--array=0-{}", submission.tasks - 1),
                                        "-o",
                                        (submission.log_folder / "%a.txt").string(),
                                        "--open-mode=append",
                                        "--no-requeue"};
  if (submission.exclusive) arguments.emplace_back("--exclusive");
  if (!submission.excluded_nodes.empty())
    arguments.push_back(fmt::format("--exclude={}", fmt::join(submission.excluded_nodes, ",")));
  for (const std::string& option : submission.options) arguments.push_back("--" + option);
  const ChildResult child = run_child(arguments, {}, submission.script);
  if (child.exit_code == 0) return "";
  // Slurm may have it all the same, and the answer was lost.
  const auto states = query_arrays({submission.name});
  return states && !states->empty() ? "" : last_line(child);
}

std::optional<std::map<SlurmTaskId, SlurmTaskState>> query_arrays(const std::vector<std::string>& names) {
  const ChildResult child =
      run_child({"squeue", "--noheader", "--array", "--states=all", fmt::format("--name={}", fmt::join(names, ",")),
                 "--format=%j|%K|%T|%N|%r|%F_%K"});
  if (child.exit_code != 0) return std::nullopt;
  std::map<SlurmTaskId, SlurmTaskState> states;
  for (const std::string& line : split(child.out, '\n')) {
    const std::vector<std::string> fields = split(line, '|');
    if (fields.size() != 6) continue;
    if (const std::optional<size_t> index = read_index(fields[1]))
      states[{fields[0], *index}] = {fields[2], fields[3], fields[4], fields[5]};
  }
  return states;
}

std::map<SlurmTaskId, SlurmTaskState> query_accounting(const std::vector<std::string>& names) {
  std::map<SlurmTaskId, SlurmTaskState> states;
  try {
    const ChildResult child =
        run_child({"sacct", "--noheader", "--parsable2", "--allocations", "--starttime=now-7days",
                   fmt::format("--name={}", fmt::join(names, ",")), "--format=JobName,JobID,State,NodeList"});
    if (child.exit_code != 0) return states;
    for (const std::string& line : split(child.out, '\n')) {
      const std::vector<std::string> fields = split(line, '|');
      if (fields.size() != 4) continue;
      const size_t underscore = fields[1].find('_');
      if (underscore == std::string::npos) continue;
      if (const std::optional<size_t> index = read_index(std::string_view(fields[1]).substr(underscore + 1)))
        states[{fields[0], *index}] = {fields[2].substr(0, fields[2].find(' ')), fields[3], "", ""};
    }
  } catch (const Error&) {  // there is no sacct
  }
  return states;
}

void cancel_task(const std::string& id) {
  try {
    run_child({"scancel", id});
  } catch (const Error&) {  // there is no scancel: it stays where it is
  }
}

size_t largest_array() {
  constexpr std::string_view key = "MaxArraySize";
  try {
    const ChildResult child = run_child({"scontrol", "show", "config"});
    for (const std::string& line : split(child.out, '\n')) {
      if (!line.starts_with(key)) continue;
      const size_t digits = line.find_first_of("0123456789");
      if (digits == std::string::npos) continue;
      // Indices are below it.
      if (const std::optional<size_t> size = read_index(std::string_view(line).substr(digits)); size && *size > 1)
        return std::min(*size - 1, usual_array);
    }
  } catch (const Error&) {  // there is no scontrol
  }
  return usual_array;
}

std::string cancel_hint(const std::vector<std::string>& names) {
  return fmt::format("scancel --name={}", fmt::join(names, ","));
}

}  // namespace lucarium
