// SPDX-License-Identifier: Apache-2.0
// lucarium scene: what is in a scene, and what looks wrong with it; what its surface atlas looks like.

#include "atlas_pictures.h"
#include "commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/terminal.h"
#include "lucarium/scene/gltf/export.h"
#include "lucarium/scene/report/scene_report.h"
#include "options.h"
#include "output_files.h"

namespace lucarium::app {
namespace {

struct SceneCommandArguments {
  std::string scene;
  SceneArguments overrides;
  OutputArguments output;
  std::filesystem::path export_file;
  AtlasArguments atlas;
  bool overwrite = false;
};

void export_scene(const SceneCommandArguments& arguments, const Scene& scene) {
  if (arguments.export_file.extension() != ".glb") {
    throw_error(ErrorClass::usage, "{}: the name must end in .glb", arguments.export_file.string());
  }
  for (const std::filesystem::path& file : exported_files(scene, arguments.export_file)) {
    check_output(file, arguments.overwrite);
  }
  export_gltf(scene, arguments.export_file);
}

int scene(const SceneCommandArguments& arguments) {
  arguments.output.apply();
  const Scene loaded = arguments.overrides.load(arguments.scene);
  const SceneReport report = make_scene_report(loaded);
  if (!arguments.export_file.empty()) export_scene(arguments, loaded);
  arguments.atlas.check(arguments.overwrite);
  const std::optional<SurfaceAtlasReport> atlas = draw_atlas(arguments.atlas, loaded, arguments.output.quiet);
  if (arguments.output.json) {
    print_result("{}\n", atlas ? with_atlas(report.json(), *atlas) : report.json());
  } else {
    print_result("{}{}", report.text(), atlas ? text_of(*atlas) : "");
  }
  return 0;
}

}  // namespace

void add_scene_command(Command program, Action& action) {
  auto arguments = std::make_shared<SceneCommandArguments>();
  Command command = program.add_subcommand("scene", "report what is in a scene");
  command.add_option("scene", arguments->scene, ".gltf, .glb or builtin:NAME")->required();
  arguments->overrides.add_to(command);
  command.add_option("--export", arguments->export_file, "write the scene as it is understood to FILE.glb");
  arguments->atlas.add_to(command);
  command.add_flag("--overwrite", arguments->overwrite, "replace existing files");
  arguments->output.add_to(command);
  command.callback([arguments, &action] { action = [arguments] { return scene(*arguments); }; });
}

}  // namespace lucarium::app
