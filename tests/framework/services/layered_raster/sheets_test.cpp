// SPDX-License-Identifier: Apache-2.0
// Which texels may be of sheets in one place, of which each is met by half of the rays.
#include <doctest/doctest.h>

#include <vector>

#include "device_fixture.h"
#include "lucarium/compute/schedule/scheduler.h"
#include "lucarium/shared/surface_point.h"

const lucarium::EmbeddedSources& test_services_kernels();

using namespace lucarium;
using namespace lucarium::test;

TEST_CASE("sheets in one place are parallel and opaque") {
  const std::shared_ptr<Device> device = test_device();
  std::vector<SurfacePoint> points(7);
  const auto set = [&](size_t i, float x, float y, float z, uint32_t flags) {
    points[i].normal = {x, y, z, 0};
    points[i].flags = flags;
  };
  set(0, 0, 0, 1, 0);
  set(1, 0, 0, 1, 0);
  set(2, 0, 0, -1, 0);
  set(3, 1, 0, 0, 0);          // the wall beside it
  set(4, 0.1f, 0, 0.995f, 0);  // 6 degrees
  set(5, 0.01f, 0, 0.99995f, 0);
  set(6, 0, 0, -1, LUCARIUM_POINT_TRANSMITS);  // the other side of a pane
  const TypedBuffer<SurfacePoint> buffer(*device, "test", "points", points);
  const TypedBuffer<uint32_t> fits(*device, "test", "fits", points.size());
  KernelScheduler scheduler(device);
  const Program program = make_program(*device, test_services_kernels(), {"test_services/layered_raster/sheets"}, {});
  ScheduleRecorder recorder = scheduler.record("sheets", "test");
  recorder.pass("fit sheets", program, "fit_sheets")
      .global(points.size())
      .local(1)
      .arg("points", buffer)
      .arg("fits", fits);
  Schedule schedule = recorder.compile();
  scheduler.run(schedule);
  scheduler.finish();
  CHECK(fits.download() == std::vector<uint32_t>{1, 1, 1, 0, 0, 1, 0});
}
