// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compare/results/result_folder.h"

#include <array>
#include <regex>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/json.h"
#include "lucarium/compare/request/comparison_file.h"

namespace lucarium {
namespace fs = std::filesystem;
using nlohmann::ordered_json;

namespace {

constexpr const char* comparison_file = "comparison.json";
constexpr std::array written_files = {"results.json", "results.csv", "curves.csv", "report.html"};
constexpr std::array written_folders = {"pieces", "references", "means", "report_images"};

/// Whether a file is byte for byte what ComparisonSpec::to_json() could have written. One that a person wrote has
/// comments, or lines of another shape.
bool is_written_comparison(const fs::path& file) {
  try {
    const std::string text = read_file(file);
    const ordered_json json = ordered_json::parse(text);
    return json.is_object() && json.value("schema", "") == comparison_schema && json.dump(2) + "\n" == text;
  } catch (const std::exception&) {
    return false;
  }
}

bool is_written_name(const std::string& name) {
  static const std::regex names(R"((scene\d+-(variant\d+-budget\d+(-seed\d+)?|set\d+)\.(exr|json)|\d+\.js))"  // results
                                R"(|\.scene\d+-.*\.\d+-\d+\.part\.(exr|json))");  // what a killed run left
  return std::regex_match(name, names);
}

void remove_file(const fs::path& file) {
  std::error_code failure;
  fs::remove(file, failure);
  if (failure) throw_error(ErrorClass::input, "cannot remove {}: {}", file.string(), failure.message());
}

}  // namespace

fs::path find_foreign_file(const fs::path& folder) {
  if (is_written_comparison(folder / comparison_file)) return {};
  std::error_code failure;
  if (fs::exists(fs::symlink_status(folder / comparison_file, failure))) return folder / comparison_file;
  for (const char* name : written_files) {
    if (fs::exists(fs::symlink_status(folder / name, failure))) return folder / name;
  }
  for (const char* name : written_folders) {
    const fs::path place = folder / name;
    const bool empty = fs::is_directory(place, failure) && fs::is_empty(place, failure);
    if (!empty && fs::exists(fs::symlink_status(place, failure))) return place;
  }
  return {};
}

void remove_written_files(const fs::path& folder) {
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder(folder, failure)) {
    if (is_written_name(entry.path().filename().string())) remove_file(entry.path());
  }
  fs::remove(folder, failure);  // unless something else is in it
}

/// Jobs that still want them end with an error.
void remove_slurm_files(const fs::path& folder) {
  static const std::regex names(R"(batch\d+|warm|run\.txt)");
  std::error_code failure;
  for (const fs::directory_entry& entry : list_folder(folder, failure)) {
    if (std::regex_match(entry.path().filename().string(), names)) fs::remove_all(entry.path(), failure);
  }
  fs::remove(folder, failure);
}

void remove_results(const fs::path& folder) {
  remove_slurm_files(folder / slurm_folder / slurm_references);
  remove_slurm_files(folder / slurm_folder);
  for (const char* name : written_folders) remove_written_files(folder / name);
  for (const char* name : written_files) remove_file(folder / name);
  remove_file(folder / comparison_file);
}

}  // namespace lucarium
