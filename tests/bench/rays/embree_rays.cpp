// SPDX-License-Identifier: Apache-2.0
#include "embree_rays.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#ifdef LUCARIUM_WITH_EMBREE
#include <embree3/rtcore.h>
#endif

namespace lucarium::bench {

#ifdef LUCARIUM_WITH_EMBREE

struct EmbreeScene::State {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  double build_seconds = 0;
};

namespace {

RTCGeometry make_geometry(RTCDevice device, std::span<const Vertex> vertices, std::span<const Triangle> triangles) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
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
  return geometry;
}

RTCIntersectContext make_context(RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  return context;
}

void set_ray(RTCRay& to, const Ray& from) {
  to.org_x = from.origin.x, to.org_y = from.origin.y, to.org_z = from.origin.z;
  to.dir_x = from.direction.x, to.dir_y = from.direction.y, to.dir_z = from.direction.z;
  to.tnear = 0, to.tfar = from.direction.w, to.time = 0;
  to.mask = 0xffffffffu, to.id = 0, to.flags = 0;
}

void set_ray(RTCRay16& to, int lane, const Ray& from) {
  to.org_x[lane] = from.origin.x, to.org_y[lane] = from.origin.y, to.org_z[lane] = from.origin.z;
  to.dir_x[lane] = from.direction.x, to.dir_y[lane] = from.direction.y, to.dir_z[lane] = from.direction.z;
  to.tnear[lane] = 0, to.tfar[lane] = from.direction.w, to.time[lane] = 0;
  to.mask[lane] = 0xffffffffu, to.id[lane] = 0, to.flags[lane] = 0;
}

/// Lanes beyond the last ray are invalid (0), others valid (−1); returns how many are valid.
int fill_packet(RTCRay16& packet, int* valid, std::span<const Ray> rays, size_t first) {
  const int count = static_cast<int>(std::min<size_t>(16, rays.size() - first));
  for (int lane = 0; lane < 16; ++lane) {
    valid[lane] = lane < count ? -1 : 0;
    set_ray(packet, lane, rays[first + static_cast<size_t>(std::min(lane, count - 1))]);
  }
  return count;
}

}  // namespace

EmbreeScene::EmbreeScene(std::span<const Vertex> vertices, std::span<const Triangle> triangles, unsigned threads,
                         bool robust)
    : state_(std::make_unique<State>()) {
  state_->device = rtcNewDevice(("threads=" + std::to_string(threads)).c_str());
  state_->scene = rtcNewScene(state_->device);
  if (robust) rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = make_geometry(state_->device, vertices, triangles);
  const auto start = std::chrono::steady_clock::now();
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state_->scene);
  state_->build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

EmbreeScene::~EmbreeScene() {
  rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}

bool EmbreeScene::available() { return true; }

double EmbreeScene::build_seconds() const { return state_->build_seconds; }

void EmbreeScene::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRayHit query;
    set_ray(query.ray, rays[i]);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(state_->scene, &context, &query);
    const bool hit = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    hits[i] = {hit ? query.ray.tfar : INFINITY, hit ? query.hit.primID : LUCARIUM_NO_HIT, query.hit.u, query.hit.v};
  }
}

void EmbreeScene::any(std::span<const Ray> rays, std::span<uint32_t> occluded) const {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  for (size_t i = 0; i < rays.size(); ++i) {
    RTCRay query;
    set_ray(query, rays[i]);
    rtcOccluded1(state_->scene, &context, &query);
    occluded[i] = query.tfar < 0;
  }
}

void EmbreeScene::closest16(std::span<const Ray> rays, std::span<Hit> hits) const {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  alignas(64) int valid[16];
  for (size_t first = 0; first < rays.size(); first += 16) {
    RTCRayHit16 query;
    const int count = fill_packet(query.ray, valid, rays, first);
    std::fill_n(query.hit.geomID, 16, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(query.hit.instID[0], 16, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect16(valid, state_->scene, &context, &query);
    for (int i = 0; i < count; ++i) {
      const bool hit = query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
      hits[first + static_cast<size_t>(i)] = {hit ? query.ray.tfar[i] : INFINITY,
                                              hit ? query.hit.primID[i] : LUCARIUM_NO_HIT, query.hit.u[i],
                                              query.hit.v[i]};
    }
  }
}

void EmbreeScene::any16(std::span<const Ray> rays, std::span<uint32_t> occluded) const {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  alignas(64) int valid[16];
  for (size_t first = 0; first < rays.size(); first += 16) {
    RTCRay16 query;
    const int count = fill_packet(query, valid, rays, first);
    rtcOccluded16(valid, state_->scene, &context, &query);
    for (int i = 0; i < count; ++i) occluded[first + static_cast<size_t>(i)] = query.tfar[i] < 0;
  }
}

#else

struct EmbreeScene::State {};
EmbreeScene::EmbreeScene(std::span<const Vertex>, std::span<const Triangle>, unsigned, bool) {}
EmbreeScene::~EmbreeScene() = default;
bool EmbreeScene::available() { return false; }
double EmbreeScene::build_seconds() const { return 0; }
void EmbreeScene::closest(std::span<const Ray>, std::span<Hit>) const {}
void EmbreeScene::any(std::span<const Ray>, std::span<uint32_t>) const {}
void EmbreeScene::closest16(std::span<const Ray>, std::span<Hit>) const {}
void EmbreeScene::any16(std::span<const Ray>, std::span<uint32_t>) const {}

#endif

}  // namespace lucarium::bench
