// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/device.h"

#include <CL/cl_ext.h>
#include <doctest/doctest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <set>

#include "compute_fixture.h"
#include "lucarium/compute/device/pocl_folder.h"
#include "lucarium/compute/program/source_library.h"

using namespace lucarium;
using namespace lucarium::test;
namespace fs = std::filesystem;

TEST_CASE("devices are listed with what people choose them by") {
  const std::vector<DeviceInfo> devices = list_devices();
  REQUIRE(!devices.empty());
  for (size_t i = 0; i < devices.size(); ++i) {
    CHECK(devices[i].index == static_cast<int>(i));
    CHECK(!devices[i].name.empty());
    CHECK(devices[i].compute_units > 0);
    CHECK(devices[i].max_allocation_bytes > 0);
    CHECK(devices[i].base_alignment_bytes >= 1);
  }
}

TEST_CASE("a device is chosen by index, part of a name or platform, or type") {
  const DeviceInfo first = list_devices().front();
  const auto index_of = [](const std::string& selector) {
    DeviceOptions options;
    options.selector = selector;
    return Device::open(options)->info().index;
  };
  CHECK(index_of("0") == 0);
  CHECK(index_of(first.name.substr(1, 5)) == 0);
  CHECK(index_of(first.platform) == 0);
  if (first.type == DeviceType::cpu) CHECK(index_of("CPU") == 0);
}

TEST_CASE("a selector that matches nothing lists the devices there are") {
  for (const char* selector : {"99", "no such device", "accelerator"}) {
    DeviceOptions options;
    options.selector = selector;
    const Error error = error_of([&] { Device::open(options); });
    CHECK(error.error_class() == ErrorClass::device);
    CHECK(has(error.what(), std::string("no OpenCL device matches '") + selector + "'"));
    CHECK(has(error.what(), list_devices().front().name));
  }
}

TEST_CASE("OpenCL codes have names and errors say call, subject and device") {
  CHECK(opencl_error_name(-52) == "CL_INVALID_KERNEL_ARGS");
  CHECK(opencl_error_name(CL_SUCCESS) == "CL_SUCCESS");
  CHECK(opencl_error_name(-9999) == "unknown OpenCL code -9999");
  for (int code = -1; code >= -72; --code) {
    const bool gap = (code <= -20 && code >= -29);
    CAPTURE(code);
    CHECK(has(opencl_error_name(code), "unknown") == gap);
  }
  const Error error = error_of([] { check_opencl(-5, "clFinish", "kernel shade of probe", *test_device()); });
  CHECK(error.error_class() == ErrorClass::device);
  CHECK(std::string(error.what()) ==
        "clFinish failed with CL_OUT_OF_RESOURCES (-5) for kernel shade of probe on " + test_device()->info().name);
}

// Cases marked skip() are run by others, each in a process of its own, because drivers read their environment once.

TEST_CASE("child: open a device and say what it is" * doctest::skip()) {
  const auto device = Device::open();
  TypedBuffer<uint32_t> buffer(*device, "test", "numbers", std::vector<uint32_t>{1, 2, 3});
  CHECK(buffer.download() == std::vector<uint32_t>{1, 2, 3});
  SourceLibrary library;
  const EmbeddedSources sources = {
      {"ids.cl", "kernel void ids(global uint* v) { v[get_global_id(0)] = get_global_id(0); }"}};
  library.add(sources);
  const Program program(*device, library, {"ids", {"ids.cl"}, {}});
  CHECK(launch(program, "ids", 4, 2) == std::vector<uint32_t>{0, 1, 2, 3});
  std::printf("compute units %u\nfolder %s\n", device->info().compute_units,
              driver_folder() ? driver_folder()->path().c_str() : "of the user");
}

namespace {

const char* open_case = "child: open a device and say what it is";

std::string folder_in(const std::string& output) {
  const size_t begin = output.find("folder ") + 7;
  return output.substr(begin, output.find('\n', begin) - begin);
}

}  // namespace

TEST_CASE("without any OpenCL driver the message says what to install") {
  const TemporaryFolder empty;
  const ProgramResult result = run_case(open_case, "OCL_ICD_VENDORS=" + empty.path().string());
  CHECK(result.exit_code != 0);
  CHECK(has(result.out, "no OpenCL driver is installed (none is registered in " + empty.path().string()));
  CHECK(has(result.out, "apt install pocl-opencl-icd"));
}

