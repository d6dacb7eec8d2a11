// SPDX-License-Identifier: Apache-2.0
// lucarium render --watch: the picture follows scene, kernels and plug-in; what does not compile keeps the last one.
#include <fstream>
#include <sstream>

#include "cli_support.h"
#include "file_bytes.h"

using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

size_t occurrences(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

/// `lucarium render … --watch` in the background; interrupted at the end.
class Watcher {
 public:
  Watcher(const fs::path& folder, const std::string& environment, const std::string& arguments) : folder_(folder) {
    const std::string line = "cd " + folder.string() + " && { " + environment + " exec " + lucarium_program() +
                             " render " + arguments + " --watch >out.txt 2>log.txt </dev/null & echo $! >pid; }";
    REQUIRE(std::system(("sh -c '" + replace_quotes(line) + "'").c_str()) == 0);
  }
  ~Watcher() { end(); }

  std::string log() const { return bytes_of(folder_ / "log.txt"); }
  /// Waits for the n-th end of a render, good or bad.
  bool rendered(size_t n) const {
    return wait_until([&] { return occurrences(log(), "rendered in") + occurrences(log(), "not rendered") >= n; });
  }
  /// Ctrl-C; true when the process is gone soon.
  bool end() {
    if (ended_) return true;
    ended_ = true;
    const std::string pid = bytes_of(folder_ / "pid");
    static_cast<void>(std::system(("kill -INT " + pid).c_str()));
    return wait_until([&] { return !fs::exists("/proc/" + pid.substr(0, pid.find('\n'))); });
  }

 private:
  static std::string replace_quotes(const std::string& text) {
    std::string quoted;
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted;
  }
  fs::path folder_;
  bool ended_ = false;
};

const char* const brighter_kernel =
    "kernel void fill_constant(global float4* sum, const float4 colour, const uint pixels) {\n"
    "  const uint i = (uint)get_global_id(0);\n"
    "  if (i < pixels) sum[i] += 2.0f * colour;\n"
    "}\n";

}  // namespace

TEST_CASE("the picture follows the scene, the kernel and the plug-in; a kernel that does not compile keeps it") {
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  fs::create_directories(folder / "plugins");
  fs::create_directories(folder / "kernels" / "constant");
  fs::copy_file(environment("LUCARIUM_TEST_PLUGINS") + "/constant/constant.so", folder / "plugins" / "constant.so");
  REQUIRE(run_lucarium("scene builtin:cornell --export " + (folder / "box.glb").string()).exit_code == 0);

  Watcher watcher(
      folder, "LUCARIUM_KERNEL_PATH=" + (folder / "kernels").string(),
      "box.glb --technique-path plugins -t constant:blue=0.25 --max-bounces 1 --size 16x8 --iterations 1 -o a.png");
  REQUIRE(watcher.rendered(1));
  const std::string first = bytes_of(folder / "a.png");
  CHECK_FALSE(first.empty());

  // The scene's sidecar changes the exposure.
  std::ofstream(folder / "box.glb.lucarium.json") << "{\"exposure\": -1}";
  REQUIRE(watcher.rendered(2));
  const std::string darker = bytes_of(folder / "a.png");
  CHECK(darker != first);

  // A kernel twice as bright: as before the exposure.
  std::ofstream(folder / "kernels/constant/fill_constant.cl") << brighter_kernel;
  REQUIRE(watcher.rendered(3));
  CHECK(bytes_of(folder / "a.png") == first);

  // One that does not compile.
  std::ofstream(folder / "kernels/constant/fill_constant.cl")
      << "kernel void fill_constant(global float4* sum) { sum[0] = nonsense; }\n";
  REQUIRE(watcher.rendered(4));
  CHECK(bytes_of(folder / "a.png") == first);
  const std::string log = watcher.log();
  CAPTURE(log);
  CHECK(contains(log, "nonsense"));
  CHECK(contains(log, "fill_constant.cl:1"));
  CHECK(contains(log, "the last image is kept"));

  // Without the override the embedded kernel counts again, and a plug-in that is replaced is loaded again.
  fs::remove(folder / "kernels/constant/fill_constant.cl");
  REQUIRE(watcher.rendered(5));
  CHECK(bytes_of(folder / "a.png") == darker);
  fs::copy_file(environment("LUCARIUM_TEST_PLUGINS") + "/wrong_abi/wrong_abi.so", folder / "plugins" / "new.so");
  fs::rename(folder / "plugins" / "new.so", folder / "plugins" / "constant.so");
  REQUIRE(watcher.rendered(6));
  CHECK(contains(watcher.log(), "is built for ABI"));
  CHECK(bytes_of(folder / "a.png") == darker);
  CHECK(watcher.end());
  CHECK(contains(watcher.log(), "constant.so changed"));
}

