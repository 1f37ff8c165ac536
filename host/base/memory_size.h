// SPDX-License-Identifier: Apache-2.0
// How much memory the machine has left.
#pragma once
#include <cstddef>
#include <string>

namespace malha {

/// Bytes that can be taken without swapping; where the system does not say, more than there can be.
std::size_t available_memory();

/// "1.5 GiB".
std::string in_gib(double bytes);

}  // namespace malha
