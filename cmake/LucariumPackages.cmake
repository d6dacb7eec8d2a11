# SPDX-License-Identifier: Apache-2.0
# `cpack` in the build folder makes the Debian packages lucarium, liblucarium-dev and lucarium-doc, and one archive that
# can be unpacked anywhere (docs/installing.md). What only Debian wants of a package is in cmake/debian.
set(LUCARIUM_MAINTAINER "Lucarium maintainers <maintainers@lucarium.invalid>" CACHE STRING
  "Who answers for the Debian packages: Name <address>")
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)
set(CPACK_GENERATOR TGZ)
if(DPKG_SHLIBDEPS)
  list(APPEND CPACK_GENERATOR DEB)
endif()

set(CPACK_PACKAGE_NAME lucarium)
set(CPACK_PACKAGE_VERSION ${LUCARIUM_VERSION_FULL})
set(CPACK_PACKAGE_CONTACT ${LUCARIUM_MAINTAINER})
set(CPACK_PACKAGE_FILE_NAME lucarium-${LUCARIUM_VERSION_FULL}-${CMAKE_SYSTEM_NAME}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGE_CHECKSUM SHA256)
set(CPACK_RESOURCE_FILE_LICENSE ${CMAKE_SOURCE_DIR}/LICENSE)
set(CPACK_COMPONENTS_ALL lucarium dev doc)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_VERBATIM_VARIABLES ON)

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # would stand before each package's own
set(CPACK_DEB_COMPONENT_INSTALL ON)  # a package each; the archive holds them all
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/cmake/debian/finish_packages.cmake)
set(CPACK_LUCARIUM_CHANGELOG ${CMAKE_BINARY_DIR}/package/changelog)
set(CPACK_LUCARIUM_COPYRIGHT ${CMAKE_SOURCE_DIR}/cmake/debian/copyright)
# The moment of the commit, so that the same commit gives the same file.
lucarium_ask_git(${CMAKE_SOURCE_DIR} LUCARIUM_COMMIT_DATE log -1 --format=%aD)
if(NOT LUCARIUM_COMMIT_DATE)
  string(TIMESTAMP LUCARIUM_COMMIT_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
endif()
configure_file(${CMAKE_SOURCE_DIR}/cmake/debian/changelog.in ${CPACK_LUCARIUM_CHANGELOG})

# lucarium_debian_package(COMPONENT component NAME name SECTION section SUMMARY line TEXT line...
#   [DEPENDS packages] [RECOMMENDS packages] [SUGGESTS packages])
macro(lucarium_debian_package)
  cmake_parse_arguments(A "" "COMPONENT;NAME;SECTION;SUMMARY" "TEXT;DEPENDS;RECOMMENDS;SUGGESTS" ${ARGN})
  string(TOUPPER ${A_COMPONENT} component)
  set(CPACK_DEBIAN_${component}_PACKAGE_NAME ${A_NAME})
  set(CPACK_DEBIAN_${component}_PACKAGE_SECTION ${A_SECTION})
  list(JOIN A_TEXT "\n" text)
  set(CPACK_COMPONENT_${component}_DESCRIPTION "${A_SUMMARY}\n${text}")
  foreach(relation DEPENDS RECOMMENDS SUGGESTS)
    list(JOIN A_${relation} ", " packages)
    set(CPACK_DEBIAN_${component}_PACKAGE_${relation} "${packages}")
  endforeach()
endmacro()

lucarium_debian_package(COMPONENT lucarium NAME lucarium SECTION graphics
  SUMMARY "compares global illumination techniques on OpenCL devices"
  TEXT "Lucarium renders a glTF scene with several global illumination techniques,"
       "measures each against a path traced reference, and writes a report of error"
       "over time. Techniques are plug-ins. It runs on any OpenCL 1.2 device, for"
       "instance on the processor with PoCL."
  RECOMMENDS "pocl-opencl-icd | opencl-icd"
  SUGGESTS liblucarium-dev lucarium-doc oclgrind)
set(CPACK_DEBIAN_LUCARIUM_PACKAGE_SHLIBDEPS ON)
# Who links the library needs this package.
configure_file(${CMAKE_SOURCE_DIR}/cmake/debian/shlibs.in ${CMAKE_BINARY_DIR}/package/shlibs)
set(CPACK_DEBIAN_LUCARIUM_PACKAGE_CONTROL_EXTRA
  ${CMAKE_SOURCE_DIR}/cmake/debian/triggers ${CMAKE_BINARY_DIR}/package/shlibs)

lucarium_debian_package(COMPONENT dev NAME liblucarium-dev SECTION libdevel
  SUMMARY "headers and CMake package for techniques of Lucarium"
  TEXT "What plug-ins of Lucarium are built against: headers, the link to the library,"
       "and a CMake package with lucarium_add_technique(). The command"
       "'lucarium new-technique' writes a project to begin with."
  DEPENDS "lucarium (= ${LUCARIUM_VERSION_FULL})" libglm-dev libfmt-dev opencl-headers ocl-icd-opencl-dev
  RECOMMENDS g++ cmake ninja-build clang
  SUGGESTS lucarium-doc)

lucarium_debian_package(COMPONENT doc NAME lucarium-doc SECTION doc
  SUMMARY "pages about Lucarium"
  TEXT "How to render, compare, read reports and results, and write techniques, with"
       "what each technique does and what was measured."
  SUGGESTS lucarium)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)

include(CPack)
