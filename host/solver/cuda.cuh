// SPDX-License-Identifier: Apache-2.0
// Executor for a CUDA device: launches, and memory of arrays. Only nvcc compiles it.
#pragma once
#include <cuda_runtime.h>

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "host/base/array.h"
#include "host/base/launch_graph.h"
#include "host/base/memory_size.h"
#include "host/solver/backend_cuda.h"
#include "kernels/parallel/compute.h"
#include "malha/error.h"

namespace malha {

/// Throws DeviceLost with the driver's message if a call to it has failed.
inline void require(cudaError_t status, const char* what) {
  if (status != cudaSuccess)
    throw DeviceLost(std::string("the CUDA device could not ") + what + ": " + cudaGetErrorString(status));
}

/// The one stream in which all launches run in order, from whichever host thread.
inline cudaStream_t stream() {
  static const cudaStream_t own = [] {
    cudaStream_t made = nullptr;
    require(cudaStreamCreateWithFlags(&made, cudaStreamNonBlocking), "make a stream");
    return made;
  }();
  return own;
}
inline void wait() { require(cudaStreamSynchronize(stream()), "finish"); }

/// Memory of arrays on the device. Kernels that query Embree run on the host, on the same arrays: the memory is
/// managed, so that its pages migrate on access. In a scene without environment none migrates.
class DeviceMemory {
 public:
  static DeviceMemory& the() {
    static DeviceMemory memory;
    return memory;
  }
  /// Throws OutOfMemory beyond the memory of the device: managed memory would be paged from the host instead.
  void* allocate(std::size_t bytes) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (used_ == 0) {
      std::size_t free = 0, all = 0;
      require(cudaMemGetInfo(&free, &all), "tell its memory");
      most_ = free - free / 16;  // leaves some for the stacks of kernels
    }
    if (used_ + bytes > most_)
      throw OutOfMemory("the CUDA device: found " + in_gib(double(used_ + bytes)) + " that the scene needs at least; " +
                        "allowed: what fits into the " + in_gib(double(most_)) + " that are free there");
    void* data = nullptr;
    require(cudaMallocManaged(&data, bytes), "give memory");
    used_ += bytes, bytes_of_[data] = bytes;
    return data;
  }
  void release(void* data) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = bytes_of_.find(data);
    used_ -= found->second, bytes_of_.erase(found);
    cudaDeviceSynchronize();  // launches may still use it
    cudaFree(data);
  }

 private:
  std::mutex mutex_;
  std::unordered_map<void*, std::size_t> bytes_of_;
  std::size_t used_ = 0, most_ = 0;
};

/// Scratch memory that consecutive launches reuse.
class Scratch {
 public:
  Scratch() = default;
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    for (void* const data : all_) DeviceMemory::the().release(data);
  }
  const void* at() const { return data_; }
  char* of(std::size_t bytes) {
    if (bytes > bytes_) {  // outgrown memory is kept: recorded launches use it
      bytes = bytes > 2 * bytes_ ? bytes : 2 * bytes_;
      data_ = DeviceMemory::the().allocate(bytes), bytes_ = bytes;
      all_.push_back(data_);
    }
    return static_cast<char*>(data_);
  }

 private:
  std::vector<void*> all_;
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
};

struct Cuda {
  std::size_t shared_bytes = 0;  // largest shared memory of a block
  bool waits = false;            // synchronises after every pass, to time it
  OpenMP host{};                 // executor of work on the host
  Instructions instructions = Instructions::OneLane;
  std::shared_ptr<Scratch> partial = std::make_shared<Scratch>(), fast = std::make_shared<Scratch>();
};

template <class T>
__global__ void fill_with(T* to, std::size_t count, T value) {
  const std::size_t i = std::size_t(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < count) to[i] = value;
}

inline constexpr int kBlock = 128;  // largest number of threads of a block
inline constexpr int kSingleThreads =
    32;  // threads of a block where each is a group of its own: few, to occupy all multiprocessors
inline constexpr int kDefaultSharedBytes = 48 * 1024;  // shared memory that every kernel may use without an attribute
inline unsigned blocks_of(std::size_t items, int block) { return unsigned((items + block - 1) / block); }

