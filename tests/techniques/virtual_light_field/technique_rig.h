// SPDX-License-Identifier: Apache-2.0
// The whole technique, by sessions of technique_session.h.
#pragma once
#include "technique_session.h"

namespace lucarium::test {

inline std::unique_ptr<RenderSession> session(Scene scene, int max_bounces, const Options& options,
                                              const std::string& technique = "virtual_light_field") {
  return session(technique, std::move(scene), max_bounces, options);
}

}  // namespace lucarium::test
