// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lucarium/compare/execute/piece_executor.h"

namespace lucarium {

/// A task as a node gets it: what it writes is the batch's until it has ended.
struct BatchPiece {
  std::string name, job;  ///< the job as JSON, with the output below
  std::string warm_up;    ///< the job as JSON that compiles what it needs
  std::filesystem::path lock;
  bool operator==(const BatchPiece&) const = default;
};

/// How a piece ended on a node.
struct EndedPiece {
  ChildResult child;
  PieceMachine machine;
  std::string node;
};

/// One array on disk, in a folder that all nodes see: what each of its tasks has to do, and what they left. The folder
/// holds tasks.jsonl (one line per task of the array), ended/NAME.json, images/NAME.exr and log/INDEX.txt.
class SlurmBatch {
 public:
  explicit SlurmBatch(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path log_folder() const { return folder_ / "log"; }
  std::filesystem::path log_of(size_t index) const { return log_folder() / (std::to_string(index) + ".txt"); }

  /// The piece of a task: its output goes below the batch's folder, unless that grows in place under a lock.
  BatchPiece piece_of(const PieceTask& task) const;

  /// Each item: the pieces that one task of the array does one after another.
  void write(const std::vector<std::vector<BatchPiece>>& tasks) const;
  std::vector<std::vector<BatchPiece>> read() const;
  /// The pieces of one task alone.
  std::vector<BatchPiece> read(size_t index) const;

  /// What Slurm runs for each task: a script that starts the program with array_task_command.
  std::string script(const std::filesystem::path& program) const;

  void write_ended(const std::string& name, const EndedPiece& piece) const;
  /// Names of the pieces that have ended and were not taken yet.
  std::vector<std::string> list_ended() const;
  /// Asks a shared folder again which pieces have ended: it may show late what a node wrote.
  void renew_view() const;
  /// Its tasks are written down, so that they may have been submitted.
  bool is_whole() const;
  bool has_ended(const std::string& name) const;
  EndedPiece read_ended(const std::string& name) const;
  /// Moves the piece's image to where its task wants it, unless an earlier call did.
  void take_image(const PieceTask& task) const;
  void remove_ended(const std::string& name) const;

  /// The last lines that a task of the array left, newest last.
  std::string last_words(size_t index) const;

 private:
  std::filesystem::path ended_file(const std::string& name) const { return folder_ / "ended" / (name + ".json"); }
  std::filesystem::path folder_;
};

}  // namespace lucarium
