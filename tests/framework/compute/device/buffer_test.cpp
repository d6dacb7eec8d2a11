// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/buffer.h"

#include <doctest/doctest.h>

#include <limits>
#include <memory>
#include <numeric>

#include "compute_fixture.h"

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("a buffer starts zeroed and keeps what is written") {
  TypedBuffer<uint32_t> buffer(*test_device(), "test", "numbers", 1000);
  CHECK(buffer.download() == std::vector<uint32_t>(1000, 0));
  std::vector<uint32_t> values(1000);
  std::iota(values.begin(), values.end(), 7);
  buffer.upload(values);
  CHECK(buffer.download() == values);
  CHECK(buffer.download(10, 3) == std::vector<uint32_t>{17, 18, 19});
  buffer.upload({1, 2}, 998);
  CHECK(buffer.download(997, 3) == std::vector<uint32_t>{1004, 1, 2});
  buffer.fill_zero();
  CHECK(buffer.download() == std::vector<uint32_t>(1000, 0));
}

TEST_CASE("what a buffer holds can be read in place, and written again when it was given back") {
  TypedBuffer<uint32_t> buffer(*test_device(), "test", "numbers", std::vector<uint32_t>{1, 2, 3});
  {
    std::shared_ptr<const uint32_t[]> elements = buffer.elements();
    const std::shared_ptr<const uint32_t[]> again = elements;
    elements.reset();
    CHECK(std::vector<uint32_t>(again.get(), again.get() + 3) == std::vector<uint32_t>{1, 2, 3});
  }
  buffer.upload({4}, 1);
  CHECK(buffer.elements()[1] == 4);
  CHECK(TypedBuffer<float>(*test_device(), "test", "empty", size_t{0}).elements() != nullptr);
  CHECK_THROWS_AS(TypedBuffer<float>().elements(), Error);
  std::shared_ptr<const uint32_t[]> last;
  {
    const TypedBuffer<uint32_t> short_lived(*test_device(), "test", "numbers", std::vector<uint32_t>{5});
    last = short_lived.elements();
  }
  CHECK(last[0] == 5);
}

TEST_CASE("copies of a buffer share its memory, and the last one gives it back") {
  const size_t before = test_device()->memory().used_bytes();
  {
    TypedBuffer<float> buffer(*test_device(), "test", "shared", std::vector<float>{1, 2, 3});
    const Buffer copy = buffer;
    CHECK(copy.same_memory(buffer));
    CHECK(test_device()->memory().used_bytes() == before + 64);
    buffer = TypedBuffer<float>();
    CHECK(test_device()->memory().by_owner().at("test") == 64);
    float value = 0;
    copy.read(&value, sizeof value, 4);
    CHECK(value == 2);
  }
  CHECK(test_device()->memory().used_bytes() == before);
}

TEST_CASE("an empty buffer is usable") {
  TypedBuffer<float> buffer(*test_device(), "test", "empty", size_t{0});
  CHECK(buffer.handle() != nullptr);
  CHECK(buffer.download().empty());
  CHECK_THROWS_AS(buffer.download(0, 1), Error);
}

TEST_CASE("a range outside a buffer is refused") {
  TypedBuffer<uint32_t> buffer(*test_device(), "test", "small", 4);
  const std::vector<uint32_t> two = {1, 2};
  CHECK_THROWS_WITH_AS(buffer.upload(two, 3), "writing 8 bytes at 12 is outside buffer 'small' of test (16 bytes)",
                       Error);
  CHECK_THROWS_AS(buffer.download(4, 1), Error);
  CHECK_THROWS_AS(buffer.download(std::numeric_limits<size_t>::max(), 2), Error);
  CHECK_THROWS_AS(buffer.download(0, std::numeric_limits<size_t>::max()), Error);
}
