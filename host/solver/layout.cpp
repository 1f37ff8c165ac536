#include "host/solver/layout.h"

#include <algorithm>

namespace malha {

Layout lay_out(const std::vector<int>& particles, int arity, const std::vector<bool>& pinned,
               const Colouring& colouring, int lanes) {
  const int count = static_cast<int>(colouring.colour.size());
  const auto touches_pin = [&](int c) {
    return std::any_of(&particles[c * arity], &particles[c * arity] + arity, [&](int i) { return pinned[i]; });
  };
  std::vector<std::vector<int>> plain(colouring.count), careful(colouring.count);
  for (int c = 0; c < count; ++c) (touches_pin(c) ? careful : plain)[colouring.colour[c]].push_back(c);

  Layout layout;
  for (int colour = 0; colour < colouring.count; ++colour) {
    auto& slots = layout.constraint;
    const int begin = static_cast<int>(slots.size());
    slots.insert(slots.end(), plain[colour].begin(), plain[colour].end());
    slots.insert(slots.end(), careful[colour].begin(), careful[colour].end());
    const int in_colour = static_cast<int>(slots.size()) - begin;
    layout.batches.push_back({begin, in_colour, static_cast<int>(plain[colour].size()) / lanes * lanes});
    while (slots.size() % lanes != 0) slots.push_back(slots.back());
  }
  return layout;
}

}  // namespace malha
