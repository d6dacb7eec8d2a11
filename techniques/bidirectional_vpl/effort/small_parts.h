// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <utility>
#include <vector>

#include "bidirectional_vpl/iteration/parts.h"

namespace lucarium::bidirectional {

/// Parts of an image of their own.
class SmallParts {
 public:
  SmallParts(const PartsContext& context, const Plan& plan, const Frame& frame)
      : sums_(context.device, plan, context.owner), parts_(context, plan, frame, sums_) {}
  Parts& parts() { return parts_; }

 private:
  EyeSums sums_;
  Parts parts_;
};

/// Parts of the efforts that every trial needs, from one beginning of an image to the next.
class KeptParts {
 public:
  /// Those of `effort`, or null.
  std::shared_ptr<SmallParts> find(const Effort& effort) const {
    for (const auto& [kept, parts] : parts_)
      if (kept == effort) return parts;
    return nullptr;
  }
  void keep(const Effort& effort, std::shared_ptr<SmallParts> parts) { parts_.emplace_back(effort, std::move(parts)); }
  void clear() { parts_.clear(); }

 private:
  std::vector<std::pair<Effort, std::shared_ptr<SmallParts>>> parts_;
};

}  // namespace lucarium::bidirectional
