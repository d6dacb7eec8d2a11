// SPDX-License-Identifier: Apache-2.0
#include "lucarium/view/inspect/pixel_surface.h"

#include "lucarium/scene/device/scene_layout.h"
#include "lucarium/services/gbuffer/gbuffer.h"
#include "lucarium/session/scene_on_device.h"
#include "lucarium/technique/technique.h"

namespace lucarium {

namespace {

glm::vec4 vector_of(const float4& v) { return {v.x, v.y, v.z, v.w}; }

/// The frame whose only pixel is pixel (x, y) of another: the camera is linear in film coordinates (shared/camera.h).
Frame single_pixel(const RenderSettings& settings, uint32_t x, uint32_t y) {
  Frame frame = make_frame(settings);
  const auto width = static_cast<float>(frame.width), height = static_cast<float>(frame.height);
  const float sx = 2 * (static_cast<float>(x) + 0.5f) / width - 1, sy = 1 - 2 * (static_cast<float>(y) + 0.5f) / height;
  Camera& camera = frame.camera;
  const auto shrink = [&](float4& middle, float4& dx, float4& dy) {
    middle = float4(vector_of(middle) + sx * vector_of(dx) + sy * vector_of(dy));
    dx = float4(vector_of(dx) / width);
    dy = float4(vector_of(dy) / height);
  };
  shrink(camera.origin, camera.origin_dx, camera.origin_dy);
  shrink(camera.direction, camera.direction_dx, camera.direction_dy);
  frame.width = frame.height = 1;
  frame.pixel_sampling = LUCARIUM_PIXEL_CENTRE;
  return frame;
}

/// Fills in whose triangle of the whole scene that is.
void name_triangle(PixelSurface& surface, const Scene& scene, uint32_t triangle) {
  const SceneLayout layout(scene);
  for (size_t i = 0; i < layout.instances.size(); ++i) {
    const Instance& instance = layout.instances[i];
    if (triangle < instance.world_triangle || triangle - instance.world_triangle >= instance.triangle_count) continue;
    surface.instance = static_cast<uint32_t>(i);
    surface.triangle = triangle - instance.world_triangle;
    surface.material = instance.material;
    surface.mesh = scene.meshes[static_cast<size_t>(scene.instances[i].mesh)].name;
    surface.material_name = scene.materials.at(instance.material).name;
  }
}

}  // namespace

PixelSurface find_pixel_surface(const std::shared_ptr<Device>& device, SceneOnDevice& scene,
                                const RenderSettings& settings, uint32_t x, uint32_t y) {
  if (!scene.buffers) scene.buffers = std::make_unique<SceneBuffers>(*device, scene.scene);
  if (!scene.bvh) scene.bvh = std::make_unique<Bvh>(*device, scene.scene, *scene.buffers);
  KernelScheduler scheduler(device);
  GBuffer gbuffer(*device, scheduler, *scene.buffers, *scene.bvh, single_pixel(settings, x, y), "inspector", true);
  gbuffer.render(0);
  const GBufferPoint point = gbuffer.points().download().front();
  PixelSurface surface;
  if (point.triangle == LUCARIUM_NONE) return surface;
  surface.hit = true;
  surface.distance = point.position.w;
  surface.position = vector_of(point.position);
  surface.normal = vector_of(point.normal);
  surface.shading = vector_of(point.shading);
  surface.seen = {.x = x,
                  .y = y,
                  .triangle = point.triangle,
                  .b1 = point.u,
                  .b2 = point.v,
                  .front = point.normal.w == 0,
                  .position = surface.position,
                  .normal = surface.normal};
  name_triangle(surface, scene.scene, point.triangle);
  return surface;
}

}  // namespace lucarium
