# SPDX-License-Identifier: Apache-2.0
# Every external package. All come from Debian 12: tools/packages.txt is the list.
find_package(Threads REQUIRED)
find_package(OpenCL REQUIRED)
find_package(glm REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(TinyGLTF REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(spdlog REQUIRED)
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)
find_package(ZLIB REQUIRED)
find_package(muparser REQUIRED)
# The server of `lucarium view`; without it the library has none, and that command says so.
option(LUCARIUM_VIEW "Build the viewer in a browser (lucarium view)" ON)
set(LUCARIUM_HAS_VIEW OFF)
if(LUCARIUM_VIEW)
  find_path(LIBWEBSOCKETS_INCLUDE_DIR libwebsockets.h)
  find_library(LIBWEBSOCKETS_LIBRARY websockets)
  if(LIBWEBSOCKETS_INCLUDE_DIR AND LIBWEBSOCKETS_LIBRARY)
    set(LUCARIUM_HAS_VIEW ON)
  else()
    message(STATUS "libwebsockets not found: lucarium view is left out; install the package libwebsockets-dev for it")
  endif()
endif()
# Plots in reports; a JavaScript file that is copied into every page.
find_file(LUCARIUM_CHART_JS chart.min.js PATHS /usr/share/javascript/chart.js /usr/local/share/javascript/chart.js
  NO_DEFAULT_PATH)
if(NOT LUCARIUM_CHART_JS)
  message(FATAL_ERROR "Chart.js 3 not found: install the package libjs-chart.js, "
    "or give its file with -DLUCARIUM_CHART_JS=/path/to/chart.min.js")
endif()

# Debian's OpenImageIO target names an OpenCV folder that exists only with OpenCV's own -dev package, and CMake refuses
# include folders that do not exist. Nothing here includes imagebufalgo_opencv.h, so drop what is not there.
foreach(target OpenImageIO::OpenImageIO OpenImageIO::OpenImageIO_Util)
  if(TARGET ${target})
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    set(existing "")
    foreach(folder IN LISTS folders)
      if(EXISTS ${folder})
        list(APPEND existing ${folder})
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${existing}")
  endif()
endforeach()
