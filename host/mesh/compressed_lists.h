// SPDX-License-Identifier: Apache-2.0
// Lists of items in compressed form, as the rows of a sparse matrix.
#pragma once
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace malha {

/// One list for each number from 0 on. List k is list[begin[k]] .. list[begin[k + 1] - 1].
template <class Item>
struct CompressedLists {
  std::vector<int> begin{0};  // of each list, then the number of all items
  std::vector<Item> list;

  CompressedLists() = default;
  /// `visit(add)` must call add(k, item) for each item of each list k; it is called twice. Items keep its order.
  template <class Visit>
  CompressedLists(std::size_t lists, const Visit& visit) : begin(lists + 1, 0) {
    visit([&](int k, const Item&) { ++begin[k + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    list.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    visit([&](int k, const Item& item) { list[next[k]++] = item; });
  }

  std::span<const Item> operator[](int k) const { return {list.data() + begin[k], list.data() + begin[k + 1]}; }
  std::span<Item> operator[](int k) { return {list.data() + begin[k], list.data() + begin[k + 1]}; }
};

}  // namespace malha
