// SPDX-License-Identifier: Apache-2.0
// lucarium scene: what is in a scene, and what looks wrong with it; what its surface atlas looks like.

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/terminal.h"
#include "lucarium/scene/gltf/export.h"
#include "lucarium/scene/report/scene_report.h"
#include "options/options.h"
#include "outputs/atlas_pictures.h"
#include "outputs/output_files.h"

namespace lucarium::app {
namespace {

struct SceneCommandArguments {
  std::string scene;
  SceneArguments overrides;
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

int scene(const SceneCommandArguments& arguments, const Messages& messages) {
  const Scene loaded = arguments.overrides.load(arguments.scene);
  const SceneReport report = make_scene_report(loaded);
  if (!arguments.export_file.empty()) export_scene(arguments, loaded);
  arguments.atlas.check(arguments.overwrite);
  const std::optional<SurfaceAtlasReport> atlas = draw_atlas(arguments.atlas, loaded, messages.quiet);
  if (messages.json) {
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
  command.option("scene", arguments->scene).required();
  command.option("--export", arguments->export_file).default_text("none");
  command.flag("--overwrite", arguments->overwrite);
  arguments->overrides.add_exposure_to(command);
  arguments->overrides.add_to(command);
  arguments->atlas.add_to(command);
  command.needs({"--exposure"}, {"--export"});  // whose sidecar states it
  command.needs({"--overwrite"}, {"--export", "--atlas", "--atlas-view"});
  command.examples({"lucarium scene builtin:atrium",
                    "lucarium scene builtin:cornell --material lamp:emissive_factor=40 --export bright.glb"},
                   "docs/scenes.md");
  command.callback(
      [arguments, &action] { action = [arguments](const Messages& messages) { return scene(*arguments, messages); }; });
}

}  // namespace lucarium::app
