# SPDX-License-Identifier: Apache-2.0
# Required and optional libraries; tools/setup installs all of them on Debian.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
set(malha_openmp "")
if(MALHA_OPENMP)
  find_package(OpenMP REQUIRED COMPONENTS CXX)
  set(malha_openmp OpenMP::OpenMP_CXX)
else()
  add_compile_options(-fopenmp-simd)  # its directive for loops of one thread, which needs no library
  if(MALHA_TESTS)
    message(FATAL_ERROR "MALHA_TESTS: found ON with MALHA_OPENMP=OFF; allowed: OFF, because tests use OpenMP's threads")
  endif()
endif()
find_package(nlohmann_json 3.10 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(Threads REQUIRED)
find_library(METIS_LIBRARY metis REQUIRED)
find_package(Bullet QUIET)  # peer of the benchmarks; malha itself does not use it
if(NOT BULLET_FOUND)
  message(STATUS "Bullet: not found; the benchmarks run without their peer (Debian: libbullet-dev)")
endif()

# OpenBLAS's header and library must be of the same variant: Debian has several, and a generic cblas.h.
find_path(OPENBLAS_INCLUDE_DIR openblas_config.h PATH_SUFFIXES openblas-pthread openblas)
find_library(OPENBLAS_LIBRARY openblas PATH_SUFFIXES openblas-pthread)
if(OPENBLAS_INCLUDE_DIR AND OPENBLAS_LIBRARY)
  set(OPENBLAS_FOUND TRUE)  # peer of malha bench filter
else()
  set(OPENBLAS_FOUND FALSE)
  message(STATUS "OpenBLAS: not found; malha bench filter runs without its peer (Debian: libopenblas-dev)")
endif()

# The window needs all of these libraries; without them the command names those that are missing.
find_package(glfw3 3.3 QUIET)
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)  # contains the font code of Debian's Dear ImGui
find_path(EPOXY_INCLUDE_DIR epoxy/gl.h)
find_library(EPOXY_LIBRARY epoxy)
if(MALHA_SANITIZE)
  set(WINDOW_FOUND FALSE)
  message(STATUS "malha view is left out: graphics drivers leak")
elseif(glfw3_FOUND AND IMGUI_INCLUDE_DIR AND IMGUI_LIBRARY AND STB_LIBRARY AND EPOXY_INCLUDE_DIR AND EPOXY_LIBRARY)
  set(WINDOW_FOUND TRUE)
else()
  set(WINDOW_FOUND FALSE)
  message(STATUS "malha view is left out: it needs GLFW, Dear ImGui and epoxy "
                 "(Debian: libglfw3-dev libimgui-dev libepoxy-dev)")
endif()

# The Python module, preferably for the system's Python, for which pybind11 and numpy are installed.
set(MALHA_PYTHON AUTO CACHE STRING "The Python module: ON, OFF, or AUTO: where Python's headers and pybind11 are")
set(PYTHON_FOUND FALSE)
if(NOT MALHA_PYTHON MATCHES "^(AUTO|ON|OFF|TRUE|FALSE|1|0)$")
  message(FATAL_ERROR "MALHA_PYTHON: found \"${MALHA_PYTHON}\"; allowed: ON, OFF or AUTO")
endif()
if(MALHA_PYTHON STREQUAL "AUTO" AND MALHA_SANITIZE)
  message(STATUS "The Python module is left out: Python itself is built without sanitizers")
elseif(MALHA_PYTHON)
  if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
    set(Python3_EXECUTABLE /usr/bin/python3)
  endif()
  find_package(Python3 3.9 QUIET COMPONENTS Interpreter Development.Module)
  find_path(PYBIND11_INCLUDE_DIR pybind11/pybind11.h)
  set(python_needs "it needs Python's headers and pybind11 (Debian: python3-dev pybind11-dev; tools/setup python)")
  if(Python3_Development.Module_FOUND AND PYBIND11_INCLUDE_DIR)
    set(PYTHON_FOUND TRUE)
  elseif(MALHA_PYTHON STREQUAL "AUTO")
    message(STATUS "The Python module is left out: ${python_needs}")
  else()
    message(FATAL_ERROR "MALHA_PYTHON: found \"${MALHA_PYTHON}\", but ${python_needs}; allowed: OFF or AUTO without them")
  endif()
  if(PYTHON_FOUND AND MALHA_SANITIZE)
    message(FATAL_ERROR "MALHA_PYTHON: found \"${MALHA_PYTHON}\" with MALHA_SANITIZE; allowed: OFF or AUTO, because Python "
                        "itself is built without sanitizers")
  endif()
endif()

# Embree 4, or else 3 (Debian 12). Both name their target "embree".
find_package(embree 4 CONFIG QUIET)
if(NOT embree_FOUND)
  find_package(embree 3 CONFIG REQUIRED)
endif()

# glTF is optional; all other formats are always available.
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h)
find_library(TINYGLTF_LIBRARY tinygltf)
if(TINYGLTF_INCLUDE_DIR AND TINYGLTF_LIBRARY)
  set(TINYGLTF_FOUND TRUE)
else()
  set(TINYGLTF_FOUND FALSE)
  message(STATUS "tinygltf: not found; glTF files are refused (Debian: libtinygltf-dev)")
endif()

# Pages that replay runs contain compressed data and three.js.
find_package(ZLIB REQUIRED)
find_file(THREE_JS three.min.js PATHS /usr/share/javascript/three REQUIRED)
get_filename_component(three_folder "${THREE_JS}" DIRECTORY)
find_file(THREE_CONTROLS_JS OrbitControls.js PATHS "${three_folder}/examples/js/controls" REQUIRED NO_DEFAULT_PATH)

find_path(STB_INCLUDE_DIR stb_image_write.h PATH_SUFFIXES stb REQUIRED)  # header-only, used by host/render/png.cpp
