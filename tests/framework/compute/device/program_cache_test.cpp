// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/program_cache.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "compute_fixture.h"
#include "file_size_limit.h"
#include "lucarium/base/files/atomic_file.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/compute/program/built_program.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/compute/schedule/scheduler.h"

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

namespace {

const EmbeddedSources sources = {
    {"ids.cl",
     "kernel void ids(global uint* v) { v[get_global_id(0)] = get_global_id(0) * FACTOR; }\n"
     "kernel void sizes(global uint* v) { v[get_global_id(0)] = get_local_size(0) + 100 * get_group_id(0); }\n"}};

std::shared_ptr<Device> device_with(const fs::path& cache_dir) {
  DeviceOptions options;
  options.cache_dir = cache_dir;
  return Device::open(options);
}

/// On a device of its own there is nothing to share: the program is compiled, or comes from the cache.
Program build(const std::shared_ptr<Device>& device, const std::string& factor = "3") {
  SourceLibrary library;
  library.add(sources);
  return Program(*device, library, {"ids", {"ids.cl"}, {{"FACTOR", factor}}});
}

void check_results(const Program& program, uint32_t factor = 3) {
  CHECK(launch(program, "ids", 4, 2) == std::vector<uint32_t>{0, factor, 2 * factor, 3 * factor});
  for (const uint32_t local : {1u, 2u, 4u}) {
    CHECK(launch(program, "sizes", 4, local) == std::vector<uint32_t>{local, local + 100 * (1 / local),
                                                                      local + 100 * (2 / local),
                                                                      local + 100 * (3 / local)});
  }
}

std::vector<fs::path> entries(const fs::path& cache_dir) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(cache_dir / "programs")) found.push_back(entry.path());
  return found;
}

void overwrite(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

}  // namespace

TEST_CASE("the second build comes from the cache, another define does not") {
  const TemporaryFolder folder;
  {
    const Program first = build(device_with(folder.path()));
    CHECK(!first.from_cache());
    check_results(first);
  }
  CHECK(entries(folder.path()).size() == 1);
  const Program second = build(device_with(folder.path()));
  CHECK(second.from_cache());
  check_results(second);
  const Program other = build(device_with(folder.path()), "5");
  CHECK(!other.from_cache());
  check_results(other, 5);
  CHECK(entries(folder.path()).size() == 2);
}

TEST_CASE("a program that is there is shared by all that have its source, on one device") {
  const TemporaryFolder folder;
  const auto device = device_with(folder.path()), other = device_with(folder.path());
  const Program first = build(device);
  CHECK(build(device).handle() == first.handle());
  CHECK(build(device, "5").handle() != first.handle());
  CHECK(build(other).handle() != first.handle());
  check_results(build(device));
}

TEST_CASE("a program that nobody has any more stays built on its device, until many others were used since") {
  const TemporaryFolder folder;
  DeviceOptions options;
  options.cache_dir = folder.path();
  options.use_cache = false;
  const auto device = Device::open(options);
  KeptPrograms& kept = device->kept_programs();
  const cl_program first = build(device).handle();
  for (int i = 0; i < 3; ++i) {
    const Program again = build(device);
    CHECK(again.handle() == first);
    check_results(again);
  }
  CHECK(kept.size() == 1);
  for (size_t i = 1; i < KeptPrograms::max_count; ++i) build(device, std::to_string(100 + i));
  CHECK(kept.size() == KeptPrograms::max_count);
  CHECK(build(device).handle() == first);  // it is the last used one now
  build(device, "7");
  CHECK(kept.size() == KeptPrograms::max_count);
  CHECK(build(device).handle() == first);
  kept.clear();
  CHECK(kept.size() == 0);
  check_results(build(device));
}

TEST_CASE("a device keeps one program for each request, and the last used ones") {
  KeptPrograms kept;
  const auto request = [](size_t i) { return Hasher().add(static_cast<uint64_t>(i)).finish(); };
  std::vector<std::weak_ptr<BuiltProgram>> programs;
  const auto keep = [&](size_t i) {
    const auto program = std::make_shared<BuiltProgram>();
    programs.push_back(program);
    kept.keep(request(i), program);
  };
  keep(0);
  keep(0);
  CHECK(programs[0].expired());
  CHECK(kept.find(request(0)) == programs[1].lock());
  CHECK(kept.find(request(1)) == nullptr);
  for (size_t i = 1; i < KeptPrograms::max_count; ++i) keep(i);
  kept.keep(request(0), kept.find(request(0)));
  keep(KeptPrograms::max_count);
  CHECK(kept.size() == KeptPrograms::max_count);
  CHECK(kept.find(request(0)) != nullptr);
  CHECK(kept.find(request(1)) == nullptr);  // used least recently
  CHECK(kept.find(request(2)) != nullptr);
  CHECK(programs[2].expired());
}

