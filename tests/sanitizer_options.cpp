// SPDX-License-Identifier: Apache-2.0
// Options of the sanitizers, which they read before main.

// LLVM's OpenMP keeps the memory of a team whose threads a later team does not need.
extern "C" const char* __lsan_default_suppressions() { return "leak:libomp.so\n"; }
