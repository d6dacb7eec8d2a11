# SPDX-License-Identifier: Apache-2.0
# OpenCL sources are embedded into the library or plug-in that owns them. Their names are their paths below a root
# (kernels, framework, techniques): "lucarium/bsdf.clh", "path_tracing/shade.cl". They are installed under
# share/lucarium/kernels by the same names. LUCARIUM_KERNEL_PATH=kernels:framework:techniques reads them from disk.

set(LUCARIUM_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_kernels.cmake)
# Where clang finds them: in this repository, or what is installed.
set(LUCARIUM_KERNEL_ROOTS ${LUCARIUM_INSTALLED_KERNELS})
if(NOT LUCARIUM_KERNEL_ROOTS)
  set(LUCARIUM_KERNEL_ROOTS ${CMAKE_SOURCE_DIR}/kernels ${CMAKE_SOURCE_DIR}/framework ${CMAKE_SOURCE_DIR}/techniques)
endif()
find_program(LUCARIUM_CLANG NAMES clang clang-14 clang-15 clang-16)

# A source file with the function `function` that gives the texts of the manifest's lines name|path, added to `target`.
function(lucarium_embed_manifest target function what manifest sources)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp)
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${function}.manifest CONTENT "${manifest}" @ONLY)
  add_custom_command(OUTPUT ${generated}
    COMMAND ${CMAKE_COMMAND} -DMANIFEST=${CMAKE_CURRENT_BINARY_DIR}/${function}.manifest
            -DOUTPUT=${generated} -DFUNCTION=${function} -P ${LUCARIUM_EMBED_SCRIPT}
    DEPENDS ${sources} ${CMAKE_CURRENT_BINARY_DIR}/${function}.manifest ${LUCARIUM_EMBED_SCRIPT}
    COMMENT "Embedding ${what} of ${target}" VERBATIM)
  target_sources(${target} PRIVATE ${generated})
endfunction()

# lucarium_embed_kernels(TARGET target FUNCTION name ROOTS prefix=dir... [INSTALL])
#
# Generates `const lucarium::EmbeddedSources& FUNCTION()` from every .cl and .clh file and every shared/*.h below dir,
# under the names prefix/…, and adds it to TARGET. The list is derived from the folders, never kept by hand. With
# INSTALL the files are installed too.
function(lucarium_embed_kernels)
  cmake_parse_arguments(A "INSTALL" "TARGET;FUNCTION" "ROOTS" ${ARGN})
  set(manifest "")
  set(sources "")
  foreach(root IN LISTS A_ROOTS)
    string(REGEX MATCH "^([^=]*)=(.*)$" _ "${root}")
    set(prefix ${CMAKE_MATCH_1})
    set(dir ${CMAKE_MATCH_2})
    file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${dir} ${dir}/*.cl ${dir}/*.clh ${dir}/shared/*.h)
    foreach(file IN LISTS files)
      cmake_path(IS_PREFIX CMAKE_BINARY_DIR ${dir}/${file} NORMALIZE built)
      if(built)
        continue()  # a build folder inside a plug-in's folder
      endif()
      set(virtual ${prefix}/${file})
      string(APPEND manifest "${virtual}|${dir}/${file}\n")
      list(APPEND sources ${dir}/${file})
      cmake_path(GET virtual PARENT_PATH parent)
      if(A_INSTALL)
        install(FILES ${dir}/${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/lucarium/kernels/${parent})
      endif()
      if(LUCARIUM_CHECK_KERNELS AND LUCARIUM_CLANG AND file MATCHES "\\.cl$")
        string(MAKE_C_IDENTIFIER "${virtual}" stem)
        set(stamp ${CMAKE_CURRENT_BINARY_DIR}/kernel_checks/${stem}.ok)
        cmake_path(GET dir PARENT_PATH own_root)  # of "NAME/file" in a plug-in's own folder NAME
        list(TRANSFORM LUCARIUM_KERNEL_ROOTS PREPEND -I OUTPUT_VARIABLE roots)
        list(APPEND roots -I${own_root})
        add_custom_command(OUTPUT ${stamp}
          COMMAND ${LUCARIUM_CLANG} -x cl -cl-std=CL1.2 -Xclang -finclude-default-header -fsyntax-only
                  -Wall -Wno-unused-function -Wno-unused-variable -Werror=implicit-function-declaration
                  -target spir64 ${roots} -MD -MF ${stamp}.d -MT ${stamp} ${dir}/${file}
          COMMAND ${CMAKE_COMMAND} -E touch ${stamp}
          DEPENDS ${dir}/${file} DEPFILE ${stamp}.d
          COMMENT "Checking ${virtual}" VERBATIM)
        list(APPEND stamps ${stamp})
      endif()
    endforeach()
  endforeach()
  lucarium_embed_manifest(${A_TARGET} ${A_FUNCTION} kernels "${manifest}" "${sources}")
  if(stamps)
    add_custom_target(${A_TARGET}_kernel_checks ALL DEPENDS ${stamps})
  endif()
endfunction()

# lucarium_embed_assets(TARGET target FUNCTION name BASE dir FILES file... [EXTERNAL name=path...])
# The same for other text files (the report's page, style and script), by their names relative to BASE or as given.
function(lucarium_embed_assets)
  cmake_parse_arguments(A "" "TARGET;FUNCTION;BASE" "FILES;EXTERNAL" ${ARGN})
  set(manifest "")
  set(sources "")
  foreach(file IN LISTS A_FILES)
    string(APPEND manifest "${file}|${A_BASE}/${file}\n")
    list(APPEND sources ${A_BASE}/${file})
  endforeach()
  foreach(entry IN LISTS A_EXTERNAL)
    string(REGEX MATCH "^([^=]*)=(.*)$" _ "${entry}")
    string(APPEND manifest "${CMAKE_MATCH_1}|${CMAKE_MATCH_2}\n")
    list(APPEND sources ${CMAKE_MATCH_2})
  endforeach()
  lucarium_embed_manifest(${A_TARGET} ${A_FUNCTION} assets "${manifest}" "${sources}")
endfunction()
