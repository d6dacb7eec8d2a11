// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/device/scene_transform.h"

#include "lucarium/compute/program/source_library.h"
#include "lucarium/compute/schedule/scheduler.h"

namespace lucarium {

namespace {

constexpr size_t group_size = 64;

}  // namespace

SceneTransform::SceneTransform(Device& device)
    : program_(device, SourceLibrary(), {"scene/transform", {"lucarium/scene/device/transform_vertices.cl"}, {}}) {}

void SceneTransform::run(const std::vector<VertexRange>& ranges, const SceneTransformBuffers& buffers,
                         bool triangles) const {
  Device& device = program_.device();
  KernelScheduler scheduler(device.shared_from_this());
  ScheduleRecorder recorder = scheduler.record("scene transform", "scene");
  const uint32_t instance_count = static_cast<uint32_t>(buffers.instances.count());
  for (const VertexRange& range : ranges) {
    if (range.count == 0) continue;
    recorder.pass("transform vertices", program_, "transform_vertices")
        .global(range.count)
        .local(group_size)
        .arg("first", range.first)
        .arg("count", range.count)
        .arg("instance_count", instance_count)
        .arg("scene_instances", buffers.instances)
        .arg("scene_mesh_vertices", buffers.mesh_vertices)
        .arg("scene_vertices", buffers.vertices)
        .moves_bytes(size_t{2} * range.count * sizeof(Vertex));
  }
  if (triangles && buffers.triangles.count() > 0) {
    recorder.pass("derive triangles", program_, "derive_triangles")
        .global(buffers.triangles.count())
        .local(group_size)
        .arg("triangle_count", static_cast<uint32_t>(buffers.triangles.count()))
        .arg("instance_count", instance_count)
        .arg("scene_instances", buffers.instances)
        .arg("scene_mesh_triangles", buffers.mesh_triangles)
        .arg("scene_triangles", buffers.triangles)
        .moves_bytes(buffers.triangles.count() * (sizeof(uint4) + sizeof(Triangle)));
  }
  Schedule schedule = recorder.compile();
  scheduler.run_to_end(schedule);  // half-derived geometry would be worse than a late Ctrl-C
  scheduler.finish();
}

}  // namespace lucarium
