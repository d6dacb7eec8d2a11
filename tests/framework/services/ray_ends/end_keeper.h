// SPDX-License-Identifier: Apache-2.0
// An intersector that wants ends of rays, and keeps all that it is given.
#pragma once
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "device_fixture.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/bvh/bvh.h"

const lucarium::EmbeddedSources& test_services_kernels();

namespace lucarium::test {

struct KeptRay {
  Ray ray;
  RayEnds ends;
  bool any;
};

class EndKeeper : public Intersector {
 public:
  EndKeeper(const Bvh& bvh, uint32_t room)
      : bvh_(bvh),
        room_(room),
        program_(make_program(*test_device(), test_services_kernels(), {"test_services/ray_ends/keep_ends"},
                              {{"LUCARIUM_RAY_ENDS", ""}})),
        rays_(*test_device(), "test", "kept rays", room),
        ends_(*test_device(), "test", "kept ends", room),
        count_(*test_device(), "test", "number of kept rays", 1) {}

  std::string name() const override { return "end keeper"; }
  bool wants_ends() const override { return true; }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                      const BufferRef& hits) const override {
    keep(recorder, rays, 0);
    bvh_.record_closest(recorder, pass_name, rays, hits);
  }
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                  const BufferRef& occluded) const override {
    keep(recorder, rays, 1);
    bvh_.record_any(recorder, pass_name, rays, occluded);
  }

  const Program& program() const { return program_; }
  /// The rays since the last call, in no order.
  std::vector<KeptRay> take() {
    const uint32_t count = count_.download()[0];
    REQUIRE(count <= room_);
    const std::vector<Ray> rays = rays_.download(0, count);
    const std::vector<uint4> ends = ends_.download(0, count);
    std::vector<KeptRay> kept;
    for (uint32_t i = 0; i < count; ++i) kept.push_back({rays[i], {ends[i].x, ends[i].y}, ends[i].z != 0});
    count_.fill_zero();
    return kept;
  }

 private:
  void keep(ScheduleRecorder& recorder, const RayBuffers& rays, uint32_t any) const {
    recorder.pass("keep ends", program_, "keep_ends")
        .global(rays.capacity)
        .arg("rays", rays.rays)
        .arg("ends", rays.ends)
        .arg("counter", rays.counter)
        .arg("counter_index", rays.counter_index)
        .arg("shadow", any)
        .arg("room", room_)
        .arg("kept_rays", rays_)
        .arg("kept_ends", ends_)
        .arg("kept_count", count_);
  }
  const Bvh& bvh_;
  uint32_t room_;
  Program program_;
  TypedBuffer<Ray> rays_;
  TypedBuffer<uint4> ends_;
  TypedBuffer<uint32_t> count_;
};

}  // namespace lucarium::test
