// SPDX-License-Identifier: Apache-2.0
// Whether this machine gives the threads that a run asks for.
#pragma once

namespace malha {

/// Throws OutOfMemory where so many threads cannot be started. OpenMP would end the program, with a status that says
/// something else.
void require_threads(int threads);

}  // namespace malha