template <>
struct Memory<Cuda> {
  // A program's memory is on the host, and refused with a device.
  static void* allocate(std::size_t bytes, std::pmr::memory_resource*) { return DeviceMemory::the().allocate(bytes); }
  static void release(void* data, std::size_t, std::pmr::memory_resource*) { DeviceMemory::the().release(data); }
  template <class T>
  static void fill(T* to, std::size_t count, const T& value) {
    if (count > 0) fill_with<<<blocks_of(count, kBlock), kBlock, 0, stream()>>>(to, count, value);
    require(cudaGetLastError(), "fill memory");
  }
  template <class T>
  static void copy_in(const T* from, std::size_t count, T* to) {
    copy(from, count, to, cudaMemcpyHostToDevice, "take data"), wait();
  }
  template <class T>
  static void copy_out(const T* from, std::size_t count, T* to) {
    copy(from, count, to, cudaMemcpyDeviceToHost, "give data back"), wait();
  }
  template <class T>
  static void copy(const T* from, std::size_t count, T* to) {
    copy(from, count, to, cudaMemcpyDeviceToDevice, "copy data");
  }
  template <class T>
  static bool has(const T* from, std::size_t count, const T& value) {
    std::vector<T> values(count);
    copy_out(from, count, values.data());
    return Memory<Serial>::has(values.data(), count, value);
  }
  static constexpr bool kOnHost = false;

 private:
  template <class T>
  static void copy(const T* from, std::size_t count, T* to, cudaMemcpyKind way, const char* what) {
    if (count > 0) require(cudaMemcpyAsync(to, from, count * sizeof(T), way, stream()), what);
  }
};

inline void synchronize(const Cuda&) { wait(); }
inline bool is_timed(const Cuda& executor) { return executor.waits; }
inline bool is_leader(const Cuda&) { return true; }
inline Cuda single_threaded(const Cuda& executor) { return executor; }
inline OpenMP on_host(const Cuda& executor) { return executor.host; }

/// Launches follow each other in one stream: no wait between them.
template <class Work>
void parallel_region(const Cuda& executor, int /*width*/, const Work& work) {
  work(executor);
}

/// Graphs of launches, by their keys.
template <>
struct Recording<Cuda> {
  std::map<std::string, cudaGraphExec_t> replays;

  Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  ~Recording() { forget(); }
  void forget() {
    for (const auto& [key, replay] : replays) cudaGraphExecDestroy(replay);
    replays.clear();
  }
};

template <class Key, class Work>
void repeated(const Cuda& executor, Recording<Cuda>& recording, const Key& key, const Work& work) {
  constexpr std::size_t most = 32;  // graphs, for scenes whose parameters keep changing
  cudaStreamCaptureStatus outer = cudaStreamCaptureStatusNone;
  require(cudaStreamIsCapturing(stream(), &outer), "tell whether it records");
  if (outer != cudaStreamCaptureStatusNone) return work();
  const auto own_key = [&] { return key() + key_from(executor.fast->at(), executor.partial->at()); };
  auto found = recording.replays.find(own_key());
  while (found == recording.replays.end()) {
    if (recording.replays.size() == most) recording.forget();
    const std::string before = own_key();
    cudaGraph_t graph = nullptr;
    require(cudaStreamBeginCapture(stream(), cudaStreamCaptureModeRelaxed), "record launches");
    try {
      work();
    } catch (...) {  // ends the capture, so that the stream can be used again
      cudaStreamEndCapture(stream(), &graph);
      if (graph != nullptr) cudaGraphDestroy(graph);
      cudaGetLastError();  // clears the error
      throw;
    }
    require(cudaStreamEndCapture(stream(), &graph), "record launches");
    if (own_key() == before)  // otherwise scratch memory has moved during the capture
      require(cudaGraphInstantiateWithFlags(&recording.replays[before], graph, 0), "keep launches");
    cudaGraphDestroy(graph);
    found = recording.replays.find(own_key());
  }
  require(cudaGraphLaunch(found->second, stream()), "replay launches");
}

template <class Key, class Work>
void repeated_region(const Cuda& executor, int /*width*/, Recording<Cuda>& recording, const Key& key,
                     const Work& work) {
  repeated(executor, recording, key, [&] { work(executor); });
}

/// A thread of a block.
struct DeviceThreads {
#if defined(__CUDA_ARCH__)
  KERNEL int rank() const { return int(threadIdx.x); }
  KERNEL int count() const { return int(blockDim.x); }
  KERNEL void wait(int) const { __syncthreads(); }
  template <class Value, class Add>
  KERNEL Value reduced(const Value& own, Value all, const Add& add) const {
    __shared__ __align__(16) unsigned char memory[kBlock * sizeof(Value)];
    Value* const of_thread = reinterpret_cast<Value*>(memory);
    of_thread[threadIdx.x] = own;
    __syncthreads();
    for (unsigned t = 0; t < blockDim.x; ++t) add(all, of_thread[t]);
    __syncthreads();  // before it is written again
    return all;
  }
#else
  KERNEL int rank() const { return 0; }
  KERNEL int count() const { return 1; }
  KERNEL void wait(int) const {}
  template <class Value, class Add>
  KERNEL Value reduced(const Value& own, const Value&, const Add&) const {
    return own;
  }
#endif
};

template <class Kernel>
__global__ void launch_items(int n, Kernel kernel) {
  const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i < unsigned(n)) kernel(int(i));
}

