// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lucarium {

/// Makes SIGINT and SIGTERM set a flag instead of ending the process; a second SIGINT ends it at once.
/// The handler does nothing else: OpenCL work in flight cannot be stopped, so loops ask between passes.
void install_interrupt_handler();

/// Whether the user asked to stop. Long loops keep what they have and return.
bool interrupt_requested();

/// Sets or clears the flag by hand (tests, embedding programs).
void set_interrupt_requested(bool requested);

}  // namespace lucarium
