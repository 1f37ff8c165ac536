// What a model takes up in memory, and what of it nobody reads once its solver is made.
#pragma once
#include <cstddef>

#include "host/model/model.h"

namespace malha {

/// Of the model's arrays.
std::size_t bytes(const Model& model);

/// Gives back what only solvers read while they are made (masses, velocities, patches), and what the arrays that stay
/// have grown beyond their elements.
void keep_what_runs_need(Model& model);

}  // namespace malha
