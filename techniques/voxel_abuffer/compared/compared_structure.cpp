// SPDX-License-Identifier: Apache-2.0
#include "voxel_abuffer/compared/compared_structure.h"

#include "lucarium/base/stopwatch.h"
#include "lucarium/compute/program/source_library.h"
#include "lucarium/services/ray_shares/ray_shares.h"

const lucarium::EmbeddedSources& voxel_abuffer_kernels();

namespace lucarium::abuffer {

ComparedStructure::ComparedStructure(KernelScheduler& scheduler, const SceneBuffers& buffers, Kind kind)
    : scheduler_(&scheduler), buffers_(&buffers), kind_(std::move(kind)), pairs_(scheduler, buffers, kind_.morton) {}

Bounds ComparedStructure::bounds() const {
  return {buffers_->info().bounds_min.xyz(), buffers_->info().bounds_max.xyz()};
}

void ComparedStructure::compile() {
  const bool alpha = (buffers_->info().flags & LUCARIUM_SCENE_HAS_ALPHA) != 0;
  if (program_ && alpha == alpha_) return;
  ProgramSpec spec{.name = "voxel_abuffer/compared/" + kind_.name,
                   .files = {"voxel_abuffer/compared/trace_" + kind_.name + ".cl"}};
  if (alpha) spec.defines["BVH_ALPHA"] = "";
  if (kind_.morton) spec.defines["COMPARED_MORTON"] = "";
  spec.mad_enable = false;  // the triangle test is watertight by rounding both products of an edge alike
  SourceLibrary library;
  library.add(voxel_abuffer_kernels());
  program_ = Program(scheduler_->device(), library, spec);
  alpha_ = alpha;
  ++generation_;
}

void ComparedStructure::rebuild() {
  const Stopwatch watch;
  compile();
  pairs_.build(layout(), kind_.pad, kind_.remedy);
  statistics_.pairs = pairs_.pairs();
  statistics_.occupied_voxels = pairs_.voxels();
  fill();
  statistics_.build_bytes = pairs_.bytes();
  statistics_.build_seconds = watch.seconds();
  ++statistics_.builds;
}

void ComparedStructure::update(const SceneChange& change) {
  compile();
  if (change.geometry()) rebuild();
}

void ComparedStructure::record(ScheduleRecorder& recorder, const std::string& pass_name, const char* kernel,
                               const RayBuffers& rays, const char* result_name, const BufferRef& result) const {
  PassBuilder pass = recorder.pass(pass_name, program_, kernel);
  trace_by_shares(pass, rays, scheduler_->device());
  pass.arg("rays", rays.rays).arg(result_name, result).arg("compared_grid", pairs_.grid());
  if (wants_ends()) pass.arg("ends", rays.ends);
  bind(pass);
  if (alpha_ || kind_.needs_scene) buffers_->bind(pass);
}

void ComparedStructure::record_closest(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                                       const BufferRef& hits) const {
  record(recorder, pass_name, "compared_closest", rays, "hits", hits);
}

void ComparedStructure::record_any(ScheduleRecorder& recorder, const std::string& pass_name, const RayBuffers& rays,
                                   const BufferRef& occluded) const {
  record(recorder, pass_name, "compared_any", rays, "occluded", occluded);
}

}  // namespace lucarium::abuffer
