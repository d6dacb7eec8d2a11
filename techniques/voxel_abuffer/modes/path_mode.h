// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/services/path_integrator/path_integrator.h"
#include "voxel_abuffer/modes/mode.h"

namespace lucarium::abuffer {

/// Path tracing by the framework's integrator (Hu et al. 2014, section 4): layers `emission`, `direct`, `indirect`.
class PathMode : public Mode {
 public:
  PathMode(const ModeContext& context, const PathSet& path_set, uint32_t samples);
  bool pass() override { return integrator_.iterate(); }
  void restart(const Frame& frame, uint64_t seed) override;
  void follow_scene() override { integrator_.follow_scene(); }
  void write(Film& film) override { integrator_.resolve(film); }
  void warm_up() override { integrator_.warm_up(); }
  std::map<std::string, double> counters() const override { return integrator_.counters(); }
  static size_t estimate_bytes(uint32_t width, uint32_t height, uint32_t samples, bool ray_ends);

 private:
  PathIntegrator integrator_;
};

}  // namespace lucarium::abuffer
