// SPDX-License-Identifier: Apache-2.0
// The whole technique, by sessions of technique_session.h.
#pragma once
#include "technique_session.h"

namespace lucarium::test {

inline double indirect_mean(const std::string& technique, const char* scene, int max_bounces, uint64_t iterations,
                            const Options& options) {
  const auto run = session(technique, load_scene(scene), max_bounces, options);
  run->run({.iterations = iterations});
  return mean(indirect(*run));
}

/// Iterations exchange, all of them: tests count them.
inline const Options few_texels = {{"texels", "2048"}, {"batch", "1"}, {"stop_error", "0"}, {"eye_share", "0"}};

}  // namespace lucarium::test
