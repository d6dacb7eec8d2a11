# SPDX-License-Identifier: Apache-2.0
# The installed SDK: include/lucarium, lib/liblucarium.so, share/lucarium/kernels and the CMake package in
# lib/cmake/Lucarium. Kernels and techniques are installed where they are declared, without a component's name: what is
# not only for building against the library belongs to the component lucarium.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Lucarium)

install(TARGETS lucarium EXPORT LucariumTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  NAMELINK_COMPONENT dev)
install(EXPORT LucariumTargets NAMESPACE Lucarium:: DESTINATION ${package_folder} COMPONENT dev)

# Headers that need a library which the framework keeps to itself, directly or through another header, are no part of
# the interface.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} lucarium/*.h)
set(private_include "<(nlohmann|OpenImageIO|tiny_gltf|spdlog|xxhash)")
set(left_out -1)
while(NOT left_out EQUAL 0)
  set(left_out 0)
  foreach(header IN LISTS headers)
    file(STRINGS ${CMAKE_CURRENT_SOURCE_DIR}/${header} found REGEX "^#include *(${private_include})")
    if(found)
      list(REMOVE_ITEM headers ${header})
      string(APPEND private_include "|\"${header}\"")
      math(EXPR left_out "${left_out} + 1")
    endif()
  endforeach()
endwhile()
foreach(header IN LISTS headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT dev)
endforeach()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/kernels/lucarium/shared/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lucarium/shared
  COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(FILES ${LUCARIUM_GENERATED_ROOT}/lucarium/version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/lucarium
  COMPONENT dev)
# Pages lie as in the repository, so that they find each other.
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lucarium)
install(FILES ${CMAKE_SOURCE_DIR}/README.md ${CMAKE_SOURCE_DIR}/CHANGELOG.md ${CMAKE_SOURCE_DIR}/CONTRIBUTING.md
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lucarium-doc COMPONENT doc)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lucarium-doc COMPONENT doc
  PATTERN __pycache__ EXCLUDE)

string(REGEX MATCH "^[0-9]+" compiler_major ${CMAKE_CXX_COMPILER_VERSION})
set(kernel_folder ${CMAKE_INSTALL_DATADIR}/lucarium/kernels)
set(program ${CMAKE_INSTALL_BINDIR}/lucarium)
configure_package_config_file(${CMAKE_SOURCE_DIR}/cmake/LucariumConfig.cmake.in
  ${CMAKE_BINARY_DIR}/package/LucariumConfig.cmake
  INSTALL_DESTINATION ${package_folder} PATH_VARS kernel_folder program)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/LucariumConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/package/LucariumConfig.cmake ${CMAKE_BINARY_DIR}/package/LucariumConfigVersion.cmake
  ${CMAKE_SOURCE_DIR}/cmake/LucariumKernels.cmake ${CMAKE_SOURCE_DIR}/cmake/LucariumTechnique.cmake
  ${CMAKE_SOURCE_DIR}/cmake/embed_kernels.cmake DESTINATION ${package_folder} COMPONENT dev)
