#include "host/collision/self_collider.h"

namespace malha {

template class SelfCollider<OpenMP, float>;

}  // namespace malha
