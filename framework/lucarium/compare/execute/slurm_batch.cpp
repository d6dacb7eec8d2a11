// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/execute/slurm_batch.h"

#include <fstream>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/json.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compare/execute/array_task.h"
#include "lucarium/compare/execute/warm_up.h"
#include "lucarium/job/job_file.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;
namespace {

constexpr const char* tasks_name = "tasks.jsonl";

/// The output that is the batch's until its piece has ended; null: it grows in place.
fs::path* moved_output(Job& job) {
  if (auto* render = std::get_if<RenderWork>(&job.work)) return &render->output;
  auto& reference = std::get<ReferenceWork>(job.work);
  return reference.round_samples > 0 ? &reference.output : nullptr;
}

ordered_json line_of(const std::vector<BatchPiece>& pieces) {
  ordered_json line = ordered_json::array();
  for (const BatchPiece& piece : pieces)
    line.push_back(
        {{"name", piece.name}, {"job", piece.job}, {"warm_up", piece.warm_up}, {"lock", piece.lock.string()}});
  return line;
}

std::vector<BatchPiece> read_line(const std::string& line) {
  std::vector<BatchPiece> pieces;
  for (const json& piece : json::parse(line))
    pieces.push_back({piece.at("name"), piece.at("job"), piece.at("warm_up"), piece.at("lock").get<std::string>()});
  return pieces;
}

/// The text as one word of a shell.
std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace

BatchPiece SlurmBatch::piece_of(const PieceTask& task) const {
  Job job = task.job;
  if (fs::path* output = moved_output(job); output && !output->empty())
    *output = folder_ / "images" / (task.name + ".exr");
  return {task.name, job_json(job), warm_up_text(job, folder_.parent_path() / warm_folder), task.lock};
}

void SlurmBatch::write(const std::vector<std::vector<BatchPiece>>& tasks) const {
  for (const char* name : {"ended", "images", "log"}) fs::create_directories(folder_ / name);
  std::string text;
  for (const std::vector<BatchPiece>& pieces : tasks) text += line_of(pieces).dump() + "\n";
  write_file_atomically(folder_ / tasks_name, text);
}

std::vector<std::vector<BatchPiece>> SlurmBatch::read() const {
  std::vector<std::vector<BatchPiece>> tasks;
  for (const std::string& line : split(read_file(folder_ / tasks_name), '\n'))
    if (!line.empty()) tasks.push_back(read_line(line));
  return tasks;
}

std::vector<BatchPiece> SlurmBatch::read(size_t index) const {
  std::ifstream file(folder_ / tasks_name);
  std::string line;
  for (size_t i = 0; i <= index; ++i) {
    if (!std::getline(file, line))
      throw_error(ErrorClass::input, "{}: there is no task {}", (folder_ / tasks_name).string(), index);
  }
  return read_line(line);
}

std::string SlurmBatch::script(const fs::path& program) const {
  return fmt::format("#!/bin/sh\nunset LUCARIUM_PARENT_PROCESS\nexec {} {} {} \"$SLURM_ARRAY_TASK_ID\"\n",
                     quoted(program.string()), array_task_command, quoted(folder_.string()));
}

void SlurmBatch::write_ended(const std::string& name, const EndedPiece& piece) const {
  const ordered_json json = {{"exit_code", piece.child.exit_code},
                             {"signal", piece.child.signal},
                             {"out", piece.child.out},
                             {"last_words", piece.child.last_words},
                             {"seconds", piece.child.seconds},
                             {"peak_memory_bytes", piece.child.peak_memory_bytes},
                             {"machine", piece_machine_json(piece.machine)},
                             {"node", piece.node}};
  write_file_atomically(ended_file(name), json.dump(1, ' ', false, ordered_json::error_handler_t::replace));
}

std::vector<std::string> SlurmBatch::list_ended() const {
  std::vector<std::string> names;
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder(folder_ / "ended", failure)) {
    const std::string name = entry.path().filename().string();
    if (name.front() != '.' && entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  return names;
}

void SlurmBatch::renew_view() const {
  // A change of one's own makes NFS ask the server what is in the folder.
  const fs::path mark = folder_ / "ended" / ".seen";
  std::ofstream(mark).close();
  std::error_code ignored;
  fs::remove(mark, ignored);
}

bool SlurmBatch::is_whole() const { return fs::exists(folder_ / tasks_name); }

bool SlurmBatch::has_ended(const std::string& name) const { return fs::exists(ended_file(name)); }

EndedPiece SlurmBatch::read_ended(const std::string& name) const {
  const fs::path file = ended_file(name);
  try {
    const json json = json::parse(read_file(file));
    EndedPiece piece;
    piece.child.exit_code = json.at("exit_code");
    piece.child.signal = json.at("signal");
    piece.child.out = json.at("out");
    piece.child.last_words = json.at("last_words").get<std::vector<std::string>>();
    piece.child.seconds = json.at("seconds");
    piece.child.peak_memory_bytes = json.at("peak_memory_bytes");
    piece.machine = read_piece_machine(json.at("machine"));
    piece.node = json.at("node");
    return piece;
  } catch (const json::exception& error) {
    throw_error(ErrorClass::input, "{}: {}", file.string(), error.what());
  }
}

void SlurmBatch::take_image(const PieceTask& task) const {
  Job job = task.job;
  const fs::path* output = moved_output(job);
  if (!output || output->empty()) return;
  const fs::path image = folder_ / "images" / (task.name + ".exr");
  std::error_code failure;
  if (!fs::exists(image) && fs::exists(*output)) return;
  fs::rename(image, *output, failure);
  if (failure)
    throw_error(ErrorClass::input, "cannot move {} to {}: {}", image.string(), output->string(), failure.message());
}

void SlurmBatch::remove_ended(const std::string& name) const {
  std::error_code ignored;
  fs::remove(ended_file(name), ignored);
  fs::remove(folder_ / "images" / (name + ".exr"), ignored);
}

std::string SlurmBatch::last_words(size_t index) const {
  try {
    const std::vector<std::string> lines = split(read_file(log_of(index)), '\n');
    for (auto line = lines.rbegin(); line != lines.rend(); ++line)
      if (!line->empty()) return *line;
  } catch (const Error&) {  // it said nothing
  }
  return "";
}

}  // namespace lucarium
