// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

namespace lucarium {

/// Bytes that this process can still take without swapping or being killed: the kernel's MemAvailable, bounded by
/// what the memory control group leaves. SIZE_MAX where neither is known.
size_t available_host_memory();
/// Memory that was freed and is kept for what comes (apps/lucarium/program.cpp) becomes available again.
void give_back_freed_memory();

/// Zeroed pages that become real at first touch; null when the address space or the commit limit is exhausted.
void* map_host_memory(size_t bytes);
void unmap_host_memory(void* address, size_t bytes) noexcept;

}  // namespace lucarium
