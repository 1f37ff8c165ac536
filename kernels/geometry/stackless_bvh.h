// SPDX-License-Identifier: Apache-2.0
// A bounding volume hierarchy of static triangles, traversed without a stack: a node is followed by its children, and
// has the index of the node after its subtree, where the traversal continues if the node is rejected.
#pragma once
#include "kernels/geometry/simplex.h"

namespace malha {

struct BoxNode {
  float low[3], high[3];  // rounded outwards
  int next;               // the node after all below this one
  int triangle;           // of a leaf; others: below 0
};

/// The slab between two planes along n, in multiples of its length from a point; with n = 0, all of space.
template <class R>
struct Slab {
  Vector3<R> at, n;
  R low, high;
};

struct StacklessBvh {
  const BoxNode* nodes;
  int count;

  /// Calls visit(triangle) for all whose boxes may overlap this one between two planes, in an order that does not
  /// depend on these.
  template <class R, class Visit>
  KERNEL void for_each_in(const Box<R>& box, const Slab<R>& slab, const Visit& visit) const {
    const Vector3<R> size{slab.n.x < R(0) ? -slab.n.x : slab.n.x, slab.n.y < R(0) ? -slab.n.y : slab.n.y,
                          slab.n.z < R(0) ? -slab.n.z : slab.n.z};
    for (int n = 0; n < count;) {
      const BoxNode& node = nodes[n];
      bool meets = node.low[0] <= box.high.x && box.low.x <= node.high[0] && node.low[1] <= box.high.y &&
                   box.low.y <= node.high[1] && node.low[2] <= box.high.z && box.low.z <= node.high[2];
      if (meets) {
        const Vector3<R> low{R(node.low[0]), R(node.low[1]), R(node.low[2])},
            high{R(node.high[0]), R(node.high[1]), R(node.high[2])};
        const R middle = dot(slab.n, (low + high) * R(0.5) - slab.at), half = R(0.5) * dot(size, high - low);
        meets = middle - half <= slab.high && middle + half >= slab.low;
      }
      if (meets && node.triangle >= 0) visit(node.triangle);
      n = meets ? n + 1 : node.next;
    }
  }
};

}  // namespace malha
