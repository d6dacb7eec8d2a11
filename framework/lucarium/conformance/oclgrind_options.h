// SPDX-License-Identifier: Apache-2.0
// How kernels are built for Oclgrind; tests/oclgrind/CMakeLists.txt reads it, too.
#pragma once

/// It stops at LLVM intrinsics that it does not know: bit reversal and the like, which the optimizer recognizes; scopes
/// of `restrict`, which inlining leaves behind; those of compiler built-ins, which the layered raster has a variant
/// without.
#define LUCARIUM_OCLGRIND_OPTIONS "-cl-opt-disable -Dalways_inline=noinline -DLAYERED_PORTABLE"
