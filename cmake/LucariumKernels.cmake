# SPDX-License-Identifier: Apache-2.0
# OpenCL sources are embedded into the library or plug-in that owns them, under virtual names by which
# they include each other ("lucarium/bsdf.clh", "path_tracing/shade.cl"), and are installed under
# share/lucarium/kernels by the same names.

# The virtual names as a folder of links: what clang checks against, and a root for LUCARIUM_KERNEL_PATH.
set(LUCARIUM_KERNEL_TREE ${CMAKE_BINARY_DIR}/kernel_tree)
set(LUCARIUM_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_kernels.cmake)
set_property(GLOBAL PROPERTY LUCARIUM_KERNEL_ROOTS ${LUCARIUM_KERNEL_TREE} ${LUCARIUM_INSTALLED_KERNELS})
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
# Generates `const lucarium::EmbeddedSources& FUNCTION()` from every dir/*.cl, dir/*.clh and dir/shared/*.h, under the
# virtual names prefix/…, and adds it to TARGET. The list is derived from the folders, never kept by hand. With INSTALL
# the files are installed too.
function(lucarium_embed_kernels)
  cmake_parse_arguments(A "INSTALL" "TARGET;FUNCTION" "ROOTS" ${ARGN})
  set(manifest "")
  set(sources "")
  foreach(root IN LISTS A_ROOTS)
    string(REGEX MATCH "^([^=]*)=(.*)$" _ "${root}")
    set(prefix ${CMAKE_MATCH_1})
    set(dir ${CMAKE_MATCH_2})
    file(GLOB files CONFIGURE_DEPENDS RELATIVE ${dir} ${dir}/*.cl ${dir}/*.clh ${dir}/shared/*.h)
    foreach(file IN LISTS files)
      set(virtual ${prefix}/${file})
      string(APPEND manifest "${virtual}|${dir}/${file}\n")
      list(APPEND sources ${dir}/${file})
      cmake_path(GET virtual PARENT_PATH parent)
      file(MAKE_DIRECTORY ${LUCARIUM_KERNEL_TREE}/${parent})
      file(CREATE_LINK ${dir}/${file} ${LUCARIUM_KERNEL_TREE}/${virtual} SYMBOLIC)
      if(A_INSTALL)
        install(FILES ${dir}/${file} DESTINATION ${CMAKE_INSTALL_DATADIR}/lucarium/kernels/${parent})
      endif()
      if(LUCARIUM_CHECK_KERNELS AND LUCARIUM_CLANG AND file MATCHES "\\.cl$")
        string(MAKE_C_IDENTIFIER "${virtual}" stem)
        set(stamp ${CMAKE_CURRENT_BINARY_DIR}/kernel_checks/${stem}.ok)
        get_property(roots GLOBAL PROPERTY LUCARIUM_KERNEL_ROOTS)
        list(TRANSFORM roots PREPEND -I)
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
