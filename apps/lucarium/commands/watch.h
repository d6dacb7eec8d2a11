// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace lucarium::app {

/// What makes a picture stale when it changes: files, which need not exist, or folders.
struct WatchedInputs {
  std::vector<std::filesystem::path> scene;
  std::vector<std::filesystem::path> plugins;  ///< folders: every .so in them
  std::vector<std::filesystem::path> kernels;  ///< folders: everything below them
};

/// Looks at inputs again and again, for a program that goes on meanwhile.
class InputWatcher {
 public:
  explicit InputWatcher(WatchedInputs inputs);
  ~InputWatcher();
  /// The file that is new, gone or different and has then stayed as it is for a moment (builds write in several steps);
  /// empty: none. Cheap: looks a few times a second at most. Each change is returned once.
  std::filesystem::path changed();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// This process's command line, the program by its real path.
std::vector<std::string> own_command_line();

/// In a render that render_and_watch() has started: reports to that process, when this object ends, which kernels were
/// used, and which plug-in if that was found. In another process it does nothing.
class UsedInputs {
 public:
  UsedInputs() = default;
  ~UsedInputs();
  UsedInputs(const UsedInputs&) = delete;
  UsedInputs& operator=(const UsedInputs&) = delete;
  /// `searched`: the folders of plug-ins, in their order.
  void set_plugin(const std::filesystem::path& file, const std::vector<std::filesystem::path>& searched);

 private:
  std::vector<std::filesystem::path> plugins_;
};

/// The files of a scene: itself, its sidecar, the buffers and images it names, and an environment file as --environment
/// gives it. A built-in scene has none.
std::vector<std::filesystem::path> scene_files(const std::string& scene, const std::string& environment);

/// Renders in a process of its own, then again whenever an input changes, until interrupted; returns 0, or the code of
/// ErrorClass::interrupted when no picture was finished. Of `inputs` those count that the last render has used, or all
/// where it did not report them. A render that fails, or dies, says why and leaves the files of the last good one. The
/// process is this one's command line without --watch and, where it has outputs, with --overwrite, so that plug-ins are
/// loaded again.
int render_and_watch(const WatchedInputs& inputs, bool has_outputs);

}  // namespace lucarium::app
