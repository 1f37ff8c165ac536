// SPDX-License-Identifier: Apache-2.0
// Exit status of the programs.
#pragma once

namespace malha {

/// The command's exit status. An interrupted run exits with 128 + the signal: 130 for Ctrl-C.
enum ExitStatus { kDone = 0, kUnmet = 1, kBadInput = 2, kDiverged = 3, kFailed = 4, kOutOfMemory = 5 };

}  // namespace malha
