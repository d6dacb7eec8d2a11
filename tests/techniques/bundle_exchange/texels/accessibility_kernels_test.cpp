// SPDX-License-Identifier: Apache-2.0
// What kernels make of counted rays and of light samples, for counts and samples made by hand.
#include <doctest/doctest.h>

#include "bundle_rig.h"
#include "lucarium/compute/program/source_library.h"
#include "test_support.h"
#include "tolerance.h"

using namespace lucarium;
using namespace lucarium::bundle;

namespace {

constexpr uint32_t kLevels = 3;  // of full accessibility

/// The technique's kernels on buffers of the test.
class Kernels {
 public:
  Kernels()
      : device_(Device::open()),
        scheduler_(device_),
        program_(*device_, SourceLibrary(),
                 {"test",
                  {"lucarium/services/texel_sides/finish_accessibility.cl",
                   "lucarium/services/texel_sides/sample_side_light.cl"},
                  {}}) {}

  template <class T>
  TypedBuffer<T> buffer(const std::vector<T>& values) {
    return TypedBuffer<T>(*device_, "test", "values", values);
  }
  void run(const char* kernel, uint32_t size, const std::function<void(PassBuilder&)>& bind) {
    ScheduleRecorder recorder = scheduler_.record(kernel, "test");
    PassBuilder pass = recorder.pass(kernel, program_, kernel);
    bind(pass.global(size));
    Schedule schedule = recorder.compile();
    scheduler_.run_to_end(schedule);
    scheduler_.finish();
  }

 private:
  std::shared_ptr<Device> device_;
  KernelScheduler scheduler_;
  Program program_;
};

/// Rays of one part: all, of them those that end at backs, and near ones of the others (side_parts.clh).
uint32_t counted(uint32_t rays, uint32_t backs, uint32_t near) { return rays | near << 10 | backs << 20; }

/// A texel side whose parts are given, the others without rays; its k-th point lies in part k.
struct Side {
  std::vector<uint32_t> parts;
  float2 interior{1, 1};  ///< x share that is not hidden; y what a ray counts that meets a back
  uint32_t hidden = 0;    ///< bits of points
};
struct Accessibility {
  float share;
  std::vector<uint32_t> parts, points;  ///< levels, 0 to kLevels
};
std::vector<Accessibility> finish(const std::vector<Side>& sides) {
  Kernels kernels;
  std::vector<AtlasTriangle> triangles;
  std::vector<AtlasSample> samples;
  std::vector<uint32_t> counts, hidden;
  std::vector<float2> interior;
  for (uint32_t k = 0; k < SIDE_PARTS; ++k) {  // charts of one texel
    triangles.push_back(AtlasTriangle{});
    triangles.back().pitch_key = k << LUCARIUM_ATLAS_PITCH_BITS;
  }
  for (const Side& side : sides) {
    for (uint32_t k = 0; k < SIDE_POINTS; ++k) samples.push_back({k, 0.f, 0.f});
    for (uint32_t k = 0; k < SIDE_PARTS; ++k) counts.push_back(k < side.parts.size() ? side.parts[k] : 0);
    interior.push_back(side.interior);
    hidden.push_back(side.hidden);
  }
  const auto count = static_cast<uint32_t>(sides.size());
  const auto shares = kernels.buffer(std::vector<float>(count));
  const auto parts = kernels.buffer(std::vector<uint32_t>(size_t{count} * SIDE_PART_WORDS));
  const auto points = kernels.buffer(std::vector<uint32_t>(count));
  const auto all_triangles = kernels.buffer(triangles);
  const auto all_samples = kernels.buffer(samples);
  const auto all_counts = kernels.buffer(counts), all_hidden = kernels.buffer(hidden);
  const auto all_interior = kernels.buffer(interior);
  kernels.run("finish_accessibility", count, [&](PassBuilder& pass) {
    pass.arg("sides", count).arg("atlas_info", AtlasInfo{count, 0, SIDE_PARTS, 1.f});
    pass.arg("atlas_triangles", all_triangles).arg("atlas_samples", all_samples).arg("counts", all_counts);
    pass.arg("interior", all_interior).arg("hidden", all_hidden);
    pass.arg("share", shares).arg("accessibility", parts).arg("points", points);
  });
  std::vector<Accessibility> result;
  const std::vector<float> found_shares = shares.download();
  const std::vector<uint32_t> found_parts = parts.download(), found_points = points.download();
  for (uint32_t i = 0; i < count; ++i) {
    Accessibility a{found_shares[i], {}, {}};
    for (uint32_t k = 0; k < SIDE_PARTS; ++k)
      a.parts.push_back(found_parts[i * SIDE_PART_WORDS + k / 16] >> 2 * (k % 16) & 3);
    for (uint32_t k = 0; k < SIDE_POINTS; ++k) a.points.push_back(found_points[i] >> 4 * k & 15);
    result.push_back(std::move(a));
  }
  return result;
}

}  // namespace

