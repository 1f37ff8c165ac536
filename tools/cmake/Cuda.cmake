# The CUDA backend: one source file, compiled by nvcc.
find_program(CMAKE_CUDA_COMPILER nvcc HINTS /usr/local/cuda/bin REQUIRED)
if(NOT CMAKE_CUDA_ARCHITECTURES)
  set(CMAKE_CUDA_ARCHITECTURES 80 90)  # A100, H100 and H200; later ones compile what is kept for 90
endif()
enable_language(CUDA)
set(CMAKE_CUDA_STANDARD 20)
set(CMAKE_CUDA_STANDARD_REQUIRED ON)
list(APPEND host_sources "${PROJECT_SOURCE_DIR}/host/solver/backend_cuda.cu")
# No contraction, here too: the same bits as on the host. The warnings are of what only the host calls, in templates
# that both compile; tests/cuda.sh compiles all that a device calls with every warning on.
set_source_files_properties("${PROJECT_SOURCE_DIR}/host/solver/backend_cuda.cu" PROPERTIES COMPILE_OPTIONS
  "-fmad=false;--expt-relaxed-constexpr;-diag-suppress=20011,20014;-Xcompiler=-Wno-psabi,-fno-math-errno,-fno-trapping-math,-ffp-contract=off,-fopenmp")
set_source_files_properties(host/solver/backend_host.cpp PROPERTIES COMPILE_DEFINITIONS MALHA_HAS_CUDA)
