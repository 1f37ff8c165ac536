// Instantiates the kernels on the device: what only a device compiler refuses is found without a GPU.
#include "kernels/constraints.h"
#include "kernels/contact.h"
#include "kernels/damping.h"
#include "kernels/integrate.h"
#include "kernels/measure.h"
#include "kernels/pressure.h"
#include "kernels/rest.h"
#include "kernels/visit.h"

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

template <class Kernel>
__global__ void launch_groups(Kernel kernel) {
  extern __shared__ double memory[];
  kernel(Group<Own>{int(blockIdx.x), -1, memory});
}

template <class... Kinds>
void instantiate_residuals(KindList<Kinds...>) {
  instantiate<MeasureResidual<Kinds, double[3]>...>();
}
template void instantiate_residuals(ConstraintKinds);

template <class R>
void instantiate_all() {
  launch_groups<<<1, 1>>>(Visit<R>{});
  instantiate<Predict<R>, Drag<R>, UpdateState<R>>();
  instantiate<SumMass<R, Consecutive>, SumSpin<R, Consecutive>, DampTowardsRigid<R>, MeasureMotion<R>>();
  instantiate<SixVolumes<R>, PressureGradient<R>, ApplyPressure<R>>();
  instantiate<ResolveContact<R>, Restitute<R>, CountContact<R>>();
}

template void instantiate_all<float>();
template void instantiate_all<double>();

}  // namespace malha
