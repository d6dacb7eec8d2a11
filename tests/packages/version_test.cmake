# SPDX-License-Identifier: Apache-2.0
# cmake -DMODULE=…/LucariumVersion.cmake -P version_test.cmake
# What lucarium_find_version() says of a repository without a tag, at a tag, behind it, of an archive of it, of a clone,
# and of sources that lie in somebody else's repository.
cmake_minimum_required(VERSION 3.25)
execute_process(COMMAND mktemp -d -t lucarium-version-XXXXXX OUTPUT_VARIABLE folder OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
set(ENV{GIT_CONFIG_GLOBAL} /dev/null)
set(ENV{GIT_CONFIG_NOSYSTEM} 1)
unset(ENV{GIT_DIR})

function(git)
  execute_process(COMMAND git -C ${folder}/sources -c user.name=nobody -c user.email=nobody@example.org ${ARGN}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The numbers and the full version, a pattern, of the sources in a folder.
function(expect what sources numbers full)
  include(${sources}/cmake/LucariumVersion.cmake)
  lucarium_find_version(${sources})
  if(NOT LUCARIUM_VERSION_NUMBERS STREQUAL numbers OR NOT LUCARIUM_VERSION_FULL MATCHES "^${full}$")
    file(REMOVE_RECURSE ${folder})
    message(FATAL_ERROR "${what}: ${LUCARIUM_VERSION_NUMBERS} and ${LUCARIUM_VERSION_FULL}, not ${numbers} and ${full}")
  endif()
  message(STATUS "${what}: ${LUCARIUM_VERSION_FULL}")
endfunction()

# Debian's order of two versions.
function(expect_before first second)
  find_program(DPKG dpkg)
  if(DPKG)
    execute_process(COMMAND ${DPKG} --compare-versions ${first} lt ${second} COMMAND_ERROR_IS_FATAL ANY)
  endif()
endfunction()

cmake_path(GET MODULE PARENT_PATH modules)
file(COPY ${MODULE} ${modules}/archived_commit.txt DESTINATION ${folder}/sources/cmake)
expect("sources alone" ${folder}/sources 0.1.0 "0\\.1\\.0")
file(COPY ${modules}/../.gitattributes DESTINATION ${folder}/sources)
git(init --quiet)
git(add .)
git(commit --quiet -m first)
expect("no tag" ${folder}/sources 0.1.0 "0\\.1\\.0~1\\.g[0-9a-f]+")
git(tag -a v2.3.4 -m release)
git(tag nightly)
git(tag v9)
expect("at the tag" ${folder}/sources 2.3.4 "2\\.3\\.4")
git(archive --prefix=at_tag/ -o ${folder}/at_tag.tar HEAD)
git(commit --quiet --allow-empty -m second)
expect("behind the tag" ${folder}/sources 2.3.4 "2\\.3\\.4\\+1\\.g[0-9a-f]+")
git(archive --prefix=behind_tag/ -o ${folder}/behind_tag.tar HEAD)
git(clone --quiet ${folder}/sources ${folder}/clone)
expect("a clone" ${folder}/clone 2.3.4 "2\\.3\\.4\\+1\\.g[0-9a-f]+")

# Unpacked in another repository, whose tags are not theirs.
foreach(archive at_tag behind_tag)
  file(ARCHIVE_EXTRACT INPUT ${folder}/${archive}.tar DESTINATION ${folder}/clone)
endforeach()
expect("an archive of the tag" ${folder}/clone/at_tag 2.3.4 "2\\.3\\.4")
expect("an archive of what is behind it" ${folder}/clone/behind_tag 2.3.4 "2\\.3\\.4\\+1\\.g[0-9a-f]+")

expect_before(0.1.0~7.g1a2b3c4 0.1.0)
expect_before(0.1.0 0.1.0+1.g1a2b3c4)
expect_before(0.1.0+1.g1a2b3c4 0.1.1)
file(REMOVE_RECURSE ${folder})
