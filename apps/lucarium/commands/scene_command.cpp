// SPDX-License-Identifier: Apache-2.0
// lucarium scene: what is in a scene, and what looks wrong with it; what its surface atlas looks like. Declared in
// commands.h.

#include "commands/commands.h"
#include "lucarium/base/error.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/scene/builtin/scenes.h"
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

/// Returns what it wrote: the scene, and the sidecar with what glTF has no words for.
std::vector<std::filesystem::path> export_scene(const SceneCommandArguments& arguments, const Scene& scene) {
  if (arguments.export_file.empty()) return {};
  if (arguments.export_file.extension() != ".glb") {
    throw_error(ErrorClass::usage, "{}: the name must end in .glb", arguments.export_file.string());
  }
  std::vector<std::filesystem::path> files = exported_files(scene, arguments.export_file);
  for (const std::filesystem::path& file : files) check_output(file, arguments.overwrite);
  export_gltf(scene, arguments.export_file);
  return files;
}

std::string json_of(const SceneReport& report, const std::vector<std::filesystem::path>& exported,
                    const std::optional<SurfaceAtlasReport>& atlas) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(report.json());
  for (const std::filesystem::path& file : exported) json["exported"].push_back(file.string());
  return atlas ? with_atlas(json.dump(2), *atlas) : json.dump(2);
}

/// The scenes that need no file, each with what may be given behind its name.
int list_scenes(const Messages& messages) {
  nlohmann::ordered_json json = {{"schema", "lucarium-scenes-1"}, {"scenes", nlohmann::ordered_json::array()}};
  for (const std::string& name : builtin_scene_names()) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    if (!messages.json) print_result("builtin:{}\n", name);
    for (const BuiltinParameter& parameter : builtin_scene_parameters(name)) {
      parameters.push_back({{"name", parameter.name},
                            {"doc", parameter.doc},
                            {"default", parameter.value},
                            {"min", parameter.min},
                            {"max", parameter.max}});
      if (!messages.json)
        print_result("  :{}={:<8} {} to {}: {}\n", parameter.name, parameter.value, parameter.min, parameter.max,
                     parameter.doc);
    }
    json["scenes"].push_back({{"name", "builtin:" + name}, {"parameters", std::move(parameters)}});
  }
  if (messages.json) print_result("{}\n", json.dump(2));
  return 0;
}

int scene(const SceneCommandArguments& arguments, const Messages& messages) {
  if (arguments.scene.empty()) return list_scenes(messages);
  const Scene loaded = arguments.overrides.load(arguments.scene);
  const SceneReport report = make_scene_report(loaded);
  const std::vector<std::filesystem::path> exported = export_scene(arguments, loaded);
  arguments.atlas.check(arguments.overwrite);
  const std::optional<SurfaceAtlasReport> atlas = draw_atlas(arguments.atlas, loaded, messages.quiet);
  if (messages.json) {
    print_result("{}\n", json_of(report, exported, atlas));
  } else {
    print_result("{}{}", report.text(), atlas ? text_of(*atlas) : "");
    for (const std::filesystem::path& file : exported) print_result("exported      {}\n", file.string());
  }
  return 0;
}

}  // namespace

void add_scene_command(Command program, Action& action) {
  auto arguments = std::make_shared<SceneCommandArguments>();
  Command command = program.add_subcommand("scene", "report what is in a scene, or list the built-in ones");
  command.option("scene", arguments->scene).default_text("list the built-in scenes");
  command.option("--export", arguments->export_file).default_text("none");
  command.flag("--overwrite", arguments->overwrite);
  arguments->overrides.add_exposure_to(command);
  arguments->overrides.add_to(command);
  arguments->atlas.add_to(command);
  command.needs({"--export", "--atlas", "--atlas-view", "--camera", "--camera-path", "--environment", "--light",
                 "--material", "--at", "--animation", "--no-sidecar", "--texture-size"},
                {"scene"});
  command.needs({"--exposure"}, {"--export"});  // whose sidecar states it
  command.needs({"--overwrite"}, {"--export", "--atlas", "--atlas-view"});
  command.examples({"lucarium scene builtin:atrium",
                    "lucarium scene builtin:cornell --material lamp:emissive_factor=40 --export bright.glb"},
                   "docs/scenes.md");
  command.callback(
      [arguments, &action] { action = [arguments](const Messages& messages) { return scene(*arguments, messages); }; });
}

}  // namespace lucarium::app
