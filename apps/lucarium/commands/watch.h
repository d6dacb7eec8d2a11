// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace lucarium::app {

/// What makes a picture stale when it changes.
struct WatchedInputs {
  std::vector<std::filesystem::path> files;    ///< need not exist
  std::vector<std::filesystem::path> plugins;  ///< folders: every .so in them
  std::vector<std::filesystem::path> kernels;  ///< folders: everything below them
};

/// The files of a scene: itself, its sidecar, the buffers and images it names, and an environment file as --environment
/// gives it. A built-in scene has none.
std::vector<std::filesystem::path> scene_files(const std::string& scene, const std::string& environment);

/// Renders in a process of its own, then again whenever an input changes, until interrupted; returns 0, or the code of
/// ErrorClass::interrupted when no picture was finished. A render that fails, or dies, says why and leaves the files of
/// the last good one. The process is this one's command line without --watch and, where it has outputs, with
/// --overwrite, so that plug-ins are loaded again.
int render_and_watch(const WatchedInputs& inputs, bool has_outputs);

}  // namespace lucarium::app