/// Runs a group per block. Its fast memory is `bytes` at `fast`, or shared memory where `fast` is null.
template <class Kernel>
__global__ void launch_shared(int begin, char* fast, std::size_t bytes, Kernel kernel) {
  extern __shared__ __align__(64) char own[];  // rows of four numbers are loaded as one
  void* const memory = fast ? fast + blockIdx.x * bytes : own;
  kernel(Block<DeviceThreads>{begin + int(blockIdx.x), memory, {}});
}

/// Runs a group per thread.
template <class Kernel>
__global__ void launch_single_threads(int begin, int groups, char* fast, std::size_t bytes, Kernel kernel) {
  const int g = int(blockIdx.x * blockDim.x + threadIdx.x);
  if (g < groups) kernel(Group<OneLane>{begin + g, -1, fast ? fast + g * bytes : nullptr});
}

template <class Kernel>
void parallel_for(const Cuda& executor, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  if constexpr (kRunsOnHost<Kernel>) {
    synchronize(executor);
    parallel_for(on_host(executor), n, kernel, 0);
  } else {
    note_launch(kernel, n);
    if (n > 0) launch_items<<<blocks_of(n, kBlock), kBlock, 0, stream()>>>(n, kernel);
    require(cudaGetLastError(), "launch a kernel");
  }
}

template <class Kernel>
void parallel_groups(const Cuda& executor, int begin, int end, const ScratchMemory& memory, const Kernel& kernel) {
  note_launch(kernel, end - begin);
  const int groups = end - begin;
  if (groups <= 0) return;
  if constexpr (kShared<Kernel>) {
    const bool fits = memory.bytes <= executor.shared_bytes;
    const int shared = fits ? int(memory.bytes) : 0;
    if (shared > kDefaultSharedBytes)
      require(cudaFuncSetAttribute(launch_shared<Kernel>, cudaFuncAttributeMaxDynamicSharedMemorySize, shared),
              "share so much memory");
    char* const fast = fits ? nullptr : executor.fast->of(memory.bytes * std::size_t(groups));
    constexpr int threads = kThreads<Kernel> < kBlock ? kThreads<Kernel> : kBlock;
    launch_shared<<<unsigned(groups), threads, shared, stream()>>>(begin, fast, memory.bytes, kernel);
  } else {
    char* const fast = memory.bytes > 0 ? executor.fast->of(memory.bytes * std::size_t(groups)) : nullptr;
    launch_single_threads<<<blocks_of(groups, kSingleThreads), kSingleThreads, 0, stream()>>>(begin, groups, fast,
                                                                                              memory.bytes, kernel);
  }
  require(cudaGetLastError(), "launch a kernel");
}

template <class Kernel>
void parallel_for_interleaved(const Cuda& executor, int groups, const Kernel& kernel,
                              const ScratchMemory& memory = {}) {
  if constexpr (kRunsOnHost<Kernel>)
    deal_on_host(on_host(executor), groups, kernel);
  else
    parallel_groups(executor, 0, groups, memory, kernel);
}

/// Partial sums of a reduction, in device memory.
template <class Value, class Kernel>
Value* partial_sums(const Cuda& executor, int n, const ReducePlan& plan, const Kernel& kernel) {
  auto* const partial =
      reinterpret_cast<Value*>(executor.partial->of((plan.all + std::size_t(kReduceGroups)) * sizeof(Value)));
  auto* const of_run = plan.runs > 1 ? partial + kReduceGroups : partial;
  parallel_for(executor, plan.all, ReduceRun<Value, Kernel>{of_run, kernel, n});
  if (plan.runs > 1) parallel_for(executor, plan.groups, JoinRuns<Value>{of_run, partial, plan.all, plan.runs});
  return partial;
}

template <class Value, class Kernel>
Value parallel_reduce(const Cuda& executor, int n, const Kernel& kernel, int /*grain*/ = kParticleGrain) {
  const ReducePlan plan(n);
  std::vector<Value> sums(kReduceGroups, Value{});
  if constexpr (kRunsOnHost<Kernel>) {
    synchronize(executor);
    parallel_for(on_host(executor), plan.groups, ReduceGroup<Value, Kernel>{sums.data(), kernel, n, plan.runs}, 0);
  } else {
    Memory<Cuda>::copy_out(partial_sums<Value>(executor, n, plan, kernel), std::size_t(plan.groups), sums.data());
  }
  return sum_of_tree(sums.data(), plan.groups);
}

template <class Value, class Kernel>
void parallel_reduce_into(const Cuda& executor, int n, const Kernel& kernel, Value* to,
                          int /*grain*/ = kParticleGrain) {
  const ReducePlan plan(n);
  parallel_for(executor, 1, JoinGroups<Value>{partial_sums<Value>(executor, n, plan, kernel), to, plan.groups});
}

}  // namespace malha
