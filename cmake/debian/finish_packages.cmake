# SPDX-License-Identifier: Apache-2.0
# Run by cpack when the files of all packages are laid out and none is packed. Adds to each Debian package what policy
# wants of it: copyright, changelog, and compressed manual pages. The archive stays as `cmake --install` makes it.
if(NOT CPACK_GENERATOR STREQUAL DEB)
  return()
endif()
find_program(GZIP gzip REQUIRED)

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  set(root ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr/share)
  string(TOUPPER ${component} upper)
  set(pages ${root}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  file(REMOVE ${pages}/LICENSE)  # a text that every Debian system holds
  configure_file(${CPACK_LUCARIUM_COPYRIGHT} ${pages}/copyright COPYONLY)
  configure_file(${CPACK_LUCARIUM_CHANGELOG} ${pages}/changelog COPYONLY)
  file(GLOB manual ${root}/man/man*/*)
  execute_process(COMMAND ${GZIP} -9nf ${pages}/changelog ${manual} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
