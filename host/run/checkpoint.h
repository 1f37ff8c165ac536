// SPDX-License-Identifier: Apache-2.0
// Checkpoints: the state of a run in a file that knows which model it belongs to.
#pragma once
#include <cstdint>
#include <string>

#include "host/model/model.h"

namespace malha {

struct Checkpoint {
  std::string state;           // the solver's
  std::int64_t frames = 0;     // that the run has written by then
  std::int64_t crossings = 0;  // the most that it has counted
  std::int64_t counted = 0;    // how often
};

/// Of what a checkpoint belongs to: the model before any tear.
std::uint64_t scene_hash(const Model& model);

/// Whole or not at all, and on the disk when it returns. Throws std::runtime_error (disk).
void write_checkpoint(const std::string& path, std::uint64_t scene, const Checkpoint& checkpoint);

/// Throws InputError for a file that is missing, damaged, or of another scene or precision. What may differ: the
/// scene's name, duration, outputs and expectations.
Checkpoint read_checkpoint(const std::string& path, std::uint64_t scene);

/// A state in memory that knows which scene it belongs to; and back. Throws InputError for one that is damaged or of
/// another scene.
std::string stamped(const std::string& state, std::uint64_t scene);
std::string unstamped(const std::string& bytes, std::uint64_t scene);

}  // namespace malha
