// SPDX-License-Identifier: Apache-2.0
// Rasterized first visibility: what rays through the centres of pixels see.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

#include "../../framework/services/layered_raster/scene.h"
#include "abuffer_rig.h"
#include "lucarium/base/error.h"
#include "lucarium/scene/builtin/scenes.h"
#include "lucarium/shared/camera.h"
#include "technique_picture.h"
#include "test_support.h"
#include "voxel_abuffer/modes/primary_raster.h"

using namespace lucarium;
using namespace lucarium::test;
using abuffer::PrimaryRaster;

namespace {

/// Rays that nothing stops: zeroes as hits.
class Nothing : public Intersector {
 public:
  std::string name() const override { return "nothing"; }
  void record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers&,
                      const BufferRef& hits) const override {
    recorder.fill_zero(pass_name + ", nothing", hits);
  }
  void record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers&,
                  const BufferRef& occluded) const override {
    recorder.fill_zero(pass_name + ", nothing", occluded);
  }
};

Frame frame_of(const Scene& scene, uint32_t width, uint32_t height) {
  RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  settings.camera = scene.cameras.front();
  return make_frame(settings);
}

/// Camera rays (kernels/lucarium/camera.clh), each with a seed of its own; `offset`: of the centre [pixels].
std::vector<Ray> camera_rays(const Frame& frame, float offset) {
  const Camera& camera = frame.camera;
  std::vector<Ray> rays;
  for (uint32_t y = 0; y < frame.height; ++y)
    for (uint32_t x = 0; x < frame.width; ++x) {
      const float sx = 2 * (static_cast<float>(x) + 0.5f + offset) / static_cast<float>(frame.width) - 1;
      const float sy = 1 - 2 * (static_cast<float>(y) + 0.5f) / static_cast<float>(frame.height);
      const glm::vec3 d = camera.direction.xyz() + sx * camera.direction_dx.xyz() + sy * camera.direction_dy.xyz();
      Ray ray = make_ray(camera.origin.xyz(), glm::normalize(d));
      const uint32_t seed = static_cast<uint32_t>(rays.size()) + 1;
      std::memcpy(&ray.origin.w, &seed, sizeof(seed));
      rays.push_back(ray);
    }
  return rays;
}

struct HitDifferences {
  uint32_t triangles = 0, far = 0, hits = 0;
};
HitDifferences compare(const std::vector<Hit>& expected, const std::vector<Hit>& found) {
  HitDifferences d;
  for (size_t i = 0; i < expected.size(); ++i) {
    d.hits += expected[i].triangle != LUCARIUM_NO_HIT;
    if (expected[i].triangle != found[i].triangle)
      ++d.triangles;
    else if (expected[i].triangle != LUCARIUM_NO_HIT)
      d.far += !(std::fabs(expected[i].distance - found[i].distance) <= 1e-4f * expected[i].distance) ||
               std::fabs(expected[i].u - found[i].u) > 2e-3f || std::fabs(expected[i].v - found[i].v) > 2e-3f;
  }
  return d;
}

}  // namespace

TEST_CASE("primary: rasterized pixels see what rays through their centres see, and no ray is traced") {
  for (const char* name : {"atrium", "cornell", "solids"}) {
    CAPTURE(name);
    AbufferRig rig(make_builtin_scene(name));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const Frame frame = frame_of(rig.scene, 160, 100);
    const Nothing nothing;
    PrimaryRaster raster(rig.scheduler, rig.buffers, nothing, frame.width, frame.height);
    raster.rasterize(frame);
    const std::vector<Ray> rays = camera_rays(frame, 0);
    const HitDifferences d = compare(rig.trace(bvh, rays).hits, rig.trace(raster, rays).hits);
    MESSAGE(d.triangles, " other triangles, ", d.far, " elsewhere of ", d.hits);
    CHECK(d.hits > rays.size() / 2);
    CHECK(d.triangles <= rays.size() / 100);  // edges: corners are snapped to 1/256 pixel
    CHECK(d.far <= rays.size() / 1000);
  }
}

