// Instantiates the kernels on the device: what only a device compiler refuses is found without a GPU.
#include "kernels/constraints.h"
#include "kernels/contact.h"
#include "kernels/damping.h"
#include "kernels/integrate.h"
#include "kernels/measure.h"
#include "kernels/pressure.h"
#include "kernels/residual.h"

namespace malha {

template <class Kernel>
__global__ void launch(int n, Kernel kernel) {
  const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < n) kernel(i);
}

template <class... Kernels>
void instantiate() {
  (launch<<<1, 1>>>(0, Kernels{}), ...);
}

template <class R, class... Kinds>
void instantiate_constraints(KindList<Kinds...>) {
  instantiate<Project<Kinds, R, Update::Stiff>...>();
  instantiate<Project<Kinds, R, Update::Compliant>...>();
  instantiate<MeasureResidual<Kinds, R>...>();
}

template <class R>
void instantiate_all() {
  instantiate_constraints<R>(ConstraintKinds{});
  instantiate<Predict<R>, Drag<R>, UpdateState<R>>();
  instantiate<SumMass<R>, SumSpin<R>, DampTowardsRigid<R>, MeasureMotion<R>>();
  instantiate<SixVolumes<R>, PressureGradient<R>, ApplyPressure<R>>();
  instantiate<ResolveContact<R>, Restitute<R>>();
}

template void instantiate_all<float>();
template void instantiate_all<double>();

}  // namespace malha
