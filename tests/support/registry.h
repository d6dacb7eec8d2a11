// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "lucarium/technique/plugin.h"

namespace lucarium::test {

/// The techniques of this build.
inline const TechniqueRegistry& registry() {
  static const TechniqueRegistry all;
  return all;
}

}  // namespace lucarium::test
