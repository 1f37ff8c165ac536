// SPDX-License-Identifier: Apache-2.0
// What the sanitizers are told before main.

// LLVM's OpenMP keeps what it has of a team whose threads a later one does not need.
extern "C" const char* __lsan_default_suppressions() { return "leak:libomp.so\n"; }
