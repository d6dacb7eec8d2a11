// SPDX-License-Identifier: Apache-2.0
// Which device gets which task.
#include "lucarium/compare/execute/device_shares.h"

#include <doctest/doctest.h>

using lucarium::DeviceShares;

TEST_CASE("tasks whose times are compared go to one device, the others to whichever is free") {
  DeviceShares shares({"a", "a", "b", "b", "", ""}, 2);
  CHECK(shares.take(0) == 0);
  CHECK(shares.take(1) == 2);
  CHECK(shares.take(1) == 3);
  CHECK(shares.take(0) == 1);
  CHECK(shares.take(0) == 4);
  CHECK(shares.take(1) == 5);
  CHECK(!shares.take(0));
  for (size_t task = 0; task < 6; ++task) shares.finish(task);
  CHECK(shares.all_done());
}

TEST_CASE("a task that fails is tried once on each device, and has failed when all of them have") {
  DeviceShares shares({"", "a"}, 2);
  REQUIRE(shares.take(0) == 0);
  REQUIRE(shares.take(1) == 1);
  CHECK(shares.fail(0, 0));
  CHECK(!shares.take(0));  // not here again
  CHECK(shares.fail(1, 1));
  CHECK(shares.take(1) == 0);
  CHECK(shares.take(0) == 1);
  CHECK(!shares.fail(0, 1));
  shares.finish(1);
  CHECK(shares.all_done());
}

TEST_CASE("a device is set aside when others make its failures good, and does what they failed all the same") {
  DeviceShares shares({"", "", "", "", ""}, 2);
  for (size_t task = 0; task < DeviceShares::patience; ++task) {
    REQUIRE(shares.take(0) == task);
    REQUIRE(shares.fail(task, 0));
    REQUIRE(shares.take(1) == task);
    const std::vector<size_t> idle = shares.finish(task);
    CHECK(idle == (task + 1 < DeviceShares::patience ? std::vector<size_t>{} : std::vector<size_t>{0}));
  }
  CHECK(!shares.take(0));
  REQUIRE(shares.take(1) == 3);
  CHECK(shares.fail(3, 1));
  CHECK(shares.take(0) == 3);
  CHECK(!shares.fail(3, 0));
  CHECK(shares.take(1) == 4);
}
