// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/memory_account.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <limits>

#include "compute_fixture.h"
#include "lucarium/base/text/byte_size.h"
#include "lucarium/compute/device/host_memory.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("an account adds up owners and remembers its peak") {
  MemoryAccount account(1000, 600);
  account.add("scene", "vertices", 500);
  account.add("bvh", "nodes", 200);
  account.add("scene", "triangles", 100);
  CHECK(account.used_bytes() == 800);
  CHECK(account.by_owner() == std::map<std::string, size_t>{{"bvh", 200}, {"scene", 600}});
  account.remove("scene", 600);
  CHECK(account.used_bytes() == 200);
  CHECK(account.peak_bytes() == 800);
  CHECK(!account.by_owner().contains("scene"));
  account.remove("nobody", 5);
  account.remove("bvh", 1000);  // never below zero
  CHECK(account.used_bytes() == 0);
}

TEST_CASE("a refusal gives the numbers, the owner, the largest others and the remedy, and changes nothing") {
  MemoryAccount account(1000, 600);
  account.add("scene", "vertices", 500);
  account.add("bvh", "nodes", 200);
  const Error total = error_of([&] { account.add("film", "layers", 301, "lower --size"); });
  CHECK(total.error_class() == ErrorClass::device);
  CHECK(std::string(total.what()) ==
        "not enough device memory for layers of film: 301 bytes, while 700 bytes of 1000 bytes are in use "
        "(held by scene 500 bytes, bvh 200 bytes); lower --size");
  const Error single = error_of([&] { account.require("film", "layers", 601, "lower --size"); });
  CHECK(
      std::string(single.what()) ==
      "not enough device memory for layers of film: 601 bytes in one piece, while the limit for one allocation is 600 "
      "bytes; lower --size");
  // Several allocations that fit one by one.
  MemoryAccount empty(1000, 600);
  empty.require_total("film", "layers", 1000);
  CHECK(std::string(error_of([&] { empty.require_total("film", "layers", 1001); }).what()) ==
        "not enough device memory for layers of film: 1001 bytes, while 0 bytes of 1000 bytes are in use");
  CHECK(account.used_bytes() == 700);
  account.add("film", "layers", 300);
  CHECK(account.used_bytes() == 1000);
}

TEST_CASE("buffers are refused by the artificial caps before anything is created") {
  DeviceOptions options;
  options.memory_limit_bytes = 1 << 20;
  options.allocation_limit_bytes = 700 << 10;
  const auto device = Device::open(options);
  CHECK(device->memory().total_bytes() == 1 << 20);
  CHECK(device->memory().single_bytes() == 700 << 10);
  const Buffer held(*device, "scene", "vertices", 600 << 10);
  const Error error = error_of([&] { Buffer(*device, "film", "layers", 600 << 10, "lower --size"); });
  CHECK(std::string(error.what()) ==
        "not enough device memory for layers of film: 600.0 KiB, while 600.0 KiB of 1.00 MiB are in use (held by scene "
        "600.0 KiB); lower --size");
  CHECK(has(error_of([&] { Buffer(*device, "film", "layers", 701 << 10); }).what(),
            "limit for one allocation is 700.0 KiB"));
  const Error absurd =
      error_of([&] { TypedBuffer<uint64_t>(*device, "film", "layers", std::numeric_limits<size_t>::max() / 4); });
  CHECK(has(absurd.what(), "16.0 EiB in one piece"));
  CHECK(device->memory().used_bytes() == 600 << 10);
}

TEST_CASE("the caps can be set in the environment, and options win") {
  const ScopedVariable total("LUCARIUM_MEMORY_LIMIT", "64M"), single("LUCARIUM_ALLOCATION_LIMIT", "16M");
  CHECK(Device::open()->memory().total_bytes() == 64 << 20);
  CHECK(Device::open()->memory().single_bytes() == 16 << 20);
  DeviceOptions options;
  options.memory_limit_bytes = 8 << 20;
  CHECK(Device::open(options)->memory().total_bytes() == 8 << 20);
  const ScopedVariable wrong("LUCARIUM_MEMORY_LIMIT", "much");
  const Error error = error_of([] { Device::open(); });
  CHECK(error.error_class() == ErrorClass::usage);
  CHECK(has(error.what(), "LUCARIUM_MEMORY_LIMIT: 'much' is not a number of bytes"));
}

TEST_CASE("a CPU device never promises more than the host has") {
  if (test_device()->info().type != DeviceType::cpu) return skip("a CPU device");
  CHECK(available_host_memory() > 0);
  CHECK(test_device()->memory().total_bytes() <= test_device()->info().global_memory_bytes);
  CHECK(map_host_memory(std::numeric_limits<size_t>::max() / 2) == nullptr);
}

TEST_CASE("memory that the system refuses is an error, not an abort") {
  if (test_device()->info().type != DeviceType::cpu) return skip("a CPU device");
  const size_t before = test_device()->memory().used_bytes();
  rlimit old{};
  getrlimit(RLIMIT_AS, &old);
  std::ifstream statistics("/proc/self/statm");
  size_t pages = 0;
  statistics >> pages;
  rlimit tight = old;
  tight.rlim_cur = pages * static_cast<size_t>(getpagesize()) + (size_t{64} << 20);
  setrlimit(RLIMIT_AS, &tight);
  const Error error =
      error_of([] { Buffer(*test_device(), "scene", "vertices", size_t{512} << 20, "simplify the scene"); });
  setrlimit(RLIMIT_AS, &old);
  CHECK(std::string(error.what()) ==
        "not enough host memory: the system refuses 512.0 MiB for vertices of scene; simplify the scene");
  CHECK(test_device()->memory().used_bytes() == before);
}

TEST_CASE("numbers of bytes are read and written") {
  CHECK(format_bytes(0) == "0 bytes");
  CHECK(format_bytes(1536) == "1.50 KiB");
  CHECK(format_bytes(size_t{300} << 20) == "300.0 MiB");
  CHECK(parse_bytes("4096", "x") == 4096);
  CHECK(parse_bytes("1.5k", "x") == 1536);
  CHECK(parse_bytes("2GiB", "x") == size_t{2} << 30);
  CHECK(parse_bytes("3TB", "x") == size_t{3} << 40);
  for (const std::string wrong : {"", "M", "-1", "1X", "1MM", "1 2", "nan", "inf", "99999999T", "0x10"}) {
    CAPTURE(wrong);
    CHECK(error_of([&] { parse_bytes(wrong, "--limit"); }).error_class() == ErrorClass::usage);
  }
}
