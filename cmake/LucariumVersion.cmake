# SPDX-License-Identifier: Apache-2.0
# The version, from the newest git tag vMAJOR.MINOR.PATCH behind what is checked out. Nothing else states it.
#
# lucarium_find_version(SOURCE) sets
#   LUCARIUM_VERSION_NUMBERS  MAJOR.MINOR.PATCH of that tag, or of the first release where there is none
#   LUCARIUM_VERSION_FULL     which commit it is, in Debian's order: 0.2.0 is the tag, 0.2.0+7.g1a2b3c4 seven commits
#                             behind it, 0.1.0~7.g1a2b3c4 the seventh commit, without any tag
# An archive that git made has no history; git wrote the same into archived_commit.txt (.gitattributes). Of sources
# without either only the numbers are known.
set(LUCARIUM_FIRST_RELEASE 0.1.0)
set(LUCARIUM_ARCHIVED_COMMIT ${CMAKE_CURRENT_LIST_DIR}/archived_commit.txt)

# Standard output of git, without the end of its line; empty where it fails.
function(lucarium_ask_git source result)
  execute_process(COMMAND git -C ${source} ${ARGN} RESULT_VARIABLE failed OUTPUT_VARIABLE answer ERROR_QUIET
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    set(answer "")
  endif()
  set(${result} "${answer}" PARENT_SCOPE)
endfunction()

function(lucarium_find_version source)
  set(described "")
  set(commit "")
  set(count "")
  if(EXISTS ${source}/.git)  # not a repository around these sources
    lucarium_ask_git(${source} described describe --tags --match "v[0-9]*.[0-9]*.[0-9]*")
    lucarium_ask_git(${source} commit rev-parse --short HEAD)
    lucarium_ask_git(${source} count rev-list --count HEAD)
  else()
    file(READ ${LUCARIUM_ARCHIVED_COMMIT} archived)
    if(archived MATCHES "^commit ([0-9a-f]+) *([^\n]*)")
      set(commit ${CMAKE_MATCH_1})
      set(described ${CMAKE_MATCH_2})
      set(count 0)
    endif()
  endif()

  set(numbers ${LUCARIUM_FIRST_RELEASE})
  set(full ${numbers})
  if(described MATCHES "^v([0-9]+\\.[0-9]+\\.[0-9]+)(-([0-9]+)-(g[0-9a-f]+))?$")
    set(numbers ${CMAKE_MATCH_1})
    set(full ${numbers})
    if(CMAKE_MATCH_2)
      set(full ${numbers}+${CMAKE_MATCH_3}.${CMAKE_MATCH_4})
    endif()
  elseif(commit)
    set(full ${numbers}~${count}.g${commit})
  endif()
  set(LUCARIUM_VERSION_NUMBERS ${numbers} PARENT_SCOPE)
  set(LUCARIUM_VERSION_FULL ${full} PARENT_SCOPE)
endfunction()
