// SPDX-License-Identifier: Apache-2.0
// Instantiation of the solvers for a CUDA device.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "host/base/pinned_memory.h"
#include "host/base/scoped_value.h"
#include "host/base/stopwatch.h"
#include "host/filter/make_filter.h"
#include "host/solver/backend_cuda.h"
#include "host/solver/cuda.cuh"
#include "host/solver/instantiate.h"

namespace malha {

template <class AnySolve>
void solve_patches(const Cuda& executor, const AnySolve& solve, int begin, int end, const ScratchMemory& memory) {
  parallel_groups(executor, begin, end, memory, solve);
}

void require_cuda() {
  int devices = 0;
  std::string why;
  if (const cudaError_t status = cudaGetDeviceCount(&devices); status != cudaSuccess) why = cudaGetErrorString(status);
  cudaFuncAttributes code;
  if (devices > 0 && cudaFuncGetAttributes(&code, fill_with<int>) != cudaSuccess)
    devices = 0, why = "this build has no code for the one that is there";
  cudaGetLastError();  // clears the error
  if (devices == 0)
    throw InputError("backend: found no CUDA device" + (why.empty() ? "" : " (" + why + ")") +
                     "; allowed: openmp, serial");
}

DeviceStats cuda_device() {
  require_cuda();
  constexpr std::size_t bytes = std::size_t(256) << 20;  // larger than its caches
  constexpr int rounds = 10;
  int device = 0;
  cudaDeviceProp properties;
  require(cudaGetDevice(&device), "be chosen");
  require(cudaGetDeviceProperties(&properties, device), "tell what it is");
  Scratch from, to;
  const char* const source = from.of(bytes);
  char* const goal = to.of(bytes);
  Memory<Cuda>::fill(from.of(bytes), bytes, char(1));
  double least = INFINITY;
  for (int round = 0; round < rounds; ++round)
    least = std::min(least, seconds([&] {
                       Memory<Cuda>::copy(source, bytes, goal);
                       wait();
                     }));
  return {properties.name, 2 * double(bytes) / least};
}

std::unique_ptr<Solver> instantiate_on_cuda(const Model& model, const OpenMP& host, const ShowProgress& progress,
                                            bool timed) {
  int device = 0, shared = 0, at_once = 0;
  require(cudaGetDevice(&device), "be chosen");
  require(cudaDeviceGetAttribute(&shared, cudaDevAttrMaxSharedMemoryPerBlockOptin, device), "tell its memory");
  require(cudaDeviceGetAttribute(&at_once, cudaDevAttrConcurrentManagedAccess, device), "tell its memory");
  if (!at_once && mesh_count(model) > 0)
    throw InputError(
        "backend: found a CUDA device whose memory the host cannot read while kernels run; allowed for a "
        "scene with meshes in its environment: one with concurrent managed access, or openmp, serial");
  // Memory of environment meshes is managed: the host extends their triangle lists while kernels read them.
  const ScopedValue<ReadableMemory> managed(readable_memory, {[](std::size_t bytes, bool zeros) {
                                                                void* const data = DeviceMemory::the().allocate(bytes);
                                                                if (zeros) std::memset(data, 0, bytes);
                                                                return data;
                                                              },
                                                              [](void* data) { DeviceMemory::the().release(data); }});
  Cuda executor;
  executor.shared_bytes = std::size_t(shared), executor.host = host, executor.waits = timed;
  return instantiate(model, executor, host.threads, progress);
}

}  // namespace malha
