# SPDX-License-Identifier: Apache-2.0
# Unity builds (-DCMAKE_UNITY_BUILD=ON, what the presets release and asan set): the sources of a folder are compiled as
# one, so that what they include is read, and its templates are made, once per folder. A whole build takes half as long
# or less, a change of one source longer: the preset dev has none of it. So what stands in unnamed namespaces is unique
# within a folder. Sources still include what they use: clang-tidy and the preset dev compile each alone.

# Of `target`, whose sources are `ARGN` (absolute names); others that it has, generated ones, are compiled alone.
function(lucarium_unity_by_folder target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    cmake_path(GET source PARENT_PATH folder)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE group)
    string(MAKE_C_IDENTIFIER ${group} group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
endfunction()
