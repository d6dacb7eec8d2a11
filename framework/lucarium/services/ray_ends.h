// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <string>

#include "lucarium/services/intersector.h"

namespace lucarium {

/// Ends of rays (RayEnds) for intersectors that want them, nothing for others: a service declares its ends through
/// these functions, compiles its kernels with ray_end_defines() (kernels/lucarium/ray_ends.clh), binds ends with
/// PassBuilder::arg_if_present(), and hands them on in RayBuffers::ends.
///
///   const BufferRef ends = transient_ray_ends(recorder, intersector, "ends of shadow rays", count);
///   recorder.pass("aim", program, "aim").global(count).arg("rays", rays).arg_if_present("ends", ends);
///   intersector.record_any(recorder, "shadow rays", {rays, counter, 0, count, ends}, occluded);

/// Defines for programs whose kernels write ends of rays.
std::map<std::string, std::string> ray_end_defines(const Intersector& intersector);

/// The ends of `count` rays as a transient; empty where the intersector wants none.
BufferRef transient_ray_ends(ScheduleRecorder& recorder, const Intersector& intersector, const std::string& name,
                             size_t count, const std::string& remedy = "");

/// The same as memory that lives on.
TypedBuffer<RayEnds> make_ray_ends(Device& device, const Intersector& intersector, const std::string& owner,
                                   const std::string& name, size_t count, const std::string& remedy = "");

}  // namespace lucarium
