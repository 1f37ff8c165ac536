// How exact a filter is, against the same system solved in double.
#pragma once
#include <functional>
#include <vector>

#include "host/filter/system.h"

namespace malha {

/// a = S~ F of the filter at hand, three numbers an unknown.
using ApplyFilter = std::function<std::vector<double>(const std::vector<double>& forces)>;

/// S F to rounding: iterative refinement with the filter at hand in place of S.
std::vector<double> refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces);

/// Independent numbers in [-1, 1), the same every time, without the mean force of free bodies.
std::vector<double> noise_forces(const SpringSystem& system);
/// (A - M) d of independent displacements d: what stretched springs pull with.
std::vector<double> elastic_forces(const SpringSystem& system);

/// Takes the mean over mass from the accelerations of free bodies.
void remove_mean(const SpringSystem& system, std::vector<double>& accelerations);

/// |a - b| / |b|.
double relative_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace malha
