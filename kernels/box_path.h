// Boxes of triangles that do not move, as a tree in which a walk needs no memory: a node is followed by its children,
// and says where to go on if nothing below it is of interest.
#pragma once
#include "kernels/hash_grid.h"

namespace malha {

struct BoxNode {
  float low[3], high[3];  // rounded outwards
  int next;               // the node after all below this one
  int triangle;           // of a leaf; others: below 0
};

struct BoxPath {
  const BoxNode* nodes;
  int count;

  /// Calls visit(triangle) for all whose boxes overlap this one, in an order that does not depend on it.
  template <class R, class Visit>
  KERNEL void for_each_in(const Box<R>& box, const Visit& visit) const {
    for (int n = 0; n < count;) {
      const BoxNode& node = nodes[n];
      const bool meets = node.low[0] <= box.high.x && box.low.x <= node.high[0] && node.low[1] <= box.high.y &&
                         box.low.y <= node.high[1] && node.low[2] <= box.high.z && box.low.z <= node.high[2];
      if (meets && node.triangle >= 0) visit(node.triangle);
      n = meets ? n + 1 : node.next;
    }
  }
};

}  // namespace malha
