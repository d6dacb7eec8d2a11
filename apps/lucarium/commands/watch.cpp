// SPDX-License-Identifier: Apache-2.0
#include "commands/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>
#include <thread>

#include "lucarium/base/child_process.h"
#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/base/files/list_folder.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/text_values.h"
#include "lucarium/compute/program/source_library.h"

namespace lucarium::app {
namespace fs = std::filesystem;

namespace {

constexpr std::chrono::milliseconds poll_interval{200};

// How a render reports what it has used: as lines of its standard error, where this variable is set.
const char* const watched_variable = "LUCARIUM_WATCHED";
constexpr std::string_view plugin_line = "lucarium used plug-in ", kernel_line = "lucarium used kernel ";

struct Stamp {
  fs::file_time_type time;
  uintmax_t bytes = 0;
  bool operator==(const Stamp&) const = default;
};
using Snapshot = std::map<fs::path, Stamp>;

void add_file(Snapshot& snapshot, const fs::path& file) {
  std::error_code failure;
  const Stamp stamp{fs::last_write_time(file, failure), fs::file_size(file, failure)};
  if (!failure) snapshot[file] = stamp;
}

Snapshot take_snapshot(const WatchedInputs& inputs) {
  Snapshot snapshot;
  std::error_code failure;
  for (const auto* paths : {&inputs.scene, &inputs.plugins, &inputs.kernels}) {
    for (const fs::path& path : *paths) {
      if (!fs::is_directory(path, failure)) add_file(snapshot, path);
    }
  }
  for (const fs::path& folder : inputs.plugins) {
    for (const fs::directory_entry& entry : list_folder(folder, failure)) {
      if (entry.path().extension() == ".so") add_file(snapshot, entry.path());
    }
  }
  for (const fs::path& folder : inputs.kernels) {
    for (const fs::directory_entry& entry : list_folder<fs::recursive_directory_iterator>(folder, failure)) {
      if (entry.is_regular_file(failure)) add_file(snapshot, entry.path().lexically_normal());
    }
  }
  return snapshot;
}

/// Whether a file is one of the paths, or below one.
bool is_among(const fs::path& file, const std::vector<fs::path>& paths) {
  return std::any_of(paths.begin(), paths.end(), [&](const fs::path& path) {
    const auto [end, differs] = std::mismatch(path.begin(), path.end(), file.begin(), file.end());
    return end == path.end() || end->empty();  // an ending slash
  });
}

/// What is left of a snapshot of more inputs.
Snapshot only(Snapshot snapshot, const WatchedInputs& inputs) {
  std::erase_if(snapshot, [&](const auto& entry) {
    const fs::path& file = entry.first;
    return !is_among(file, inputs.scene) && !is_among(file, inputs.plugins) && !is_among(file, inputs.kernels);
  });
  return snapshot;
}

/// The paths that the lines name, if any does.
void take_reported(const std::vector<fs::path>& reported, std::vector<fs::path>& paths) {
  if (!reported.empty()) paths = reported;
}

void report(std::string_view line, const std::vector<fs::path>& paths) {
  const bool all_printable = std::all_of(
      paths.begin(), paths.end(), [](const fs::path& path) { return printable_line(path.string()) == path.string(); });
  if (!all_printable) return;  // then everything is watched
  for (const fs::path& path : paths) print_note("{}{}\n", line, path.string());
}

/// The first file that is new, gone or different.
fs::path changed_file(const Snapshot& before, const Snapshot& now) {
  for (const auto& [file, stamp] : now) {
    const auto known = before.find(file);
    if (known == before.end() || !(known->second == stamp)) return file;
  }
  for (const auto& [file, stamp] : before) {
    if (!now.contains(file)) return file;
  }
  return {};
}

/// Waits until something differs from `before` and then stays as it is for a moment (builds write in several steps).
/// Returns what changed; empty when interrupted.
fs::path wait_for_change(const WatchedInputs& inputs, const Snapshot& before) {
  Snapshot last = take_snapshot(inputs);
  while (!interrupt_requested()) {
    const fs::path file = changed_file(before, last);
    std::this_thread::sleep_for(poll_interval);
    Snapshot now = take_snapshot(inputs);
    if (!file.empty() && now == last) return file;
    last = std::move(now);
  }
  return {};
}

std::vector<std::string> render_words(bool overwrite) {
  std::vector<std::string> words = own_command_line();
  std::erase(words, "--watch");
  if (overwrite) words.emplace_back("--overwrite");
  return words;
}

/// The environment map that the sidecar names.
void add_sidecar_environment(const std::string& scene, std::vector<fs::path>& files) {
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(scene + ".lucarium.json"), nullptr, true, true);
    const std::string environment = json.value("environment", "");
    if (environment.empty()) return;
    files.push_back(fs::path(scene).parent_path() / environment.substr(0, environment.find_first_of("*@")));
  } catch (const std::exception&) {
    // There is none, or the render says what is wrong with it.
  }
}

}  // namespace

