// SPDX-License-Identifier: Apache-2.0
// lucarium view: techniques live in a browser. Declared in commands.h.
#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <thread>

#include "commands/commands.h"
#include "commands/view_again.h"
#include "commands/watch.h"
#include "lucarium/base/error.h"
#include "lucarium/base/interrupt.h"
#include "lucarium/base/json.h"
#include "lucarium/base/log.h"
#include "lucarium/base/terminal.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/view/access.h"
#include "lucarium/view/hub.h"
#include "lucarium/view/server.h"
#include "lucarium/view/viewer.h"
#include "options/options.h"
#include "outputs/repeat_commands.h"

namespace lucarium::app {
using nlohmann::ordered_json;

namespace {

struct ViewArguments : RenderingArguments {
  ViewServerOptions server;
  bool open = false, watch = false;
  RenderBudget budget;
};

constexpr int largest_port = 65535;
constexpr double patience_at_end = 0.7;  // [s] for an iteration that is being done

/// Once the viewer has run, its pages hear of a technique that can no longer be loaded.
std::vector<ViewTechnique> techniques_of(const ViewArguments& arguments, const TechniqueRegistry& registry,
                                         bool is_known) {
  std::vector<TechniqueArguments::Spec> specs = arguments.technique.specs;
  if (specs.empty()) specs = {arguments.technique.single("view", "path_tracing")};
  std::vector<ViewTechnique> techniques;
  for (const TechniqueArguments::Spec& spec : specs) {
    if (!is_known) make_technique(registry.find(spec.name), spec);
    techniques.push_back({spec.name, spec.parameters});
  }
  return techniques;
}

/// Starts this system's browser; where there is none the address is on the terminal.
void open_page(const std::string& url) {
  std::string program = "xdg-open", address = url;
  std::array<char*, 3> words = {program.data(), address.data(), nullptr};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  if (::posix_spawnp(&child, program.c_str(), &actions, nullptr, words.data(), environ) != 0)
    log_warning("--open: there is no xdg-open; open the address in a browser");
  ::posix_spawn_file_actions_destroy(&actions);
}

/// What a change of makes the viewer start again: the scene, every plug-in, every kernel of LUCARIUM_KERNEL_PATH.
WatchedInputs watched_inputs(const ViewArguments& arguments, const TechniqueRegistry& registry) {
  return {scene_files(arguments.scene, arguments.overrides.overrides.environment.value_or("")), registry.searched(),
          kernel_path_roots()};
}

/// Whether the scene, which has changed, can be loaded; pages hear why not.
bool is_loadable(const ViewArguments& arguments, ViewHub& hub) {
  try {
    arguments.load();
    return true;
  } catch (const Error& error) {
    hub.set_notice(fmt::format("the scene has changed and cannot be loaded: {}", error.what()));
    return false;
  }
}

/// Renders on a thread of its own while this one serves, until interrupted or `changed`. What is being computed when
/// the end comes need not be finished: nothing of it is kept. False: it goes on, and needs the viewer and what that
/// has.
bool serve(Viewer& viewer, ViewServer& server, const std::function<bool()>& changed) {
  const auto rendering = std::make_shared<std::atomic<bool>>(true);  // it may outlive this function
  std::thread renderer([&viewer, rendering] {
    viewer.run();
    *rendering = false;
  });
  try {
    server.run([&] { return interrupt_requested() || changed(); });
  } catch (...) {
    viewer.stop();
    renderer.join();
    throw;
  }
  viewer.stop();
  const Stopwatch waiting;
  while (*rendering && waiting.seconds() < patience_at_end) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (*rendering) {
    renderer.detach();  // kernels that compile cannot be stopped
    return false;
  }
  renderer.join();
  return true;
}

/// Without what the thread that renders still needs.
[[noreturn]] void leave(int code) {
  flush_results();
  std::_Exit(code);
}

/// Says where the page is, and opens it where that was asked for.
void announce(const ViewArguments& arguments, const Messages& messages, const std::string& url) {
  if (!is_loopback(arguments.server.address))
    log_warning("--listen {}: whoever learns the address below reaches this viewer from other machines, unencrypted",
                arguments.server.address);
  if (messages.json) {
    print_result("{}\n", ordered_json{{"schema", "lucarium-view-1"}, {"address", url}}.dump());
  } else {
    print_result("{}\n", url);
    if (!messages.quiet) print_note("Open this address in a browser; Ctrl-C ends.\n");
  }
  flush_results();
  if (arguments.open) open_page(url);
}

int view(const ViewArguments& arguments, const Messages& messages) {
  if (const std::string obstacle = view_server_obstacle(); !obstacle.empty())
    throw_error(ErrorClass::usage, "{}", obstacle);
  const std::optional<ViewState> earlier = state_of_earlier_view();
  const TechniqueRegistry registry(arguments.technique.folders);
  ViewerOptions options;
  options.techniques = techniques_of(arguments, registry, earlier.has_value());
  options.settings = arguments.image.settings();
  options.budget = arguments.budget;
  Scene scene = arguments.load();
  options.settings.camera = scene.cameras.front();
  options.commands = repeat_commands(arguments, scene);
  options.edited = [&arguments](const SceneEdits& edits) {
    SceneArguments edited = arguments.overrides;
    edited.overrides = edited_overrides(edited.overrides, edits);
    Scene changed = edited.load(arguments.scene);
    require_light(changed);
    return changed;
  };
  const std::shared_ptr<Device> device = Device::open(arguments.device.resolved());
  ViewHub hub;
  ViewServerOptions where = arguments.server;
  if (earlier) where.port = earlier->port, where.token = earlier->token;
  auto server = std::make_unique<ViewServer>(hub, where);
  Viewer viewer(device, std::move(scene), registry, std::move(options), hub);
  if (earlier) hub.set_request([&](ViewRequest& request) { request = earlier->request; });
  if (!earlier) announce(arguments, messages, server->url());
  const KeepOnInterrupt end_in_order;
  if (!arguments.watch) {
    if (!serve(viewer, *server, [] { return false; })) leave(0);
    return 0;
  }
  const std::vector<std::string> words = own_command_line();  // before a build replaces the program
  InputWatcher watcher(watched_inputs(arguments, registry));
  const bool ended = serve(viewer, *server, [&] {
    const std::filesystem::path file = watcher.changed();
    if (file.empty() || !is_loadable(arguments, hub)) return false;
    if (!messages.quiet) print_note("{} changed\n", file.string());
    return true;
  });
  if (interrupt_requested() && !ended) leave(0);
  if (interrupt_requested()) return 0;
  const ViewState state{server->port(), server->token(), hub.request()};
  server.reset();  // its port is the next one's
  flush_results();
  try {
    start_again(words, state);
  } catch (const Error& error) {
    if (ended) throw;
    print_note("lucarium: error: {}\n", error.what());
    leave(error.exit_code());
  }
}

}  // namespace

void add_view_command(Command program, Action& action) {
  auto arguments = std::make_shared<ViewArguments>();
  Command command = program.add_subcommand("view", "show techniques at work, in a browser");
  command.option("scene", arguments->scene).required();
  command.option("--port", arguments->server.port).check(in_range(0, largest_port)).capture_default_str();
  command.option("--listen", arguments->server.address).capture_default_str();
  command.flag("--open", arguments->open);
  command.flag("--watch", arguments->watch);
  command.option("--spp", arguments->budget.samples).check(whole_number(1)).default_text("no limit");
  command.option("--iterations", arguments->budget.iterations).check(whole_number(1)).default_text("no limit");
  arguments->image.add_to(command, true);
  arguments->overrides.add_exposure_to(command);
  arguments->overrides.add_to(command);
  arguments->technique.add_to(command, "path_tracing", true);
  arguments->device.add_to(command);
  command.examples(
      {"lucarium view builtin:cornell", "lucarium view builtin:cornell -t path_tracing -t bundle_exchange"},
      "docs/viewing.md");
  command.callback(
      [arguments, &action] { action = [arguments](const Messages& messages) { return view(*arguments, messages); }; });
}

}  // namespace lucarium::app