TEST_CASE("with the cache off nothing is read or written") {
  const TemporaryFolder folder;
  build(device_with(folder.path()));
  DeviceOptions options;
  options.cache_dir = folder.path();
  options.use_cache = false;
  const auto device = Device::open(options);
  CHECK(!build(device).from_cache());
  CHECK(!build(Device::open(options)).from_cache());
  CHECK(!build(device, "7").from_cache());
  CHECK(entries(folder.path()).size() == 1);
}

TEST_CASE("a damaged entry is rebuilt, wherever the damage is") {
  const TemporaryFolder folder;
  const auto check_rebuilt = [&](const std::string& damage) {
    CAPTURE(damage);
    {
      const Program rebuilt = build(device_with(folder.path()));
      CHECK(!rebuilt.from_cache());
      CHECK(launch(rebuilt, "ids", 4, 2) == std::vector<uint32_t>{0, 3, 6, 9});
    }
    CHECK(build(device_with(folder.path())).from_cache());
  };
  check_results(build(device_with(folder.path())));
  const fs::path entry = entries(folder.path()).at(0);
  const std::string whole = read_file(entry);

  // The header (magic, length, checksum) byte by byte would be slow: its ends, then the content at even steps.
  std::vector<size_t> places = {0, 7, 8, 15, 16, 23, 24, 31, whole.size() - 1};
  for (size_t step = 0; step < 8; ++step) places.push_back(32 + step * (whole.size() - 33) / 8);
  for (const size_t place : places) {
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x40);
    overwrite(entry, damaged);
    check_rebuilt("flipped at " + std::to_string(place));
  }
  for (const size_t length :
       {size_t{0}, size_t{1}, size_t{31}, size_t{32}, size_t{100}, whole.size() / 2, whole.size() - 1}) {
    overwrite(entry, whole.substr(0, length));
    check_rebuilt("cut to " + std::to_string(length));
  }
  overwrite(entry, whole + "x");
  check_rebuilt("one byte too many");
  overwrite(entry, "#!/bin/sh\necho foreign\n" + whole);
  check_rebuilt("foreign");
  overwrite(entry, std::string(whole.size(), '\0'));
  check_rebuilt("zeros");
}

TEST_CASE("an entry under another's name is not taken") {
  const TemporaryFolder folder;
  build(device_with(folder.path()), "3");
  const fs::path first = entries(folder.path()).at(0);
  const std::string bytes = read_file(first);
  fs::remove(first);
  build(device_with(folder.path()), "5");
  overwrite(entries(folder.path()).at(0), bytes);
  const Program program = build(device_with(folder.path()), "5");
  CHECK(!program.from_cache());
  check_results(program, 5);
}

TEST_CASE("a folder where the entry should be is no harm") {
  const TemporaryFolder folder;
  build(device_with(folder.path()));
  const fs::path entry = entries(folder.path()).at(0);
  fs::remove(entry);
  fs::create_directories(entry / "inside");
  check_results(build(device_with(folder.path())));
}

TEST_CASE("a cache folder that cannot be written is no harm") {
  const TemporaryFolder folder;
  overwrite(folder.path() / "file", "x");
  const auto device = device_with(folder.path() / "file");
  const Program program = build(device);
  CHECK(!program.from_cache());
  check_results(program);
}

TEST_CASE("the key distinguishes source, options and version") {
  const TemporaryFolder folder;
  const auto device = device_with(folder.path());
  const ProgramCache& cache = device->program_cache();
  CHECK(cache.key("a", "b") == cache.key("a", "b"));
  CHECK(cache.key("a", "b") != cache.key("ab", ""));
  DeviceInfo other = device->info();
  other.driver_version += " next";
  DeviceOptions options;
  options.cache_dir = folder.path();
  CHECK(ProgramCache(options, other).key("a", "b") != cache.key("a", "b"));
}

// Cases marked skip() are run by others, each in a process of its own.

