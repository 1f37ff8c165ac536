# SPDX-License-Identifier: Apache-2.0
# Compiler flags for the library, the command and the tests, which must agree because they share templates.
include(CheckCXXCompilerFlag)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Builds in folders side by side, and clones, share what they compile: paths are taken relative to the build folder.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_NOHASHDIR=1
                                  "${CCACHE_PROGRAM}")
endif()

# Code generation: the same bits at every optimisation level (no contraction), and vectorised sqrt (no errno).
set(malha_code_options -fno-math-errno -fno-trapping-math -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|i.86")
  set(gnu_on_x86 ON)
  # g++ 12 fuses alternating a * b + c, a * b - c in straight-line code (vfmaddsub) in spite of -ffp-contract=off.
  list(APPEND malha_code_options -fno-tree-slp-vectorize)
endif()
if(MALHA_NATIVE)
  check_cxx_compiler_flag(-march=native MALHA_HAS_MARCH_NATIVE)
  if(MALHA_HAS_MARCH_NATIVE)
    list(APPEND malha_code_options -march=native)
  endif()
  # Hardware gathers are slower than scalar loads on the CPUs for which -march=native uses them.
  if(gnu_on_x86)
    set(no_gathers "-mtune-ctrl=^use_gather,^use_gather_2parts,^use_gather_4parts")
    check_cxx_compiler_flag("${no_gathers}" MALHA_HAS_MTUNE_CTRL)
    if(MALHA_HAS_MTUNE_CTRL)
      list(APPEND malha_code_options "${no_gathers}")
    endif()
  endif()
endif()
if(MALHA_SANITIZE)
  list(APPEND malha_code_options "-fsanitize=${MALHA_SANITIZE}" -fno-omit-frame-pointer)
  add_link_options("-fsanitize=${MALHA_SANITIZE}")
  if(MALHA_SANITIZE MATCHES "address")
    # Kernels have thousands of inlined locals: checks of their scopes would take five times as long to compile.
    list(APPEND malha_code_options -fno-sanitize-address-use-after-scope)
  endif()
  if(MALHA_SANITIZE MATCHES "undefined")
    list(APPEND malha_code_options -fno-sanitize-recover=undefined)
    if(MALHA_SANITIZE MATCHES "address")
      # The address sanitizer or packs themselves already detect these accesses. Kernels compile twice as fast without.
      list(APPEND malha_code_options -fno-sanitize=null,object-size,pointer-overflow,alignment)
    endif()
  endif()
endif()

# -Wno-psabi: g++ notes that the ABI of wide vector arguments changed in g++ 4.6.
set(malha_warnings -Wall -Wextra -Wpedantic -Wshadow -Wno-psabi)
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # "omp simd" is a hint: a loop that is not vectorised is still correct. In files that are compiled together clang,
  # unlike g++, reports names of one file as shadowed by headers of a later one. Parts of the page are long literals. Masks of
  # packs and of single numbers use the same operator "&".
  list(APPEND malha_warnings -Wno-pass-failed -Wno-shadow -Wno-overlength-strings -Wno-bitwise-instead-of-logical)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # g++ 12 wrongly reports overlaps in std::string's operator+ (its bug 105651), and, for some processors, that a
  # moved-from std::vector frees memory that is not on the heap.
  list(APPEND malha_warnings -Wno-restrict -Wno-free-nonheap-object)
endif()
if(MALHA_WERROR)
  list(APPEND malha_warnings -Werror)
endif()

add_compile_options(${malha_code_options} ${malha_warnings})
# Eigen's vector code adds in another order, and contracts, depending on the instruction set, which would change bits
# from machine to machine.
add_compile_definitions(EIGEN_DONT_VECTORIZE)

# Compiler and flags, as reports name them.
string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type_upper)
set(malha_compiler "${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
string(JOIN " " malha_flags ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type_upper}} ${malha_code_options})
