// SPDX-License-Identifier: Apache-2.0
// Maps between the user's numbering of particles and the solver's.
#pragma once
#include <cstddef>
#include <vector>

namespace malha {

/// The solver's index of each of the user's particles, the inverse of Model::user_index; or that of any other order.
inline std::vector<int> solver_of(const std::vector<int>& user_index) {
  std::vector<int> of(user_index.size());
  for (std::size_t i = 0; i < of.size(); ++i) of[user_index[i]] = static_cast<int>(i);
  return of;
}

/// Values in the solver's order, reordered to the user's.
template <class T>
std::vector<T> in_user_order(const std::vector<T>& values, const std::vector<int>& user_index) {
  std::vector<T> ordered(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) ordered[user_index[i]] = values[i];
  return ordered;
}
/// Values in the user's order, reordered to the solver's.
template <class T>
std::vector<T> in_solver_order(const std::vector<T>& values, const std::vector<int>& user_index) {
  std::vector<T> ordered;
  ordered.reserve(values.size());
  for (const int user : user_index) ordered.push_back(values[user]);
  return ordered;
}

}  // namespace malha