TEST_CASE("--watch renders again for what the picture was made from only: no other plug-in, no other kernel") {
  const TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  for (const char* name : {"first", "plugins", "kernels/constant", "kernels/another"})
    fs::create_directories(folder / name);
  const fs::path constant = environment("LUCARIUM_TEST_PLUGINS") + "/constant/constant.so";
  fs::copy_file(constant, folder / "plugins" / "constant.so");
  Watcher watcher(folder, "LUCARIUM_KERNEL_PATH=" + (folder / "kernels").string(),
                  "builtin:cornell --technique-path first --technique-path plugins -t constant --max-bounces 1 "
                  "--size 16x8 --iterations 1 -o a.png");
  REQUIRE(watcher.rendered(1));

  // Of several changes the first by name is reported. The last one here is of a file in use, and the only such one.
  std::ofstream(folder / "kernels/another/noise.cl") << "kernel void noise() {}\n";
  std::ofstream(folder / "kernels/constant/a_note.txt") << "to do\n";
  std::ofstream(folder / "kernels/constant/fill_constant.cl") << brighter_kernel;
  REQUIRE(watcher.rendered(2));
  CHECK(contains(watcher.log(), "fill_constant.cl changed"));

  // A plug-in of the same file name, in a folder that is searched before.
  fs::copy_file(constant, folder / "first" / "another.so");
  fs::copy_file(constant, folder / "first" / "constant.so");
  REQUIRE(watcher.rendered(3));
  const std::string log = watcher.log();
  CAPTURE(log);
  CHECK(contains(log, "first/constant.so changed"));
  CHECK(occurrences(log, " changed\n") == 2);
  CHECK_FALSE(contains(log, "lucarium used"));  // what a render reports to the watching process only
  CHECK(watcher.end());
}

TEST_CASE("--watch --quiet prints results alone") {
  const TemporaryFolder folder;
  Watcher watcher(folder.path(), "",
                  "builtin:cornell " + constant_technique() + "--iterations 1 --size 16x8 -q -o a.png");
  REQUIRE(wait_until([&] { return contains(bytes_of(folder.path() / "out.txt"), "a.png: 1 sample per pixel"); }));
  CHECK(watcher.end());
  CHECK(watcher.log().empty());
}

TEST_CASE("--watch does not replace what was there before it began") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "a.png").string();
  std::ofstream(file) << "something else";
  check_refused("render builtin:cornell " + constant_technique() + "--watch -o " + file, 2, "--overwrite");
}

TEST_CASE("--watch ends with 0 when there is a finished picture, and with 6 when there is none") {
  const TemporaryFolder folder;
  const std::string log = (folder.path() / "log").string();
  const auto end_at = [&](const std::string& words, const std::string& parameters) {
    std::filesystem::remove(log);
    return run_program(lucarium_program() + " render builtin:cornell " + constant_technique(parameters) +
                       "--overwrite --iterations " + (parameters.empty() ? "1" : "100000") + " --watch -o " +
                       (folder.path() / "a.exr").string() + " 2>" + log + " & pid=$!; until grep -q '" + words + "' " +
                       log + "; do kill -0 $pid || exit 99; sleep 0.1; done; kill -INT $pid; wait $pid")
        .exit_code;
  };
  CHECK(end_at("rendering", "sleep=50") == 6);
  CHECK(end_at("rendered in", "") == 0);
}