struct InputWatcher::State {
  WatchedInputs inputs;
  Snapshot told, last;
  std::chrono::steady_clock::time_point looked = std::chrono::steady_clock::now();
};

InputWatcher::InputWatcher(WatchedInputs inputs) : state_(std::make_unique<State>()) {
  state_->inputs = std::move(inputs);
  state_->told = state_->last = take_snapshot(state_->inputs);
}

InputWatcher::~InputWatcher() = default;

fs::path InputWatcher::changed() {
  State& s = *state_;
  if (std::chrono::steady_clock::now() - s.looked < poll_interval) return {};
  Snapshot now = take_snapshot(s.inputs);
  s.looked = std::chrono::steady_clock::now();
  const fs::path file = now == s.last ? changed_file(s.told, now) : fs::path();
  s.last = std::move(now);
  if (!file.empty()) s.told = s.last;
  return file;
}

std::vector<std::string> own_command_line() {
  std::ifstream command_line("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(command_line, word, '\0');) words.push_back(word);
  if (words.empty()) throw_error(ErrorClass::internal, "cannot read /proc/self/cmdline");
  words.front() = fs::read_symlink("/proc/self/exe").string();
  return words;
}

UsedInputs::~UsedInputs() {
  if (!std::getenv(watched_variable)) return;
  report(plugin_line, plugins_);
  std::vector<fs::path> kernels;
  for (const fs::path& root : kernel_path_roots()) {
    for (const std::string& name : asked_sources()) kernels.push_back((root / name).lexically_normal());
  }
  report(kernel_line, kernels);
}

void UsedInputs::set_plugin(const fs::path& file, const std::vector<fs::path>& searched) {
  // One of the same name in an earlier folder would be used instead.
  for (const fs::path& folder : searched) {
    if ((folder / file.filename()) == file) break;
    plugins_.push_back(folder / file.filename());
  }
  plugins_.push_back(file);
}

std::vector<fs::path> scene_files(const std::string& scene, const std::string& environment) {
  std::vector<fs::path> files;
  if (!environment.empty()) files.emplace_back(environment.substr(0, environment.find_first_of("*@")));
  if (scene.starts_with("builtin:")) return files;
  files.insert(files.end(), {scene, scene + ".lucarium.json"});
  if (environment.empty()) add_sidecar_environment(scene, files);
  if (!scene.ends_with(".gltf")) return files;
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(scene));
    for (const char* list : {"buffers", "images"}) {
      for (const nlohmann::json& item : json.value(list, nlohmann::json::array())) {
        const std::string uri = item.value("uri", "");
        if (!uri.empty() && !uri.starts_with("data:")) files.push_back(fs::path(scene).parent_path() / uri);
      }
    }
  } catch (const std::exception&) {
    // The render says what is wrong with the file.
  }
  return files;
}

int render_and_watch(const WatchedInputs& inputs, bool has_outputs) {
  const std::vector<std::string> words = render_words(has_outputs);
  ::setenv(watched_variable, "1", 1);
  const bool talks = log_level() >= LogLevel::warning;
  bool rendered = false;
  const auto end = [&rendered] { return rendered ? 0 : static_cast<int>(ErrorClass::interrupted); };
  const KeepOnInterrupt end_the_loop;
  while (true) {
    const Snapshot all = take_snapshot(inputs);
    std::vector<fs::path> plugins, kernels;
    const ChildResult result = run_child(words, [&](std::string_view line) {
      if (line.starts_with(plugin_line))
        plugins.emplace_back(line.substr(plugin_line.size()));
      else if (line.starts_with(kernel_line))
        kernels.emplace_back(line.substr(kernel_line.size()));
      else
        print_note("{}\n", line);
    });
    print_result("{}", result.out);
    flush_results();
    rendered |= result.exit_code == 0;
    if (interrupt_requested()) return end();
    WatchedInputs used = inputs;
    take_reported(plugins, used.plugins);
    take_reported(kernels, used.kernels);
    const Snapshot before = only(all, used);
    const std::string outcome = result.exit_code == 0
                                    ? fmt::format("rendered in {:.1f} s", result.seconds)
                                    : fmt::format("not rendered ({}): the last image is kept", describe_end(result));
    if (talks) print_note("{}; watching {}, Ctrl-C ends\n", outcome, counted(before.size(), "file"));
    const fs::path file = wait_for_change(used, before);
    if (file.empty()) return end();
    if (talks) print_note("{} changed\n", file.string());
  }
}

}  // namespace lucarium::app
