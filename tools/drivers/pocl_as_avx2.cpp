// SPDX-License-Identifier: Apache-2.0
// A library to preload (tools/drivers/pocl-avx2.sh): PoCL compiles kernels for a processor that has AVX2 and no
// AVX-512, because that is what this one's answers say.
#include <dlfcn.h>
#include <llvm/ADT/StringMap.h>
#include <llvm/Config/llvm-config.h>
#include <llvm/Support/Host.h>

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

namespace llvm::sys {

bool getHostCPUFeatures(StringMap<bool>& features) {
  using Function = bool (*)(StringMap<bool>&);
  // PoCL keeps its LLVM to itself: it is found by name, not as the next library.
  static void* const llvm = dlopen("libLLVM-" TEXT(LLVM_VERSION_MAJOR) ".so.1", RTLD_LAZY);
  static const auto real = reinterpret_cast<Function>(
      dlsym(llvm, "_ZN4llvm3sys18getHostCPUFeaturesERNS_9StringMapIbNS_15MallocAllocatorEEE"));
  const bool known = real(features);
  for (auto& feature : features)
    if (feature.first().startswith("avx512")) feature.second = false;
  return known;
}

StringRef getHostCPUName() { return "haswell"; }

}  // namespace llvm::sys
