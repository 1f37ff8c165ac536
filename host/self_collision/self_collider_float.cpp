// SPDX-License-Identifier: Apache-2.0
#include "host/self_collision/self_collider.h"

namespace malha {

template class SelfCollider<OpenMP, float>;

}  // namespace malha
