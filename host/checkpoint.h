// Checkpoints: the state of a run in a file that knows which model it belongs to.
#pragma once
#include <string>

#include "host/model.h"

namespace malha {

/// Whole or not at all. Throws std::runtime_error (disk).
void write_checkpoint(const std::string& path, const Model& model, const std::string& state);

/// The state. Throws InputError for a file that is missing, damaged, or of another scene or precision. What may differ:
/// the scene's name, duration, outputs and expectations.
std::string read_checkpoint(const std::string& path, const Model& model);

}  // namespace malha
