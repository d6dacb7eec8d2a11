# SPDX-License-Identifier: Apache-2.0
# cmake -DBUILD=… [-DPROJECT=…] [-DTECHNIQUE=…] -DGENERATOR=… -DCOMPILER=… -DBUILD_TYPE=… -P build_outside.cmake
# Installs BUILD, moves what was installed to another folder, copies PROJECT (or has the installed program write a new
# technique), builds and tests the copy, and renders with TECHNIQUE; all in a fresh temporary folder. Of a new technique
# it runs the very commands that new-technique prints.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND mktemp -d -t lucarium-sdk-XXXXXX OUTPUT_VARIABLE folder OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)

# Runs a command in `folder`; a failure shows its output, removes the folder and fails the test.
function(run what)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${folder} RESULT_VARIABLE result OUTPUT_VARIABLE output
    ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    file(REMOVE_RECURSE ${folder})
    message(FATAL_ERROR "${what} failed (${result})\n${output}")
  endif()
  string(REGEX MATCH "CMake Warning[^\n]*\n[^\n]*\n[^\n]*" warning "${output}")
  if(warning)
    file(REMOVE_RECURSE ${folder})
    message(FATAL_ERROR "${what} warns\n${output}")
  endif()
  message(STATUS "${what}: done")
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(program ${folder}/prefix/bin/lucarium)
unset(ENV{LUCARIUM_TECHNIQUE_PATH})
unset(ENV{LUCARIUM_KERNEL_PATH})
run("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${folder}/first_place)
file(RENAME ${folder}/first_place ${folder}/prefix)
foreach(file man/man1/lucarium.1 man/man1/lucarium-render.1 bash-completion/completions/lucarium
    zsh/site-functions/_lucarium fish/vendor_completions.d/lucarium.fish)
  if(NOT EXISTS ${folder}/prefix/share/${file})
    file(REMOVE_RECURSE ${folder})
    message(FATAL_ERROR "share/${file} is not installed")
  endif()
endforeach()
if(PROJECT)
  file(COPY ${PROJECT}/ DESTINATION ${folder}/project)
  run("configure" ${CMAKE_COMMAND} -S project -B project/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${folder}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${BUILD_TYPE})
  run("build" ${CMAKE_COMMAND} --build project/build --parallel 2)
else()
  run("new-technique" ${program} new-technique ${TECHNIQUE} --output project)
  set(ENV{CXX} ${COMPILER})
  set(ENV{CMAKE_BUILD_TYPE} ${BUILD_TYPE})
  set(ENV{PATH} ${folder}/prefix/bin:$ENV{PATH})
  string(REGEX MATCHALL "\n  [^\n]+" steps "${output}")
  list(LENGTH steps count)
  if(NOT count EQUAL 4)
    message(FATAL_ERROR "new-technique prints ${count} commands, not configure, build, test and render\n${output}")
  endif()
  foreach(step IN LISTS steps)
    string(STRIP "${step}" step)
    run("'${step}'" sh -c "${step}")
  endforeach()
endif()

if(TECHNIQUE)
  if(PROJECT)
    run("test" ${CMAKE_CTEST_COMMAND} --test-dir project/build --output-on-failure)
    if(NOT output MATCHES "conformance [.]+ +Passed")
      file(REMOVE_RECURSE ${folder})
      message(FATAL_ERROR "the tests of the example do not run lucarium check\n${output}")
    endif()
    string(REGEX REPLACE ".*(conformance [^\n]*).*" "\\1" output "${output}")
    message(STATUS "${output}")
  endif()
  run("render" ${program} render builtin:cornell -t ${TECHNIQUE} --technique-path project/build/lib/lucarium/techniques
    --size 32x24 --spp 2 -o picture.png)
  run("install plug-in" ${CMAKE_COMMAND} --install project/build --prefix ${folder}/prefix)
  run("render with the installed plug-in" ${program} render builtin:cornell -t ${TECHNIQUE} --size 32x24 --spp 2
    -o installed.png)
  file(SHA256 ${folder}/picture.png first)
  file(SHA256 ${folder}/installed.png second)
  if(NOT first STREQUAL second)
    message(FATAL_ERROR "the installed plug-in gives another picture; see ${folder}")
  endif()
endif()
run("render with a technique of the installation" ${program} render builtin:cornell -t path_tracing --size 32x24 --spp 1
  -o own.png)
file(REMOVE_RECURSE ${folder})
