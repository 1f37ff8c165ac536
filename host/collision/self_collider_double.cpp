#include "host/collision/self_collider.h"

namespace malha {

template class SelfCollider<Serial, double>;
template class SelfCollider<OpenMP, double>;

}  // namespace malha
