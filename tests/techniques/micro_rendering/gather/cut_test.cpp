// SPDX-License-Identifier: Apache-2.0
// Cuts driven by the spread of radiance (cut_error), and micro-buffers enlarged where frames differ (adaptive).
#include <doctest/doctest.h>

#include "technique_fixture.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::test;

namespace {

struct Outcome {
  std::vector<float> indirect;
  double visits = 0;  // per gather
};

Outcome render(const Parameters& parameters, uint64_t iterations) {
  Scene scene = load_scene("builtin:room");
  const RenderSettings settings = settings_for(scene, 24, 1);
  RenderSession session(Device::open(), std::move(scene), registry().find("micro_rendering"), settings,
                        with(small, parameters));
  session.run({.iterations = iterations});
  const auto counters = session.technique().counters();
  return {session.resolve().find("indirect")->pixels, counters.at("node visits") / counters.at("gathers")};
}

const std::vector<float>& expected_light() {
  static const std::vector<float> light =
      indirect_light(load_scene("builtin:room"), "path_tracing", 24, 1, 64, reference);
  return light;
}

}  // namespace

TEST_CASE("an error-driven cut refines where radiance varies: nearly the error of a fine cut, far fewer nodes") {
  const std::vector<float>& expected = expected_light();
  // Micro-buffers so small, and frames so many, that coarse nodes show.
  const auto with_cut = [](const char* kappa, const char* error) {
    return render({{"points_log2", "15"}, {"micro_size", "12"}, {"cut_kappa", kappa}, {"cut_error", error}}, 32);
  };
  const Outcome fine = with_cut("1", "0"), coarse = with_cut("4", "0"), driven = with_cut("4", "0.005");
  const double fine_error = relative_rmse(fine.indirect, expected),
               coarse_error = relative_rmse(coarse.indirect, expected),
               driven_error = relative_rmse(driven.indirect, expected);
  MESSAGE("errors ", fine_error, " ", driven_error, " ", coarse_error, ", visits ", fine.visits, " ", driven.visits,
          " ", coarse.visits);
  CHECK(driven_error < 0.5 * (fine_error + coarse_error));
  CHECK(driven.visits < 0.55 * fine.visits);
  CHECK(driven.visits > coarse.visits);
}

TEST_CASE("where the whole cut is even, the next frames' is coarser") {
  const Outcome one = render({{"cut_error", "1"}}, 1), off = render({}, 1), several = render({{"cut_error", "1"}}, 9);
  CHECK(one.visits == test::relative(off.visits, 1e-6));
  // One of nine frames at kappa, eight at 4 kappa.
  MESSAGE("visits ", off.visits, " then ", several.visits);
  CHECK(several.visits < 0.6 * off.visits);
}

TEST_CASE("adaptive micro-buffers grow where frames differ and nowhere else") {
  const Outcome small_ones = render({{"micro_size", "8"}}, 8), large_ones = render({{"micro_size", "12"}}, 8),
                some = render({{"micro_size", "8"}, {"adaptive", "0.05"}}, 8),
                none = render({{"micro_size", "8"}, {"adaptive", "1"}}, 8);
  CHECK(some.visits > 1.02 * small_ones.visits);
  CHECK(some.visits < large_ones.visits);
  CHECK(none.visits == test::relative(small_ones.visits, 1e-6));
  const std::vector<float>& expected = expected_light();
  MESSAGE("errors ", relative_rmse(small_ones.indirect, expected), " ", relative_rmse(some.indirect, expected), " ",
          relative_rmse(large_ones.indirect, expected), ", visits ", small_ones.visits, " ", some.visits, " ",
          large_ones.visits);
  CHECK(relative_rmse(some.indirect, expected) < relative_rmse(small_ones.indirect, expected));
}
