// SPDX-License-Identifier: Apache-2.0
// Checks of numbers that are read from files.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "malha/error.h"

namespace malha {

/// Squares of numbers up to this are finite in single precision.
inline constexpr double kMostSquared = 1e18;

/// Throws InputError if a number of a list of points is not finite or beyond `most`. `what` names the list.
template <class Point>
void check_numbers(const std::vector<Point>& list, const std::string& what, const std::string& file,
                   double most = kMostSquared) {
  for (std::size_t i = 0; i < list.size(); ++i)
    for (const auto number : list[i])
      if (!(std::abs(double(number)) <= most))
        refuse(file, what, shown(double(number)) + " at particle " + std::to_string(i),
               most > kMostSquared ? "finite numbers" : "numbers up to 1e18");
}

/// Throws InputError if a distance is not a number from 0 to kMostSquared.
template <class R>
void check_distances(const std::vector<R>& list, const std::string& what, const std::string& file) {
  for (const R distance : list)
    if (!(distance >= 0 && double(distance) <= kMostSquared)) refuse(file, what, shown(double(distance)), "at least 0");
}

}  // namespace malha
