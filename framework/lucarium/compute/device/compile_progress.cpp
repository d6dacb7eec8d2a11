// SPDX-License-Identifier: Apache-2.0
#include "lucarium/compute/device/compile_progress.h"

#include <fmt/format.h>

namespace lucarium {

void CompileProgress::listen(Listener listener) {
  listener_ = std::move(listener);
  launched_before_ = launched_.size();
}

void CompileProgress::build(const std::string& program) {
  if (listener_) listener_(-1, "compiling program " + program);
}

void CompileProgress::announce(const std::string& launch) { announced_.insert(launch); }

void CompileProgress::launching(const std::string& launch) {
  announced_.insert(launch);
  if (!launched_.insert(launch).second || !listener_) return;
  const size_t now = launched_.size() - launched_before_, all = announced_.size() - launched_before_;
  listener_(static_cast<double>(now - 1) / static_cast<double>(all), fmt::format("compiling kernels {}/{}", now, all));
}

}  // namespace lucarium
