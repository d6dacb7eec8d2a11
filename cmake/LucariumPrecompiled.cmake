# SPDX-License-Identifier: Apache-2.0
# Precompiled headers: what most sources include and nobody here changes. Parsing it is half of compiling a usual source
# (1.2 of 2.5 s). One for each family of targets whose flags agree. Sources still include what they use:
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON, and the target header_checks, compile without.
#
# nlohmann/json.hpp is in those families only in which half of the sources use it: it makes every source of the family
# 0.35 s slower, because its literal operators are instantiated whether they are used or not.
set(LUCARIUM_PRECOMPILED <algorithm> <array> <chrono> <cmath> <cstdint> <cstring> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <numeric> <optional> <set> <span> <string> <string_view> <tuple> <utility> <vector>
  <CL/cl.h> <fmt/format.h> <glm/glm.hpp>)

# A target that others reuse the header of: lucarium_precompiled_family(name [EXECUTABLE] [LINK target...]
# [HEADERS header...]). EXECUTABLE for targets that are compiled as executables (-fPIE), else as libraries (-fPIC).
function(lucarium_precompiled_family name)
  cmake_parse_arguments(A "EXECUTABLE" "" "LINK;HEADERS" ${ARGN})
  # Without a main: an executable takes that of what it links.
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "namespace {}\n")
  if(A_EXECUTABLE)
    add_executable(${name} ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  else()
    add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  endif()
  target_link_libraries(${name} PRIVATE Lucarium::framework lucarium_build_flags ${A_LINK})
  target_precompile_headers(${name} PRIVATE ${LUCARIUM_PRECOMPILED} ${A_HEADERS})
endfunction()
