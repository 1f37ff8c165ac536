// SPDX-License-Identifier: Apache-2.0
// Instruction sets of the CPU, and the one function that is compiled for each. A build for one machine (-march) has
// only the compiler's own set; a portable build for x86-64 has the pack kernels for every set and chooses at run time.
#pragma once

#if defined(__CUDACC__)
#define KERNEL __host__ __device__ inline
#define KERNEL_LAMBDA
#else
#define KERNEL [[gnu::always_inline]] inline
#define KERNEL_LAMBDA __attribute__((always_inline))
#endif
/// For device code that would need too many registers: a function that is not inlined, and a loop that is not unrolled.
#if defined(__CUDACC__)
#define KERNEL_NOINLINE __host__ __device__ __noinline__
#define KERNEL_ROLLED _Pragma("unroll 1")
#else
#define KERNEL_NOINLINE KERNEL
#define KERNEL_ROLLED
#endif
/// For kernels that no device runs, because they query Embree.
#define HOST_KERNEL [[gnu::always_inline]] inline

namespace malha {

// Instruction sets, the narrowest first. OneLane is a device thread, whose packs are single numbers.
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
using NativeIsa = Avx512;  // the one that the compiler generates
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

/// The same pointer, opaque to the compiler, so that it recomputes addresses instead of keeping them in registers.
template <class T>
KERNEL T* opaque(T* pointer) {
#if !defined(__CUDACC__)
  asm("" : "+r"(pointer));
#endif
  return pointer;
}

/// Runs kernel(begin) .. kernel(end - 1).
template <class Kernel>
KERNEL void each(const Kernel& kernel, int begin, int end) {
  const Kernel own = kernel;  // a copy that the kernel's writes cannot alias: its pointers stay in registers
  for (int i = begin; i < end; ++i) own(i);
}

// The same, compiled for an instruction set. All functions that a kernel calls are KERNEL and are inlined into `run`;
// hence no function that the linker could share with other code has instructions that the CPU may lack. This is also
// why the set is an argument of `run` and not a flag of a source file, and why the body of an OpenMP region, which the
// compiler makes a function of its own, only calls `run`.
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

/// Calls f(Isa{}) for every instruction set of both the build and the CPU, the narrowest first.
template <class F, class... Isas>
void for_each_isa(F&& f, IsaList<Isas...>) {
  ((has(Isas{}) ? f(Isas{}) : void()), ...);
}
/// `Isas` distinguishes the functions of a device compiler, which has OneLane alone, from those of the host's compiler.
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
