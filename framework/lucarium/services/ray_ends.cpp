// SPDX-License-Identifier: Apache-2.0
#include "lucarium/services/ray_ends.h"

namespace lucarium {

std::map<std::string, std::string> ray_end_defines(const Intersector& intersector) {
  if (!intersector.wants_ends()) return {};
  return {{"LUCARIUM_RAY_ENDS", ""}};
}

BufferRef transient_ray_ends(ScheduleRecorder& recorder, const Intersector& intersector, const std::string& name,
                             size_t count, const std::string& remedy) {
  return intersector.wants_ends() ? recorder.transient<RayEnds>(name, count, remedy) : BufferRef();
}

TypedBuffer<RayEnds> make_ray_ends(Device& device, const Intersector& intersector, const std::string& owner,
                                   const std::string& name, size_t count, const std::string& remedy) {
  if (!intersector.wants_ends()) return {};
  return TypedBuffer<RayEnds>(device, owner, name, count, remedy);
}

}  // namespace lucarium
