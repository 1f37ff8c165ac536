// SPDX-License-Identifier: Apache-2.0
// Available memory of the machine.
#pragma once
#include <cstddef>
#include <string>

namespace malha {

/// Bytes that can be allocated without swapping; if unknown, the largest number.
std::size_t available_memory();

/// "1.5 GiB".
std::string in_gib(double bytes);

}  // namespace malha
