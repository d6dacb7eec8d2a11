// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <set>
#include <string>

namespace lucarium {

/// How far the compilation of a device's kernels is. Drivers compile in two steps: programs when they are built, which
/// nobody can count beforehand, and launch code at a kernel's first launch with a work-group size (PoCL: 40-500 ms
/// each), which recorded schedules announce. From the thread that uses the device.
class CompileProgress {
 public:
  using Listener = std::function<void(double fraction, const std::string& text)>;
  /// Hears of compilation from now on, as "compiling program a/b" or "compiling kernels 3/12"; empty: no reports.
  void listen(Listener listener);

  void build(const std::string& program);  ///< is about to be compiled
  /// A launch that a schedule will make; `launch` names kernel and work-group size.
  void announce(const std::string& launch);
  void launching(const std::string& launch);  ///< for the first time, during a warm-up

 private:
  std::set<std::string> announced_, launched_;
  size_t launched_before_ = 0;
  Listener listener_;
};

}  // namespace lucarium
