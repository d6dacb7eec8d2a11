# SPDX-License-Identifier: Apache-2.0
# The target header_checks compiles every header alone, without precompiled headers, so that each includes what it uses.
# Nothing builds it by default: cmake --build --preset release --target header_checks, or ctest -R headers/.
add_library(header_checks OBJECT EXCLUDE_FROM_ALL)
foreach(folder framework kernels techniques apps tests/support)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/${folder}/*.h)
  foreach(header IN LISTS headers)
    if(header MATCHES "/templates/")
      continue()  # of a technique that `lucarium new-technique` writes
    endif()
    set(source ${CMAKE_BINARY_DIR}/header_checks/${header}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include \"${CMAKE_SOURCE_DIR}/${header}\"\n" @ONLY)
    target_sources(header_checks PRIVATE ${source})
  endforeach()
endforeach()
set_target_properties(header_checks PROPERTIES DISABLE_PRECOMPILE_HEADERS ON UNITY_BUILD OFF)
target_compile_options(header_checks PRIVATE -O0)
target_include_directories(header_checks PRIVATE ${CMAKE_SOURCE_DIR}/techniques ${CMAKE_SOURCE_DIR}/apps/lucarium
  ${CMAKE_SOURCE_DIR}/tests/support ${XXHASH_INCLUDE_DIR})
target_link_libraries(header_checks PRIVATE Lucarium::framework lucarium_build_flags spdlog::spdlog
  OpenImageIO::OpenImageIO TinyGLTF::TinyGLTF nlohmann_json::nlohmann_json doctest::doctest)
add_test(NAME headers/compile_alone
  COMMAND ${CMAKE_COMMAND} --build ${CMAKE_BINARY_DIR} --target header_checks)
set_tests_properties(headers/compile_alone PROPERTIES LABELS full TIMEOUT 3600)