TEST_CASE("parts of which all rays meet backs are closed where something is hidden, and where there are enough") {
  const uint32_t lost = counted(3, 3, 0), surely_lost = counted(6, 6, 0), open = counted(8, 0, 0);
  const std::vector<Accessibility> found = finish({
      {{lost, open, surely_lost}, {1, 1}, 0},         // no point is hidden: few lost rays say nothing
      {{lost, open, surely_lost}, {0.9f, 0.25f}, 0},  // some of it is
  });
  CHECK(found[0].parts[0] == kLevels);
  CHECK(found[0].parts[1] == kLevels);
  CHECK(found[0].parts[2] == 0);
  CHECK(found[0].points[0] == kLevels);
  CHECK(found[0].points[2] == 0);
  CHECK(found[1].parts[0] == 0);
  CHECK(found[1].parts[1] == kLevels);
  CHECK(found[1].parts[2] == 0);
  CHECK(found[1].points[0] == 0);
  // Of 17 rays, 11 begin in parts that count.
  CHECK(found[0].share == test::relative(11. / 17, 1e-6));
  CHECK(found[1].share == test::relative(8. / 17, 1e-6));
}

TEST_CASE("hidden points are closed, in open parts too") {
  const std::vector<Accessibility> found = finish({{{counted(8, 0, 0), counted(8, 0, 0)}, {0.75f, 1}, 2}});
  CHECK(found[0].points[0] == kLevels);
  CHECK(found[0].points[1] == 0);
  CHECK(found[0].share == 1);
}

TEST_CASE("parts are as open as the share of their rays that go far, without those that meet backs") {
  // Levels that are whole need no dither: none of 6 rays, beside which 6 meet backs, and two thirds of 9. All alike
  // where none goes far.
  const std::vector<Accessibility> found =
      finish({{{counted(12, 6, 6), counted(9, 0, 3)}, {1, 1}, 0}, {{counted(8, 0, 8), counted(8, 4, 4)}, {1, 1}, 0}});
  CHECK(found[0].parts[0] == 0);
  CHECK(found[0].parts[1] == 2);
  CHECK(found[0].share == test::relative(2 * 9 / (3. * 21), 1e-6));
  CHECK(found[1].parts[0] == kLevels);
  CHECK(found[1].parts[1] == kLevels);
}

TEST_CASE("light samples count by the accessibility of their points, and in the half that these belong to") {
  Kernels kernels;
  // Every point that is accessible has its turn equally often in 8 rounds for each.
  const std::vector<uint32_t> levels{3u | 0u << 4 | (1u | 8u) << 8 | 2u << 12, 0u};
  const auto all_levels = kernels.buffer(levels);
  const auto samples = kernels.buffer(std::vector<float4>(2, float4(5, 6, 7, 1)));
  const auto sums = kernels.buffer(std::vector<float4>(4));
  const uint32_t rounds = 8 * 3;
  for (uint32_t round = 0; round < rounds; ++round)
    kernels.run("scatter_samples", 2, [&](PassBuilder& pass) {
      pass.arg("first", 0u).arg("count", 2u).arg("sides", 2u).arg("round_index", round).arg("levels", all_levels);
      pass.arg("samples", samples).arg("light_samples", sums);
    });
  const std::vector<float4> found = sums.download();
  CHECK(found[0].w + found[2].w == 8 * (3 + 1 + 2));
  CHECK(found[2].w == 8 * 1);  // the covered half
  CHECK(found[3].w == 0);
  CHECK(found[0].x == 5 * found[0].w);
  CHECK(found[1].w == rounds);  // none is accessible: all alike
}
