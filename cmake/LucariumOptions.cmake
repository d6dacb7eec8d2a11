# SPDX-License-Identifier: Apache-2.0
# Build options; everything here has a sensible default.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release or RelWithDebInfo" FORCE)
endif()

set(LUCARIUM_SANITIZE "" CACHE STRING "Comma-separated sanitizers, for instance address,undefined")
option(LUCARIUM_MUTATION_TESTS "Add the mutation tests (ctest -L mutation; docs/validation.md)" OFF)
option(LUCARIUM_FUZZ "Build the libFuzzer targets (needs clang++)" OFF)
option(LUCARIUM_WERROR "Treat warnings as errors" OFF)
option(LUCARIUM_CHECK_KERNELS "Syntax-check every OpenCL source with clang" ON)

# The work is in kernels: on the host -O3 makes code that takes longer to compile and hardly less to run.
string(REPLACE "-O3" "-O2" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")

# One interface target carries the flags of all of the project's own code.
add_library(lucarium_build_flags INTERFACE)
target_compile_options(lucarium_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wno-missing-field-initializers
  $<$<BOOL:${LUCARIUM_WERROR}>:-Werror>)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # Of sources that are compiled as one (LucariumUnity.cmake) these speak of what stands in another of them.
  target_compile_options(lucarium_build_flags INTERFACE
    $<$<BOOL:${CMAKE_UNITY_BUILD}>:-Wno-shadow;-Wno-subobject-linkage>)
  # A precompiled header of 100 MB makes GCC collect garbage again and again, a tenth of its time: only above 512 MB.
  target_compile_options(lucarium_build_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=524288>)
  if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 sees bytes beyond a std::string's inline buffer copied where a longer literal goes to the heap.
    target_compile_options(lucarium_build_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-array-bounds>)
  else()
    # A reference to something else than a temporary argument; a vector that GCC 14 takes for another one.
    target_compile_options(lucarium_build_flags INTERFACE
      $<$<COMPILE_LANGUAGE:CXX>:-Wno-dangling-reference;-Wno-free-nonheap-object>)
  endif()
endif()

if(LUCARIUM_SANITIZE)
  add_compile_options(-fsanitize=${LUCARIUM_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${LUCARIUM_SANITIZE})
endif()

# Faster builds where the tools happen to be there; never needed. With precompiled headers ccache hits only when it may
# ignore which macros they define (its manual, "Precompiled headers").
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
    add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>)
  endif()
endif()
