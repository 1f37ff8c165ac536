// The solvers instantiated for a CUDA device.
#include <string>

#include "host/filter/make_filter.h"
#include "host/solver/backend_cuda.h"
#include "host/solver/cuda.cuh"
#include "host/solver/instantiate.h"

namespace malha {

template <class AnyVisit>
void visit_patches(const Cuda& executor, const AnyVisit& visit, int begin, int end, const FastMemory& memory) {
  parallel_groups(executor, begin, end, memory, visit);
}

void require_cuda() {
  int devices = 0;
  std::string why;
  if (const cudaError_t status = cudaGetDeviceCount(&devices); status != cudaSuccess) why = cudaGetErrorString(status);
  cudaFuncAttributes code;
  if (devices > 0 && cudaFuncGetAttributes(&code, fill_with<int>) != cudaSuccess)
    devices = 0, why = "this build has no code for the one that is there";
  cudaGetLastError();  // which stays until it is asked for
  if (devices == 0)
    throw InputError("backend: found no CUDA device" + (why.empty() ? "" : " (" + why + ")") +
                     "; allowed: openmp, serial");
}

std::unique_ptr<Solver> instantiate_on_cuda(const Model& model, const OpenMP& host, const ShowProgress& progress) {
  int device = 0, shared = 0;
  require(cudaGetDevice(&device), "be chosen");
  require(cudaDeviceGetAttribute(&shared, cudaDevAttrMaxSharedMemoryPerBlockOptin, device), "tell its memory");
  Cuda executor;
  executor.shared_bytes = std::size_t(shared), executor.host = host;
  return instantiate(model, executor, host.threads, progress);
}

}  // namespace malha
