// SPDX-License-Identifier: Apache-2.0
// lucarium scene: what is in a scene, and what looks wrong with it.
#include <CLI/CLI.hpp>

#include "commands.h"
#include "lucarium/scene/scene_report.h"
#include "options.h"

namespace lucarium::app {
namespace {

struct SceneCommandArguments {
  std::string scene;
  SceneArguments overrides;
  OutputArguments output;
};

int scene(const SceneCommandArguments& arguments) {
  arguments.output.apply();
  const SceneReport report = make_scene_report(arguments.overrides.load(arguments.scene));
  fmt::print("{}", arguments.output.json ? report.json() + "\n" : report.text());
  return 0;
}

}  // namespace

void add_scene_command(CLI::App& program, Action& action) {
  auto arguments = std::make_shared<SceneCommandArguments>();
  CLI::App& command = *program.add_subcommand("scene", "report what is in a scene");
  command.add_option("scene", arguments->scene, ".gltf, .glb or builtin:NAME")->required();
  arguments->overrides.add_to(command);
  arguments->output.add_to(command);
  command.callback([arguments, &action] { action = [arguments] { return scene(*arguments); }; });
}

}  // namespace lucarium::app
