// SPDX-License-Identifier: Apache-2.0
// Instantiates the kernels for the device, so that what only a device compiler refuses is found without a GPU.
#include "host/solver/cuda.cuh"
#include "kernels/attachments/attachment.h"
#include "kernels/attachments/long_range.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/environment/broad_phase.h"
#include "kernels/environment/clearance.h"
#include "kernels/environment/contact.h"
#include "kernels/environment/deforming_edge.h"
#include "kernels/environment/edge_detection.h"
#include "kernels/environment/edge_truncate.h"
#include "kernels/environment/point_triangle_batch.h"
#include "kernels/environment/shape_guards.h"
#include "kernels/environment/triangle_octree.h"
#include "kernels/filter/corrector.h"
#include "kernels/filter/dense_filter.h"
#include "kernels/filter/front.h"
#include "kernels/filter/sparse_filter.h"
#include "kernels/filter/springs.h"
#include "kernels/forces/air.h"
#include "kernels/forces/integrate.h"
#include "kernels/forces/momenta.h"
#include "kernels/forces/pressure.h"
#include "kernels/forces/sleep.h"
#include "kernels/measure/energies.h"
#include "kernels/measure/motion_energy.h"
#include "kernels/measure/over_elongation.h"
#include "kernels/multilevel/solve_coarse_patch.h"
#include "kernels/patch/solve_patch.h"
#include "kernels/projection/rest.h"
#include "kernels/projection/user_constraint.h"
#include "kernels/self_collision/broad_phase_cooperative.h"
#include "kernels/self_collision/kinematic_push.h"
#include "kernels/self_collision/rigid_sums.h"
#include "kernels/self_collision/solve_contacts.h"
#include "kernels/self_collision/swept_bounds.h"

