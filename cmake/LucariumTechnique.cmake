# SPDX-License-Identifier: Apache-2.0
# lucarium_add_technique(NAME SOURCES file...)
#
# Builds the plug-in `lucarium_NAME` (a shared library in lib/lucarium/techniques) from C++ SOURCES and every
# .cl/.clh file beside them, embedded under the virtual prefix NAME/. The plug-in's C++ gets the sources from
# `const lucarium::EmbeddedSources& NAME_kernels()`.
function(lucarium_add_technique NAME)
  cmake_parse_arguments(A "" "" "SOURCES" ${ARGN})
  add_library(lucarium_${NAME} MODULE ${A_SOURCES})
  lucarium_embed_kernels(TARGET lucarium_${NAME} FUNCTION ${NAME}_kernels
    ROOTS ${NAME}=${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(lucarium_${NAME} PRIVATE Lucarium::framework)
  if(TARGET lucarium_build_flags)
    target_link_libraries(lucarium_${NAME} PRIVATE $<BUILD_INTERFACE:lucarium_build_flags>)
  endif()
  set_target_properties(lucarium_${NAME} PROPERTIES
    PREFIX "" OUTPUT_NAME ${NAME}
    LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/lucarium/techniques)
  install(TARGETS lucarium_${NAME} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/lucarium/techniques)
endfunction()
