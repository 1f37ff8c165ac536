// Between the user's numbers of particles and the solver's.
#pragma once
#include <cstddef>
#include <vector>

namespace malha {

/// The solver's number of each of the user's; `user_of`: see Model.
inline std::vector<int> solver_of(const std::vector<int>& user_of) {
  std::vector<int> of(user_of.size());
  for (std::size_t i = 0; i < of.size(); ++i) of[user_of[i]] = static_cast<int>(i);
  return of;
}

}  // namespace malha