namespace malha {

template <class... Kernels>
void instantiate() {
  (launch_items<<<1, 1>>>(0, Kernels{}), ...);
}

template <class Kernel>
void launch_one(const Kernel& kernel) {
  if constexpr (kShared<Kernel>)
    launch_shared<<<1, 1>>>(0, nullptr, 0, kernel);
  else
    launch_single_threads<<<1, 1>>>(0, 0, nullptr, 0, kernel);
}

template <class... Kernels>
void instantiate_groups() {
  (launch_one(Kernels{}), ...);
}

template <class... Kinds>
void instantiate_residuals(KindList<Kinds...>) {
  instantiate<MeasureResidual<Kinds, double[3]>...>();
}
template void instantiate_residuals(ConstraintKinds);
template void
instantiate<MeasureVolume<double[3]>, MeasureEnergy<NeoHookean, double[3]>, MeasureEnergy<Membrane, double[3]>,
            MeasureEnergy<OrthotropicMembrane, double[3]>, MeasureEnergy<OrthotropicPlate, double[3]>>();

template <class R>
void instantiate_filters() {
  using Io = FilterIo<R>;
  instantiate_groups<SumForces<R, ExplicitForces<R>, false>, SumForces<R, MissingForces<R>, true>>();
  instantiate<ComputeTargets<R, Plate::Stencil, Plate::particles>, ComputeTargets<R, IsometricBending::Stencil, 4>,
              ComputeTargets<R, OrthotropicMembrane::Stencil, 3>>();
  instantiate_groups<ForwardTask<R, Io>, ForwardTop<R>, BackwardTop<R>, SolveRootSmall<R, true>,
                     SolveRootSmall<R, false>, BackwardTask<R, Io>>();
  instantiate_groups<Pieces<SumTop<R, Io>>, Pieces<ScatterRoot<R, Io>>, Pieces<GatherTop<R>>, Pieces<StoreRoot<R>>>();
  instantiate_groups<MultiplyDense<R, R>, MultiplyDense<short, R>>();
  instantiate<GatherDense<R, R, Io>, SumDense<short, R, Io>, EliminateFront<R, NativeIsa>>();
  instantiate<SpringRows<R>, FilteredRows<R>, FilteredMotion<R>, RemoveRigid<R>>();
  instantiate<MeasureExcess<R, Points<R>>, MeasureExcess<R, Displaced<R>>, MeasureSpring<double[3], int[2]>>();
}
template void instantiate_filters<float>();
template void instantiate_filters<double>();

template <class R>
void instantiate_all() {
  instantiate_groups<SolvePatch<R>, SolveCoarsePatch<R>, Restrict<R>, Prolongate<R>, Pieces<SumPartialRestrictions<R>>,
                     BroadPhaseTest<R>, MeasureClearance<R>>();
  instantiate_groups<DetectShapeContacts<R>, SolveShapeContacts<R>, SolveShapeContacts<R, true>,
                     RestituteShapeContacts<R>, RestituteShapeContacts<R, true>, FindOverlaps<R>, ClampAtShapes<R>,
                     CancelMotionIntoShapes<R>, MeasureShapeClearance<R>>();
  instantiate<CountShapeContacts<R>, MeasureDepthInShapes<R>>();
  instantiate<ReconstructPrevious<R>, CommitClamped<R>, MeasureRuns<R>, RefineMassShares<R>, StartLocal<R>,
              MoveLocal<R>>();
  instantiate<FindEdgePairs<R, false>, FindEdgePairs<R, true>, BuildEdgeContacts<R>, ListContactEnds<R>>();
  instantiate<FindEdgePairs<R, false, true>, FindEdgePairs<R, true, true>,
              BuildEdgeContacts<R, EvaluateDeformingCandidate<R>>, SolveContactsJacobi<R, DeformingFriction<R>>,
              SolveContactsJacobi<R, DeformingFriction<R, true>>, RefitBoxNodes<R>, FindMeshCrossings<R>,
              LeaveOutCrossing<R>, ProjectOntoPlanes<R, SetFromLocal<R>>>();
  instantiate_groups<MeasureMomenta<R, R, false, false>, MeasureMomenta<R, R, false, true>,
                     MeasureMomenta<R, R, true, false>, MeasureMomenta<R, double, false, true>, StoreMomenta,
                     AddRigidMotion<R>, DampTowardsRigid<R>>();
  instantiate<ComputeMomentumCorrection<R>, ComputeRigidMotion<R>, ComputeMeanMotion, SumTorque<R>,
              ComputeAngularAcceleration>();
  instantiate<Predict<R>, Drag<R>, UpdateState<R>, AdvanceAll<R>, SetOrigins<R>>();
  instantiate<SumMass<R>, MeasureMotion<R>>();
  instantiate<EnclosedVolume<Points<R>>, EnclosedVolume<Displaced<R>>, PressureGradient<R>, MeasureInertia<R>,
              SumAlongPressure<R>, StorePressureForce<R>, ApplyFilteredPressure<R>, ApplyPressure<R>>();
  instantiate<ReduceRun<Largest, MeasureTetherExcess<R>>, LimitTethers<R>, FacesInAir<R>, ApplyWindForces<R>,
              MeasureSpeed<R>, MeasureBounds<R>, ClearVelocity<R>>();
  instantiate<MoveToTarget<R>, ArriveAtTarget<R>, SetInverseMass<R>, SolveAttachment<R>, MeasureAttachment<R>,
              GatherUserParticles<R, Points<R>>, GatherUserParticles<R, Displaced<R>>, ScatterUserParticles<R>>();
  instantiate<ResolveContact<R>, ResolveContact<R, true>, ApplyRestitution<R>, ApplyRestitution<R, true>,
              CountContact<R>, InvalidateContacts<R>>();
  instantiate<ComputeParticleBounds<R>, CheckCandidateBounds<R>, InitCandidateSearch<R>,
              CountOverlappingCandidates<R>>();
  instantiate<EstimateMassShares<R>, SplitMasses<R>, SolveContactsJacobi<R, ObjectFriction<R>>,
              SolveContactsJacobi<R, ObjectFriction<R, true>>, ApplyImpulses<R, TurnToWorld>, CountPushing<R>>();
  instantiate<FindEdgeViolations<R>, TruncateParticles<R, SetFromLocal<R>>, SumTruncation<R>, SumTruncatedMotion<R>,
              AddRigidCorrection<R>, SaveMotion<R>, ComputeTruncationChange<R>, RemoveUndoneLift<R>, LimitSpeed<R>,
              CopyPoints<R>, CopyPoints<R, Displaced<R>>, CopyPoints<R, FromOrigin<R>>, CountFixed<R>,
              MarkPushing<R>>();
  instantiate<ComputeDisplacements<R>, ApplyDisplacements<R>, ClampToSweptBounds<R>, InitSweptBounds<R>,
              ComputeSweptAabbs<R>>();
  instantiate<RefitLeaves<R>, RefitLevel<R>, CountPushes<R>, SumViolations<R>, TruncateDisplacements<R>>();
  instantiate_groups<CheckSweptBounds<R>, FindCandidatesCooperatively<R>, NarrowPhase<R>,
                     SolveContacts<R, SelfFriction::None>, SolveContacts<R, SelfFriction::Same>,
                     SolveContacts<R, SelfFriction::Mapped>, FindViolations<R>, MarkViolating<R>, ComputeTruncation<R>,
                     PushByKinematic<R>, MoveWithKinematic<R>>();
}

template void instantiate<CountDigits, PlaceDigits, MoveByDigit, FindBegins, SumPart, SumParts, SumBefore,
                          StartPressure, PushPressure>();

template void instantiate_all<float>();
template void instantiate_all<double>();

}  // namespace malha
