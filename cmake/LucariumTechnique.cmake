# SPDX-License-Identifier: Apache-2.0
# lucarium_add_technique(NAME SOURCES file...)
#
# Builds the plug-in `lucarium_NAME` (a shared library in lib/lucarium/techniques of the build folder) from C++ SOURCES
# and every .cl, .clh and shared/*.h file below the folder of the CMakeLists.txt, embedded as NAME/…. The plug-in's C++
# gets the sources from `const lucarium::EmbeddedSources& NAME_kernels()`. Files include each other by paths relative to
# themselves ("shared/x.h"), or, where the folder is called NAME, as "NAME/shared/x.h".
# The same call works inside this repository and, after find_package(Lucarium), outside of it.
function(lucarium_add_technique NAME)
  if(NOT NAME MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "lucarium_add_technique: '${NAME}' is not a name of a-z, 0-9 and _ that begins with a letter")
  endif()
  cmake_parse_arguments(A "" "" "SOURCES" ${ARGN})
  add_library(lucarium_${NAME} MODULE ${A_SOURCES})
  lucarium_embed_kernels(TARGET lucarium_${NAME} FUNCTION ${NAME}_kernels INSTALL
    ROOTS ${NAME}=${CMAKE_CURRENT_SOURCE_DIR})
  target_include_directories(lucarium_${NAME} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/..)
  target_link_libraries(lucarium_${NAME} PRIVATE Lucarium::framework)
  if(TARGET lucarium_build_flags)
    target_link_libraries(lucarium_${NAME} PRIVATE $<BUILD_INTERFACE:lucarium_build_flags>)
    target_precompile_headers(lucarium_${NAME} REUSE_FROM lucarium_technique_headers)
  endif()
  set_target_properties(lucarium_${NAME} PROPERTIES
    PREFIX "" OUTPUT_NAME ${NAME} CXX_EXTENSIONS OFF CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    INSTALL_RPATH "$ORIGIN/../.."
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/lucarium/techniques)
  lucarium_add_experiments()
  install(TARGETS lucarium_${NAME} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/lucarium/techniques)
endfunction()

# Puts the papers of the calling folder, experiments/PAPER/*.json, beside the plug-ins, where `lucarium reproduce` finds
# them. lucarium_add_technique() does so for those of the technique.
function(lucarium_add_experiments)
  set(technique_folder ${CMAKE_BINARY_DIR}/lib/lucarium/techniques)
  file(GLOB papers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/experiments/*/paper.json)
  foreach(paper IN LISTS papers)
    cmake_path(GET paper PARENT_PATH folder)
    cmake_path(GET folder FILENAME name)
    file(MAKE_DIRECTORY ${technique_folder}/experiments)
    file(CREATE_LINK ${folder} ${technique_folder}/experiments/${name} SYMBOLIC)
    install(DIRECTORY ${folder} DESTINATION ${CMAKE_INSTALL_LIBDIR}/lucarium/techniques/experiments)
  endforeach()
endfunction()
