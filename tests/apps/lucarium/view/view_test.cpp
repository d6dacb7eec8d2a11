// SPDX-License-Identifier: Apache-2.0
// lucarium view: what strangers and pages say to it (view_client.py), what there is to see in moments of haste
// (view_motion.py), its page in a browser (view_browser.py, life_browser.py), and what happens when files change
// (view_watch.py).
#include "cli_support.h"
#include "lucarium/view/server.h"

using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

fs::path here() { return fs::path(environment("LUCARIUM_TEST_SOURCE")) / "tests/apps/lucarium/view"; }

/// Lines "ok …" or "FAILED …", then "end".
void check_found(const ProgramResult& found) {
  INFO(found.out << found.err);
  CHECK(found.exit_code == 0);
  CHECK_FALSE(contains(found.out, "FAILED"));
  CHECK(found.out.ends_with("end\n"));
}

bool has_viewer() { return lucarium::view_server_obstacle().empty(); }

}  // namespace

TEST_CASE("the viewer answers its pages, refuses strangers and malformed messages, and ends within a second") {
  if (!has_viewer()) return skip("libwebsockets");
  check_found(run_program("python3 " + (here() / "view_client.py").string() + " " + lucarium_program() +
                              " view builtin:cornell " + constant_technique("blue=0.25"),
                          540));
}

TEST_CASE(
    "viewer in a browser: picture, camera, technique, two sides, pixel, errors, scene, tabs, files, looks, keys") {
  if (!has_viewer()) return skip("libwebsockets");
  const TemporaryFolder folder;
  const ProgramResult found = run_program(
      "python3 " + (here() / "view_browser.py").string() + " " + lucarium_program() + " " + folder.path().string(),
      540);
  if (found.exit_code == 77) return skip("chromium");
  check_found(found);
}

TEST_CASE("viewer in a browser: an animation, a lost connection, a page that watches") {
  if (!has_viewer()) return skip("libwebsockets");
  const TemporaryFolder folder;
  const ProgramResult found = run_program(
      "python3 " + (here() / "life_browser.py").string() + " " + lucarium_program() + " " + folder.path().string(),
      540);
  if (found.exit_code == 77) return skip("chromium");
  check_found(found);
}

TEST_CASE("while a technique prepares itself there is a picture; while the camera moves light that is kept rests") {
  if (!has_viewer()) return skip("libwebsockets");
  check_found(run_program("python3 " + (here() / "view_motion.py").string() + " " + lucarium_program() + " " +
                              constant_technique("sleep=300"),
                          540));
}

TEST_CASE("a watching viewer starts again when a kernel changes, and shows what the compiler says of it") {
  if (!has_viewer()) return skip("libwebsockets");
  const TemporaryFolder folder;
  const fs::path kernel = fs::path(environment("LUCARIUM_TEST_SOURCE")) /
                          "framework/lucarium/services/path_integrator/accumulate_samples.cl";
  check_found(run_program("python3 " + (here() / "view_watch.py").string() + " " + lucarium_program() + " " +
                              kernel.string() + " " + (folder.path() / "kernels").string(),
                          540));
}

TEST_CASE("what cannot be viewed is refused before anything is served") {
  if (!has_viewer()) return check_refused("view builtin:cornell", 2, "libwebsockets-dev");
  check_refused("view builtin:cornell -t no_such", 2, "no_such");
  check_refused("view builtin:cornell -t path_tracing -t path_tracing:roulette_start=9999", 2, "roulette_start");
  check_refused("view builtin:cornell --listen nowhere.invalid", 2, "--listen");
  check_refused("view builtin:cornell --port 70000", 2, "--port");
  check_refused("view", 2, "SCENE");
}
