// SPDX-License-Identifier: Apache-2.0
#include "lucarium/scene/scene_transform.h"

#include <variant>

#include "lucarium/base/error.h"
#include "lucarium/compute/cl_handle.h"

namespace lucarium {

namespace {

constexpr size_t group_size = 64;

/// One launch with arguments by name.
class Launch {
 public:
  Launch(const Program& program, const char* kernel) : program_(program), signature_(program.signature(kernel)) {
    cl_int code = CL_SUCCESS;
    kernel_ = ClKernel(clCreateKernel(program.handle(), kernel, &code));
    check_opencl(code, "clCreateKernel", kernel, program.device());
  }

  Launch& arg(std::string_view name, uint32_t value) { return set(name, sizeof value, &value); }
  Launch& arg(std::string_view name, const Buffer& buffer) {
    const cl_mem memory = buffer.handle();
    return set(name, sizeof memory, &memory);
  }

  void run(size_t items) {
    if (items == 0) return;
    const size_t global = (items + group_size - 1) / group_size * group_size;
    Device& device = program_.device();
    check_opencl(clEnqueueNDRangeKernel(device.queue(), kernel_.get(), 1, nullptr, &global, &group_size, 0, nullptr, nullptr),
                 "clEnqueueNDRangeKernel", signature_.name, device);
    device.finish();
  }

 private:
  Launch& set(std::string_view name, size_t bytes, const void* value) {
    for (size_t i = 0; i < signature_.arguments.size(); ++i) {
      if (signature_.arguments[i].name != name) continue;
      check_opencl(clSetKernelArg(kernel_.get(), static_cast<cl_uint>(i), bytes, value), "clSetKernelArg",
                   signature_.name, program_.device());
      return *this;
    }
    throw_error(ErrorClass::internal, "kernel {} has no argument '{}'", signature_.name, name);
  }

  const Program& program_;
  const KernelSignature& signature_;
  ClKernel kernel_;
};

}  // namespace

SceneTransform::SceneTransform(Device& device)
    : program_(device, SourceLibrary(), {"scene/transform", {"lucarium/scene/transform_vertices.cl"}, {}}) {}

void SceneTransform::transform_vertices(uint32_t first, uint32_t count, const TypedBuffer<Instance>& instances,
                                        const TypedBuffer<Vertex>& mesh_vertices,
                                        const TypedBuffer<Vertex>& vertices) const {
  Launch(program_, "transform_vertices")
      .arg("first", first)
      .arg("count", count)
      .arg("instance_count", static_cast<uint32_t>(instances.count()))
      .arg("scene_instances", instances)
      .arg("scene_mesh_vertices", mesh_vertices)
      .arg("scene_vertices", vertices)
      .run(count);
}

void SceneTransform::derive_triangles(const TypedBuffer<Instance>& instances,
                                      const TypedBuffer<uint4>& mesh_triangles,
                                      const TypedBuffer<Triangle>& triangles) const {
  Launch(program_, "derive_triangles")
      .arg("triangle_count", static_cast<uint32_t>(triangles.count()))
      .arg("instance_count", static_cast<uint32_t>(instances.count()))
      .arg("scene_instances", instances)
      .arg("scene_mesh_triangles", mesh_triangles)
      .arg("scene_triangles", triangles)
      .run(triangles.count());
}

}  // namespace lucarium
