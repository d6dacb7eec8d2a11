// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/layer_sums/layer_sums.h"

#include <doctest/doctest.h>

#include "device_fixture.h"
#include "lucarium/base/error.h"

using namespace lucarium;

TEST_CASE("layers show the mean over samples, what has none is black, and equal names add up") {
  LayerSums sums(*test::test_device(), "test", 3, {"direct", "indirect"});
  TypedBuffer<float4> direct = sums["direct"];  // copies share the memory
  direct.upload({{2, 4, 6, 4}, {1, 1, 1, 0}, {0, 0, 9, 0.5f}});
  Film film(3, 1);
  film.layer("direct", {"R", "G", "B"}, true).pixels = {1, 0, 0, 0, 0, 0, 0, 0, 0};
  sums.write(film);
  CHECK(film.find("direct")->pixels == std::vector<float>{1.5f, 1, 1.5f, 0, 0, 0, 0, 0, 18});
  CHECK(film.find("direct")->additive);
  CHECK(film.find("indirect")->pixels == std::vector<float>(9, 0.f));

  sums.clear();
  CHECK(sums["direct"].download()[0].w == 0);
}

TEST_CASE("a layer that is not there and a film of another size are refused") {
  const LayerSums sums(*test::test_device(), "test", 3, {"direct"});
  CHECK_THROWS_WITH_AS(sums["emission"], "there are no sums of a layer 'emission'", Error);
  Film film(2, 1);
  CHECK_THROWS_AS(sums.write(film), Error);
}
