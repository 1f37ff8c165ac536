// SPDX-License-Identifier: Apache-2.0
// The CPU's instruction sets, and the one function that is compiled for each. A build for one machine (-march) knows
// its compiler's own set alone; a portable build for x86-64 holds the pack kernels once a set and picks at run time.
#pragma once

#if defined(__CUDACC__)
#define KERNEL __host__ __device__ inline
#define KERNEL_LAMBDA
#else
#define KERNEL [[gnu::always_inline]] inline
#define KERNEL_LAMBDA __attribute__((always_inline))
#endif
/// Where a device has no registers for all at once: a function that its compiler calls instead of taking it in, and a
/// loop of which it keeps one round.
#if defined(__CUDACC__)
#define KERNEL_NOINLINE __host__ __device__ __noinline__
#define KERNEL_ROLLED _Pragma("unroll 1")
#else
#define KERNEL_NOINLINE KERNEL
#define KERNEL_ROLLED
#endif
/// Of kernels that no device runs: those that ask Embree.
#define HOST_KERNEL [[gnu::always_inline]] inline

namespace malha {

// The narrowest first. One lane: a thread of a device, whose packs are as wide as one number.
enum class Instructions { OneLane, Baseline, Avx2, Avx512 };
struct OneLane {
  static constexpr Instructions value = Instructions::OneLane;
  static constexpr const char* name = "one lane";
};
struct Baseline {
  static constexpr Instructions value = Instructions::Baseline;
  static constexpr const char* name = "baseline";
  static constexpr int register_bytes = 16;
};
struct Avx2 {
  static constexpr Instructions value = Instructions::Avx2;
  static constexpr const char* name = "avx2";
  static constexpr int register_bytes = 32;
};
struct Avx512 {
  static constexpr Instructions value = Instructions::Avx512;
  static constexpr const char* name = "avx512";
  static constexpr int register_bytes = 64;
};

template <class... Isas>
struct IsaList {};

#if defined(__CUDACC__)
using NativeIsa = OneLane;
#elif defined(__AVX512F__)
using NativeIsa = Avx512;  // the compiler's
#elif defined(__AVX2__)
using NativeIsa = Avx2;
#else
using NativeIsa = Baseline;
#endif

#if defined(__x86_64__) && !defined(__AVX2__) && !defined(__CUDACC__)
#define COMPILED_FOR(features) [[gnu::noinline, gnu::target(features)]]
using BuiltIsas = IsaList<Baseline, Avx2, Avx512>;
inline bool has(Baseline) { return true; }
inline bool has(Avx2) { return __builtin_cpu_supports("avx2"); }
inline bool has(Avx512) {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
}
#else
#define COMPILED_FOR(features) [[gnu::noinline]]
using BuiltIsas = IsaList<NativeIsa>;
inline bool has(NativeIsa) { return true; }
#endif

/// The same pointer, of which the compiler no longer knows what it computed from it before.
template <class T>
KERNEL T* unknown(T* pointer) {
#if !defined(__CUDACC__)
  asm("" : "+r"(pointer));
#endif
  return pointer;
}

/// kernel(begin) .. kernel(end - 1).
template <class Kernel>
KERNEL void each(const Kernel& kernel, int begin, int end) {
  const Kernel own = kernel;  // what the kernel writes cannot change it: its pointers stay in registers
  for (int i = begin; i < end; ++i) own(i);
}

// The same, compiled for an instruction set. What a kernel calls is KERNEL and so becomes part of `run`; hence no
// function that the linker could share with other code holds instructions that the CPU may lack. That is also why the
// set is an argument of `run` and not a flag of a source file, and why the body of an OpenMP region, a function of its
// own to the compiler, only calls `run`.
template <class Kernel>
KERNEL void run(OneLane, const Kernel& kernel, int begin, int end) {
  each(kernel, begin, end);
}
template <class Kernel>
[[gnu::noinline]] void run(Baseline, const Kernel& kernel, int begin, int end) {
  each(kernel, begin, end);
}
template <class Kernel>
COMPILED_FOR("avx2")
void run(Avx2, const Kernel& kernel, int begin, int end) {
  each(kernel, begin, end);
}
template <class Kernel>
COMPILED_FOR("avx512f,avx512vl,avx512dq,avx512bw")
void run(Avx512, const Kernel& kernel, int begin, int end) {
  each(kernel, begin, end);
}
#undef COMPILED_FOR

/// Calls f(Isa{}) for every set that both the build and the CPU have, the narrowest first.
template <class F, class... Isas>
void for_each_isa(F&& f, IsaList<Isas...>) {
  ((has(Isas{}) ? f(Isas{}) : void()), ...);
}
/// `Isas` keeps a device compiler's functions, which know one lane alone, apart from those of the host's compiler.
template <class Isas = BuiltIsas, class F>
void for_each_isa(F&& f) {
  for_each_isa(f, Isas{});
}

template <class Isas = BuiltIsas>
Instructions widest_instructions() {
  Instructions widest{};
  for_each_isa<Isas>([&]<class Isa>(Isa) { widest = Isa::value; });
  return widest;
}

}  // namespace malha