TEST_CASE("primary: all other rays are left to the intersector below") {
  AbufferRig rig(make_builtin_scene("cornell"));
  const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
  const Frame frame = frame_of(rig.scene, 64, 48);
  PrimaryRaster raster(rig.scheduler, rig.buffers, bvh, frame.width, frame.height);
  raster.rasterize(frame);
  std::vector<Ray> rays = camera_rays(frame, 0.3f);
  const std::vector<Ray> others = scene_rays(rig, 3000, 4).rays;
  for (size_t i = 0; i < others.size(); ++i)
    if (i % 3 != 0) rays.push_back(others[i]);  // those begin at the eye
  for (Ray ray : camera_rays(frame, 0)) {       // beside the eye
    ray.origin.x += 0.05f;
    rays.push_back(ray);
  }
  Ray inactive = camera_rays(frame, 0)[100];
  inactive.direction.w = -1;
  rays.push_back(inactive);
  const AbufferRig::Results expected = rig.trace(bvh, rays), found = rig.trace(raster, rays);
  uint32_t wrong = 0;
  for (size_t i = 0; i < rays.size(); ++i) wrong += std::memcmp(&expected.hits[i], &found.hits[i], sizeof(Hit)) != 0;
  CHECK(wrong == 0);
  CHECK(expected.occluded == found.occluded);
}

TEST_CASE("primary: MASK and BLEND are decided as by rays") {
  for (const AlphaMode mode : {AlphaMode::blend, AlphaMode::mask}) {
    Scene scene = scene_of(random_soup(400, 5, 1), veil(0.4f, mode));
    scene.cameras.push_back(make_builtin_scene("cornell").cameras[0]);
    scene.cameras[0].world_from_camera = glm::mat4(1);
    scene.cameras[0].world_from_camera[3] = glm::vec4(0, 0, 4, 1);
    AbufferRig rig(std::move(scene));
    const Bvh bvh(rig.scheduler.device(), rig.scene, rig.buffers);
    const Frame frame = frame_of(rig.scene, 96, 96);
    PrimaryRaster raster(rig.scheduler, rig.buffers, bvh, frame.width, frame.height);
    raster.rasterize(frame);
    const std::vector<Ray> rays = camera_rays(frame, 0);
    const HitDifferences d = compare(rig.trace(bvh, rays).hits, rig.trace(raster, rays).hits);
    CHECK((mode == AlphaMode::mask ? d.hits == 0 : d.hits > 1000));
    CHECK(d.triangles <= rays.size() / 100);
  }
}

TEST_CASE("primary: pictures of all modes are those of traced pixels") {
  const Scene scene = make_builtin_scene("cornell");
  const Picture centres = {.size = 64, .max_bounces = 1, .pixel_sampling = LUCARIUM_PIXEL_CENTRE};
  for (const char* mode : {"cast", "whitted", "ao", "path"}) {
    CAPTURE(mode);
    const auto picture = [&](const char* primary) {
      return render(scene, centres, {{"mode", mode}, {"abuffer_size", "256"}, {"primary", primary}});
    };
    const Film traced = picture("trace"), rasterized = picture("raster"), chosen = picture("auto");
    uint32_t values = 0, other = 0;
    for (const FilmLayer& layer : traced.layers()) {
      const std::vector<float>& found = rasterized.find(layer.name)->pixels;
      CHECK(found == chosen.find(layer.name)->pixels);
      for (size_t i = 0; i < found.size(); ++i) {
        ++values;
        other += std::fabs(found[i] - layer.pixels[i]) > 1e-3f + 0.01f * std::fabs(layer.pixels[i]);
      }
    }
    CHECK(other <= values / 50);
  }
}

TEST_CASE("primary: what cannot be rasterized is refused in one line, and auto traces it") {
  const Scene scene = make_builtin_scene("cornell");
  Picture picture;
  CHECK_THROWS_WITH_AS(render(scene, picture, {{"primary", "raster"}}),
                       "voxel_abuffer: primary=raster with --pixel-sampling jitter: pixels are rasterized at their "
                       "centres; set --pixel-sampling center",
                       Error);
  picture.pixel_sampling = 4;
  CHECK_THROWS_WITH_AS(render(scene, picture, {{"primary", "raster"}}),
                       doctest::Contains("primary=raster with --pixel-sampling 4:"), Error);
  const auto light = [&](const char* primary) {
    return render(scene, picture, {{"abuffer_size", "256"}, {"primary", primary}}).find("direct")->pixels;
  };
  CHECK(light("auto") == light("trace"));
  picture.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  Scene flat = scene;
  flat.cameras[0].perspective = false;
  CHECK_THROWS_WITH_AS(render(flat, picture, {{"primary", "raster"}}),
                       doctest::Contains("primary=raster with an orthographic camera"), Error);
}