TEST_CASE("a driver that does not load is named with the reason, and only where none loads") {
  const TemporaryFolder vendors;
  const std::string lost = (vendors.path() / "lost.so").string();
  std::ofstream(vendors.path() / "lost.icd") << lost << "\n";
  std::ofstream(vendors.path() / "empty.icd");
  const ProgramResult result = run_case(open_case, "OCL_ICD_VENDORS=" + vendors.path().string());
  CHECK(result.exit_code != 0);
  CHECK(has(result.out, "no OpenCL driver loads; registered in " + vendors.path().string() +
                            ": empty.icd (it names no library), lost.icd (" + lost));
  const fs::path working = "/etc/OpenCL/vendors/pocl.icd";
  if (!fs::exists(working)) return;
  fs::copy(working, vendors.path());
  CHECK(run_case(open_case, "OCL_ICD_VENDORS=" + vendors.path().string()).exit_code == 0);
}

TEST_CASE("child: open a device with one thread" * doctest::skip()) {
  DeviceOptions options;
  options.threads = 1;
  CHECK(Device::open(options)->info().compute_units == 1);
}

TEST_CASE("the number of threads can be chosen") {
  if (!test_device()->info().is_pocl) return skip("PoCL");
  CHECK(run_case("child: open a device with one thread").exit_code == 0);
}

TEST_CASE("PoCL's files lie in a folder of the process, which is removed with it") {
  if (!test_device()->info().is_pocl) return skip("PoCL");
  REQUIRE(driver_folder());
  CHECK(fs::is_directory(driver_folder()->path()));
  const ProgramResult result = run_case(open_case);
  CHECK(result.exit_code == 0);
  CHECK(folder_in(result.out) != driver_folder()->path());
  CHECK(DriverFolder::is_one(folder_in(result.out)));
  CHECK(!fs::exists(folder_in(result.out)));
}

TEST_CASE("a usable POCL_CACHE_DIR is respected, a useless one replaced with a warning") {
  if (!test_device()->info().is_pocl) return skip("PoCL");
  const TemporaryFolder folder;
  const ProgramResult kept = run_case(open_case, "POCL_CACHE_DIR=" + folder.path().string());
  CHECK(kept.exit_code == 0);
  CHECK(folder_in(kept.out) == "of the user");
  CHECK(!fs::is_empty(folder.path()));

  const fs::path file = folder.path() / "file";
  std::ofstream(file) << "x";
  const ProgramResult replaced = run_case(open_case, "POCL_CACHE_DIR=" + (file / "below").string());
  CHECK(replaced.exit_code == 0);
  CHECK(has(replaced.err, "POCL_CACHE_DIR=" + (file / "below").string() + " cannot be used (Not a directory)"));
}

TEST_CASE("child: open a device and be killed" * doctest::skip()) {
  const auto device = Device::open();
  std::printf("folder %s\n", driver_folder()->path().c_str());
  std::fflush(stdout);
  raise(SIGKILL);
}

TEST_CASE("the folder of a killed process is removed by the next one") {
  if (!test_device()->info().is_pocl) return skip("PoCL");
  const ProgramResult killed = run_case("child: open a device and be killed");
  CHECK(killed.exit_code != 0);
  CAPTURE(killed.out);
  CAPTURE(killed.err);
  const fs::path abandoned = folder_in(killed.out);
  REQUIRE(has(abandoned.string(), "lucarium-driver-"));
  CHECK(run_case(open_case).exit_code == 0);
  CHECK(!fs::exists(abandoned));
}

TEST_CASE("a folder whose lock was never set up is removed when it is old") {
  if (!test_device()->info().is_pocl) return skip("PoCL");
  const ProgramResult first = run_case(open_case);
  const fs::path place = fs::path(folder_in(first.out)).parent_path();
  const auto folder_of_age = [&](const char* name, std::chrono::hours age) {
    const fs::path folder = place / fmt::format("lucarium-driver-{}-{}", getuid(), name);
    fs::create_directories(folder);
    fs::last_write_time(folder, fs::file_time_type::clock::now() - age);
    return folder;
  };
  const fs::path old_one = folder_of_age("old_test", std::chrono::hours(50));
  const fs::path new_one = folder_of_age("new_test", std::chrono::hours(1));
  CHECK(run_case(open_case).exit_code == 0);
  CHECK(!fs::exists(old_one));
  CHECK(fs::exists(new_one));
  fs::remove(new_one);
}
