// SPDX-License-Identifier: Apache-2.0
// Checkpoints: the state of a run in a file, with a hash of the model to which it belongs.
#pragma once
#include <cstdint>
#include <string>

#include "host/model/model.h"

namespace malha {

struct Checkpoint {
  std::string state;           // the solver's
  std::int64_t frames = 0;     // frames that the run has written
  std::int64_t crossings = 0;  // largest count of crossings
  std::int64_t counted = 0;    // number of crossing checks
};

/// Returns the hash of the model before any tear, which identifies the checkpoints of a scene.
std::uint64_t scene_hash(const Model& model);

/// Writes the checkpoint completely or not at all, and returns once it is on the disk. Throws std::runtime_error
/// (disk).
void write_checkpoint(const std::string& path, std::uint64_t scene, const Checkpoint& checkpoint);

/// Throws InputError for a file that is missing, damaged, or of another scene or precision. The scene's name, duration,
/// outputs and expectations may differ.
Checkpoint read_checkpoint(const std::string& path, std::uint64_t scene);

/// Adds a header with the hash of the scene to a state in memory, and removes it. Throws InputError for a state that is
/// damaged or of another scene.
std::string with_state_header(const std::string& state, std::uint64_t scene);
std::string without_state_header(const std::string& bytes, std::uint64_t scene);

}  // namespace malha
