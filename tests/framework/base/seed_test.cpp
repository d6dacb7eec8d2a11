// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/seed.h"

#include <doctest/doctest.h>

using namespace lucarium;

// Pictures of earlier versions are repeated with their seeds: these numbers must not change.
TEST_CASE("seeds of kernels are those of earlier versions") {
  CHECK(kernel_seed(1) == 1u);
  CHECK(kernel_seed(0x0000000300000005ull) == 6u);
  CHECK(indexed_seed(7, 0) == 7u);
  CHECK(indexed_seed(7, 1) == (7u ^ 2654435769u));
  CHECK(mixed_seed(7, 1) == (7u ^ 2654435769u) * 2246822507u);
}
