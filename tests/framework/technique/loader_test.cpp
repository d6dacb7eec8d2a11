// SPDX-License-Identifier: Apache-2.0
// Plug-ins that are not what they should be: each gives its reason, and none stops the others.
#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "lucarium/base/error.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/technique/plugin.h"
#include "test_support.h"

using namespace lucarium;
namespace fs = std::filesystem;

namespace {

fs::path plugin_folder(const std::string& name) {
  const char* root = std::getenv("LUCARIUM_TEST_PLUGINS");
  REQUIRE(root);
  return fs::path(root) / name;
}

/// Why the plug-in could not be loaded, or "loaded". The good plug-in beside it always is.
std::string reason_of(const std::string& name) {
  const TechniqueRegistry registry({plugin_folder(name), plugin_folder("constant")});
  CHECK(registry.find("constant").info().version == "1.0");
  for (const PluginFailure& failure : registry.failures()) {
    if (failure.file == plugin_folder(name) / (name + ".so")) return failure.reason;
  }
  return "loaded";
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a plug-in of another interface or toolchain is refused before anything of it is called") {
  CHECK(reason_of("wrong_magic") == "is not a Lucarium technique (wrong magic)");
  CHECK(reason_of("wrong_abi") == fmt::format("is built for ABI {}, this program has {}; rebuild it",
                                              LUCARIUM_ABI_VERSION + 1, LUCARIUM_ABI_VERSION));
  CHECK(reason_of("other_library") ==
        fmt::format("is built for ABI 1, this program has {}; rebuild it", LUCARIUM_ABI_VERSION));
  CHECK(contains(reason_of("wrong_compiler"), "is built with compiler '?"));
  CHECK(contains(reason_of("wrong_sanitizer"), "is built with sanitizers 'm"));
}

TEST_CASE("what is no plug-in says so, with the loader's own words") {
  CHECK(contains(reason_of("text_file"), "cannot be loaded: "));
  CHECK(contains(reason_of("text_file"), "text_file.so"));
  CHECK(contains(reason_of("undefined_symbol"), "lucarium_test_nobody_defines_this"));
  CHECK(contains(reason_of("no_symbol"), "exports no lucarium_technique()"));
  CHECK(reason_of("no_descriptor") == "has an empty descriptor");
}

TEST_CASE("a plug-in that is cut off ended the program with SIGBUS") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "cut.so";
  const std::string whole = read_file(plugin_folder("constant") / "constant.so");
  for (const size_t bytes : {size_t{70}, size_t{5000}, whole.size() / 2, whole.size() - 1}) {
    write_file_atomically(file, whole.substr(0, bytes));
    const TechniqueRegistry registry({folder.path()});
    REQUIRE(registry.failures().size() == 1);
    CHECK(registry.failures()[0].reason == "cannot be loaded: the file is cut off; build or copy it again");
  }
  write_file_atomically(file, whole);
  CHECK(TechniqueRegistry({folder.path()}).failures().empty());
}

TEST_CASE("a pipe with the name of a plug-in was waited for without end") {
  const test::TemporaryFolder folder;
  REQUIRE(::mkfifo((folder.path() / "pipe.so").c_str(), 0600) == 0);
  fs::create_directory(folder.path() / "folder.so");
  fs::create_symlink("/dev/zero", folder.path() / "device.so");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string socket_name = (folder.path() / "socket.so").string();
  REQUIRE(socket_name.size() < sizeof address.sun_path);
  std::copy(socket_name.begin(), socket_name.end(), address.sun_path);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const TechniqueRegistry registry({folder.path(), plugin_folder("constant")});
  ::close(socket);
  CHECK(registry.find("constant").info().version == "1.0");
  REQUIRE(registry.failures().size() == 4);
  for (const PluginFailure& failure : registry.failures()) {
    CHECK(failure.reason == "cannot be loaded: it is not a regular file");
  }
}

TEST_CASE("whatever a plug-in throws becomes a reason, also types of its own") {
  CHECK(reason_of("throws_in_info") == "info() failed: an exception of the plug-in's own");
  CHECK(reason_of("throws_an_int") == "info() failed: threw something that is not an exception");
  CHECK(contains(reason_of("bad_name"), "is named 'bad name:x=1'"));
  const TechniqueRegistry registry({plugin_folder("throws_in_create")});
  try {
    registry.find("throws_in_create").create();
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.error_class() == ErrorClass::technique);
    CHECK(std::string(error.what()) == "technique throws_in_create: an exception of the plug-in's own");
  }
}

TEST_CASE("a technique that is not there: nearest name, folders searched, and why the file of that name failed") {
  const TechniqueRegistry registry({plugin_folder("constant"), plugin_folder("wrong_abi"), "/nonexistent/folder"});
  const auto message = [&](const std::string& name, ErrorClass expected) {
    try {
      registry.find(name);
    } catch (const Error& error) {
      CHECK(error.error_class() == expected);
      return std::string(error.what());
    }
    return std::string("found");
  };
  const std::string mistyped = message("constnat", ErrorClass::usage);
  CHECK(contains(mistyped, "no technique is called 'constnat'; did you mean 'constant'? (searched "));
  CHECK(contains(mistyped, "/nonexistent/folder"));
  CHECK(contains(message("wrong_abi", ErrorClass::technique),
                 fmt::format("is built for ABI {}", LUCARIUM_ABI_VERSION + 1)));
  REQUIRE_FALSE(registry.failures().empty());
  CHECK(registry.failures().front().reason == "there is no such folder");
}

TEST_CASE("a technique outlives its registry") {
  std::unique_ptr<Technique> technique;
  {
    const TechniqueRegistry registry({plugin_folder("constant")});
    technique = registry.find("constant").create();
  }
  technique->parameters().set("red", "3");
  CHECK(technique->parameters().get("red") == "3");
}
