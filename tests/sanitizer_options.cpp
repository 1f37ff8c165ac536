// SPDX-License-Identifier: Apache-2.0
// Options of the sanitizers.

// LLVM's OpenMP does not free the data of teams with more threads than later ones.
extern "C" const char* __lsan_default_suppressions() { return "leak:libomp.so\n"; }
