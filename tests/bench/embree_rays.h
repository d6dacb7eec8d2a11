// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#ifdef LUCARIUM_WITH_EMBREE
#include <embree3/rtcore.h>
#endif

#include "lucarium/shared/ray.h"
#include "lucarium/shared/scene_types.h"

namespace lucarium::bench {

#ifdef LUCARIUM_WITH_EMBREE

/// The yardstick: Embree's single-ray calls, one thread.
class EmbreeScene {
 public:
  EmbreeScene(std::span<const Vertex> vertices, std::span<const Triangle> triangles)
      : device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                  3 * sizeof(float), vertices.size()));
    for (const Vertex& vertex : vertices) {
      *positions++ = vertex.position.x;
      *positions++ = vertex.position.y;
      *positions++ = vertex.position.z;
    }
    auto* corners = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(uint32_t), triangles.size()));
    for (const Triangle& triangle : triangles) {
      *corners++ = triangle.v0;
      *corners++ = triangle.v1;
      *corners++ = triangle.v2;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  static bool available() { return true; }

  void trace(const std::vector<Ray>& rays, bool any) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (const Ray& ray : rays) {
      RTCRayHit query = {};
      query.ray.org_x = ray.origin.x, query.ray.org_y = ray.origin.y, query.ray.org_z = ray.origin.z;
      query.ray.dir_x = ray.direction.x, query.ray.dir_y = ray.direction.y, query.ray.dir_z = ray.direction.z;
      query.ray.tfar = ray.direction.w;
      query.ray.mask = 0xffffffffu;
      query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      if (any)
        rtcOccluded1(scene_, &context, &query.ray);
      else
        rtcIntersect1(scene_, &context, &query);
    }
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

#else

class EmbreeScene {
 public:
  EmbreeScene(std::span<const Vertex>, std::span<const Triangle>) {}
  static bool available() { return false; }
  void trace(const std::vector<Ray>&, bool) const {}
};

#endif

}  // namespace lucarium::bench
