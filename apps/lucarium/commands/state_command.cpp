// SPDX-License-Identifier: Apache-2.0
// lucarium state: what is in a file of --save-state, and whether it is whole. Declared in commands.h.
#include "commands/commands.h"
#include "lucarium/base/json.h"
#include "lucarium/base/terminal.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/technique/state_file.h"

namespace lucarium::app {
namespace {

using nlohmann::ordered_json;

std::string json_of(const StateFile& state) {
  const StateHeader& header = state.header();
  ordered_json json = {{"schema", "lucarium-state-1"},
                       {"file", state.path().string()},
                       {"file_bytes", state.file_bytes()},
                       {"version", header.program_version},
                       {"scene", header.scene},
                       {"scene_hash", header.scene_hash},
                       {"technique", header.technique},
                       {"technique_version", header.technique_version},
                       {"parameters", ordered_json::object()},
                       {"path_set", header.path_set},
                       {"max_bounces", header.max_bounces},
                       {"seed", header.seed},
                       {"width", header.width},
                       {"height", header.height},
                       {"seconds", header.seconds},
                       {"chunks", ordered_json::array()}};
  for (const auto& [name, value] : header.parameters) json["parameters"][name] = value;
  for (const StateChunk& chunk : state.chunks()) {
    json["chunks"].push_back({{"name", chunk.name},
                              {"elements", chunk.elements},
                              {"element_bytes", chunk.element_bytes},
                              {"stored_bytes", chunk.stored_bytes},
                              {"compressed", chunk.compressed}});
  }
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace);
}

std::string text_of(const StateFile& state) {
  const StateHeader& header = state.header();
  std::string parameters;
  for (const auto& [name, value] : header.parameters)
    parameters += fmt::format("{}{}={}", parameters.empty() ? "" : ",", name, value);
  std::string text =
      fmt::format("state         {}, {}, whole\n", state.path().string(), format_bytes(state.file_bytes()));
  text += fmt::format("scene         {} ({})\n", header.scene, header.scene_hash);
  text += fmt::format("technique     {} {}, seed {}\n", header.technique, header.technique_version, header.seed);
  text += fmt::format("parameters    {}\n", parameters);
  text += fmt::format("light paths   {}\n", header.path_set);
  text += fmt::format("saved by      lucarium {}, whose light took {:.1f} s, at {}x{} pixels\n", header.program_version,
                      header.seconds, header.width, header.height);
  text += fmt::format("chunks        {}\n", state.chunks().size());
  for (const StateChunk& chunk : state.chunks()) {
    text += fmt::format("              {}: {} x {} bytes{}\n", chunk.name, chunk.elements, chunk.element_bytes,
                        chunk.compressed ? fmt::format(", {} stored", format_bytes(chunk.stored_bytes)) : "");
  }
  return text;
}

}  // namespace

void add_state_command(Command program, Action& action) {
  auto file = std::make_shared<std::filesystem::path>();
  Command command = program.add_subcommand("state", "report what is in a saved state");
  command.option("state", *file).required();
  command.examples({"lucarium state cornell.state", "lucarium state --json cornell.state"}, "docs/state_files.md");
  command.callback([file, &action] {
    action = [file](const Messages& messages) {
      const StateFile state(*file);
      if (messages.json) {
        print_result("{}\n", json_of(state));
      } else {
        print_result("{}", text_of(state));
      }
      return 0;
    };
  });
}

}  // namespace lucarium::app