TEST_CASE("child: build and launch and say where the programs came from" * doctest::skip()) {
  const auto device = Device::open();
  const Program three = build(device, "3"), five = build(device, "5");
  check_results(three, 3);
  check_results(five, 5);
  cache_specialized_kernels(*device);
  std::printf("cached %d%d\n", three.from_cache(), five.from_cache());
  if (std::getenv("TEST_PRINT_FILES") && driver_folder()) {
    for (const auto& entry : fs::recursive_directory_iterator(driver_folder()->path())) {
      if (entry.path().extension() == ".so" && entry.file_size() > 0)
        std::printf("code %s\n", entry.path().filename().c_str());
    }
  }
}

namespace {

const char* build_case = "child: build and launch and say where the programs came from";

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("a later process takes program and launch code from the cache and compiles nothing") {
  const TemporaryFolder folder;
  const std::string environment = "TEST_PRINT_FILES=1 LUCARIUM_CACHE_DIR=" + folder.path().string();
  const ProgramResult first = run_case(build_case, environment);
  CHECK(first.exit_code == 0);
  CHECK(has(first.out, "cached 00"));
  std::vector<std::string> kept;
  for (const fs::path& entry : entries(folder.path())) kept.push_back(read_file(entry));
  for (int run = 0; run < 2; ++run) {
    const ProgramResult again = run_case(build_case, environment);
    CHECK(again.exit_code == 0);
    CHECK(has(again.out, "cached 11"));
    CHECK(count(again.out, "code ") == count(first.out, "code "));
  }
  std::vector<std::string> later;
  for (const fs::path& entry : entries(folder.path())) later.push_back(read_file(entry));
  CHECK(later == kept);  // nothing new was compiled
}

TEST_CASE("launch code of a program that was a local variable was made again in every process") {
  const TemporaryFolder folder;
  const auto device = device_with(folder.path());
  if (!device->info().is_pocl || !driver_folder()) return test::skip("PoCL, whose launch code is kept");
  KernelScheduler scheduler(device);
  const TypedBuffer<uint32_t> values(*device, "test", "values", 4);
  const auto record = [&] {
    const Program program = build(device);
    ScheduleRecorder recorder = scheduler.record("ids", "test");
    recorder.pass("ids", program, "ids").global(4).arg("v", values);
    return recorder.compile();
  };
  Schedule schedule = record();
  REQUIRE(entries(folder.path()).size() == 1);
  const auto before = fs::file_size(entries(folder.path()).front());
  scheduler.warm_up(schedule);
  CHECK(fs::file_size(entries(folder.path()).front()) > before);
}

TEST_CASE("many processes may fill and use one cache at once") {
  const TemporaryFolder folder;
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  const std::string child =
      "LUCARIUM_CACHE_DIR=" + folder.path().string() + " '" + self + "' --no-skip --test-case='" + build_case + "'";
  for (int round = 0; round < 2; ++round) {
    const ProgramResult result =
        run_program("pids=; for i in 1 2 3 4 5 6; do " + child +
                        " & pids=\"$pids $!\"; done; for p in $pids; do wait $p || exit 1; done",
                    200);
    CAPTURE(result.out);
    CHECK(result.exit_code == 0);
    CHECK(count(result.out, "cached 11") + 6 * (round == 0) >= 6);
  }
  CHECK(entries(folder.path()).size() == 2);  // no temporary is left
}

TEST_CASE("a full disk gave a warning for every kernel that could not be kept") {
  const TemporaryFolder folder;
  DeviceOptions options;
  options.cache_dir = folder.path();
  const ProgramCache cache(options, device_with(folder.path())->info());
  CachedProgram program;
  program.binary = std::string(10000, 'x');
  const fs::path said = folder.path() / "said";
  const int before = ::dup(STDERR_FILENO), file = ::open(said.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  ::dup2(file, STDERR_FILENO);
  {
    const FileSizeLimit full(2000);  // room for the warnings, not for a program
    for (const char* source : {"a", "b", "c", "d"}) cache.store(cache.key(source, ""), program);
  }
  ::dup2(before, STDERR_FILENO);
  ::close(before);
  ::close(file);
  const std::string text = read_file(said);
  CHECK(std::count(text.begin(), text.end(), '\n') == 1);
  CHECK(text.find("compiled kernels are not kept: cannot write ") != std::string::npos);
  CHECK(entries(folder.path()).empty());
}
