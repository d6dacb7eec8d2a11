// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CL/cl.h>

#include <utility>

#include "lucarium/base/log.h"

namespace lucarium {

/// Owns one reference to an OpenCL object. The destructor reports a failing release and never throws.
template <class T, auto Release>
class ClHandle {
 public:
  ClHandle() = default;
  explicit ClHandle(T handle) : handle_(handle) {}
  ClHandle(ClHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  ClHandle& operator=(ClHandle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~ClHandle() {
    if (!handle_) return;
    if (const cl_int code = Release(handle_); code != CL_SUCCESS) {
      log_warning("releasing an OpenCL object failed with code {}", code);
    }
  }

  T get() const { return handle_; }
  explicit operator bool() const { return handle_ != nullptr; }
  /// Gives the reference away.
  T release() { return std::exchange(handle_, nullptr); }

 private:
  T handle_ = nullptr;
};

namespace detail {
inline cl_int release_mem(cl_mem object) { return clReleaseMemObject(object); }
inline cl_int release_kernel(cl_kernel object) { return clReleaseKernel(object); }
inline cl_int release_program(cl_program object) { return clReleaseProgram(object); }
inline cl_int release_event(cl_event object) { return clReleaseEvent(object); }
}  // namespace detail

using ClMem = ClHandle<cl_mem, detail::release_mem>;
using ClKernel = ClHandle<cl_kernel, detail::release_kernel>;
using ClProgram = ClHandle<cl_program, detail::release_program>;
using ClEvent = ClHandle<cl_event, detail::release_event>;

}  // namespace lucarium
