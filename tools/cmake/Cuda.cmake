# SPDX-License-Identifier: Apache-2.0
# The CUDA backend: one source file, compiled by nvcc. CMake 3.25 (Debian 12) does not support C++20 with nvcc, so a
# custom command calls nvcc.
find_package(CUDAToolkit 12 REQUIRED)
set(MALHA_CUDA_ARCHITECTURES 80 90 CACHE STRING
    "Devices to compile for: 80 is A100's, 90 H100's and H200's; later ones compile what is kept for the last")
set(cuda_source "${PROJECT_SOURCE_DIR}/host/solver/backend_cuda.cu")
set(cuda_object "${PROJECT_BINARY_DIR}/backend_cuda.o")
set(cuda_code "")
foreach(architecture IN LISTS MALHA_CUDA_ARCHITECTURES)
  list(APPEND cuda_code -gencode "arch=compute_${architecture},code=sm_${architecture}")
endforeach()
list(GET MALHA_CUDA_ARCHITECTURES -1 last)
list(APPEND cuda_code -gencode "arch=compute_${last},code=compute_${last}")
get_target_property(eigen_folders Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
list(TRANSFORM eigen_folders PREPEND "-isystem=")
# The host code of this file has the flags of all other sources: functions that both compilers emit are then the same,
# whichever is linked.
set(cuda_host_flags ${malha_code_options})
list(FILTER cuda_host_flags EXCLUDE REGEX ",")  # nvcc splits at commas; these options affect speed only
list(JOIN cuda_host_flags "," cuda_host_flags)
# No contraction, so that results have the same bits as on the host. The suppressed warnings concern host-only calls in
# templates for both; tests/cuda.sh compiles kernels with all warnings enabled.
add_custom_command(
  OUTPUT "${cuda_object}"
  COMMAND "${CUDAToolkit_NVCC_EXECUTABLE}" -std=c++20 -O3 -DNDEBUG -fmad=false -ftz=false -prec-div=true
          -prec-sqrt=true --expt-relaxed-constexpr
          -diag-suppress=997,20011,20014 ${cuda_code} --threads 0 -DEIGEN_DONT_VECTORIZE -I "${PROJECT_SOURCE_DIR}" -I "${PROJECT_SOURCE_DIR}/host"
          ${eigen_folders} "-Xcompiler=-fPIC,-fopenmp,-fvisibility=hidden,-fvisibility-inlines-hidden,-Wno-psabi,${cuda_host_flags}"
          -ccbin "${CMAKE_CXX_COMPILER}" -MD -MF "${cuda_object}.d" -c "${cuda_source}" -o "${cuda_object}"
  DEPENDS "${cuda_source}" DEPFILE "${cuda_object}.d" VERBATIM COMMENT "Building the CUDA backend (some minutes)")
set_source_files_properties("${cuda_object}" PROPERTIES EXTERNAL_OBJECT TRUE GENERATED TRUE)
list(APPEND host_sources "${cuda_object}")
set_source_files_properties(host/solver/backend_host.cpp PROPERTIES COMPILE_DEFINITIONS MALHA_HAS_CUDA)
