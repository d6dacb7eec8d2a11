// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <new>

#include "lucarium/base/error.h"
#include "lucarium/compute/device/device.h"
#include "lucarium/session/session.h"

namespace lucarium {

/// Calls into a technique: whatever it throws leaves as lucarium::Error with its name before the message.
template <class Call>
auto call_technique(const TechniqueInfo& info, Call&& call) {
  try {
    return call();
  } catch (const Error& error) {
    throw error.with_context(info.name);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw_error(ErrorClass::technique, "{}: {}", info.name, error.what());
  }
}

/// While it lives, reports to on_preparing which of the device's kernels is being compiled.
class ReportCompilation {
 public:
  ReportCompilation(Device& device, const RenderSession::OnPreparing& on_preparing) : device_(device) {
    on_preparing(-1, "kernels");
    device_.compile_progress().listen(on_preparing);
  }
  ~ReportCompilation() { device_.compile_progress().listen({}); }
  ReportCompilation(const ReportCompilation&) = delete;
  ReportCompilation& operator=(const ReportCompilation&) = delete;

 private:
  Device& device_;
};

}  // namespace lucarium
