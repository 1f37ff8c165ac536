// SPDX-License-Identifier: Apache-2.0
// How the programs end.
#pragma once

namespace malha {

/// What the command's exit status says. An interrupted run exits with 128 + the signal: 130 for Ctrl-C.
enum ExitStatus { kDone = 0, kUnmet = 1, kBadInput = 2, kDiverged = 3, kFailed = 4, kOutOfMemory = 5 };

}  // namespace malha
