// SPDX-License-Identifier: Apache-2.0
// Interface of a solver, whatever its method, executor and precision.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/progress.h"
#include "host/measure/solver_stats.h"
#include "host/measure/strain.h"
#include "host/model/model.h"
#include "host/solver/step_plan.h"
#include "malha/measures.h"
#include "malha/particle_handle.h"
#include "malha/substep_callback.h"
#include "malha/user_constraint.h"

namespace malha {

/// Sleep of a scene that allows it.
struct SleepStats {
  int particles = 0;  // that are asleep now
  double since = 0;   // s, the time from which on they have been, if any are
};

/// A time in which an object moves.
struct NextMotion {
  double start, end;  // s
  bool in_step;       // it begins within a step
};

struct LayoutMap;  // host/environment/layout_map.h
template <class R>
struct State;  // host/solver/state.h

class Solver {
 public:
  virtual ~Solver() = default;
  /// Advances by the scene's dt. Throws Diverged, which names step, particle and body. `after`: see SubstepCallback;
  /// may be empty.
  virtual void step(const SubstepCallback& after = {}) = 0;
  /// Runs the periodic divergence check now. Throws Diverged.
  virtual void check_divergence() = 0;
  virtual double time() const = 0;  // s
  virtual std::int64_t steps() const = 0;
  virtual std::vector<Vec3> positions() const = 0;   // m, in the user's order
  virtual std::vector<Vec3> velocities() const = 0;  // m/s
  /// Writes the positions (m) or velocities (m/s) in the user's order: of particle i to the three numbers from
  /// to[stride i] on. Nothing is allocated on the host.
  virtual void copy_positions(float* to, std::size_t stride) const = 0;
  virtual void copy_positions(double* to, std::size_t stride) const = 0;
  virtual void copy_velocities(float* to, std::size_t stride) const = 0;
  virtual void copy_velocities(double* to, std::size_t stride) const = 0;
  virtual Measures measure() const = 0;
  /// The strains alone, for a fraction of the cost of measure(), until the next call. Downloads positions from a
  /// device.
  virtual const StrainSample& strains() const = 0;
  virtual const std::vector<LengthRun>& lengths() const = 0;
  /// Number of steps between two samples of strains such that sampling costs a few hundredths of the steps at most; 0:
  /// there is nothing to sample. It does not depend on the machine.
  virtual int steps_to_sample() const = 0;
  /// Number of intersections of edges with triangles, of bodies that collide.
  virtual std::int64_t crossings() const = 0;
  virtual const SolverStats& facts() const = 0;
  /// Tells how the last step ran; before the first one, and after constraints were added, how the next one will.
  virtual const StepPlan& step_plan() const = 0;
  /// Tells whether coarse levels are laid out, for any state of the pins.
  virtual bool has_levels() const = 0;
  /// Measures the errors of the filter of forces, or of bending; none: there is no filter.
  virtual std::optional<FilterErrors> filter_errors() const { return std::nullopt; }
  virtual const std::array<double, kPassNames.size()>& pass_seconds() const = 0;  // per pass, since the start
  /// Seconds of each level (facts().levels) since the start, which those of the passes include.
  virtual std::vector<double> level_seconds() const { return {}; }
  /// Moves pinned particles (user indices) to other positions, m. Throws InputError for one that is not pinned: then
  /// none moves.
  virtual void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) = 0;
  /// Present inverse masses, 1/kg, in the user's order: 0 for pinned particles.
  virtual std::vector<double> inverse_masses() const = 0;
  /// Must be called after the model's gravity has changed.
  virtual void change_gravity() = 0;
  /// Must be called after the velocity of the model's wind, which it has, has changed.
  virtual void change_wind() = 0;
  /// Sets the force on each particle (N, the user's order), which acts in every substep until others are set. An empty
  /// list: none.
  virtual void set_forces(const std::vector<Vec3>& forces) = 0;
  /// Returns the forces that were set, rounded to the precision; empty: none.
  virtual std::vector<Vec3> forces() const = 0;
  /// The motion that the program gives an object now: during the next step, or, in a callback, during the next substep.
  virtual NextMotion next_motion() const = 0;
  /// Must be called after the motion or the vertices of an environment object have changed.
  virtual void change_environment() = 0;
  /// Adds user constraints (user indices), once, before the first step.
  virtual void add_user_constraints(const std::vector<UserConstraint>& all) = 0;
  /// C of each constraint of one of those sets.
  virtual std::vector<double> values_of_user_constraint(std::size_t index) const = 0;
  /// Drags or holds a particle (user index) from the next step on. Throws InputError for one that is pinned, and if the
  /// simulation is not interactive or its method cannot hold particles.
  virtual void take(const ParticleHandle& what) = 0;
  virtual void release(int particle) = 0;
  virtual std::vector<ParticleHandle> taken() const = 0;
  virtual void wake() = 0;
  virtual std::optional<SleepStats> sleep() const = 0;
  /// Serialises everything that the next step depends on.
  virtual std::string save() const = 0;
  /// Restores a saved state, and releases all handles. Throws InputError, which names `file`, for a state of another
  /// model or one that no run can have saved: then nothing has changed.
  virtual void restore(const std::string& state, const std::string& file = "checkpoint") = 0;
  /// Hash of positions and velocities in the user's order.
  virtual std::uint64_t state_hash() const = 0;
  /// Sets the number of steps, positions (m) and velocities (m/s), in the user's order, and clears the state of
  /// contacts and sleep.
  virtual void set_state(std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) = 0;
  /// Tells whether an edge is beyond the length at which it tears.
  virtual bool overstretched() { return false; }
  /// The state with all that the next step depends on, in the solver's order; in single precision the same in double.
  virtual State<double> whole_state() const = 0;
  /// Continues from such a state of a solver with another layout, in any precision, and releases all handles. Contacts
  /// of what is in both layouts keep what they remember. `seconds`: those of its passes. Throws InputError for a state
  /// that is not finite: then nothing has changed.
  virtual void continue_from(const State<double>& before, const LayoutMap& map,
                             const std::array<double, kPassNames.size()>& seconds) = 0;
};

/// Instruction sets of both this build and the CPU, the narrowest first: "baseline", "avx2", "avx512".
std::vector<std::string> instruction_sets();

/// The model's method on `threads`; with one or none no parallel region is opened. `instructions`: one of
/// instruction_sets(), or "" for the widest; throws InputError for another.
/// `progress` is called during a long set-up; may be empty.
std::unique_ptr<Solver> make_solver(const Model& model, const OpenMP& threads, const std::string& instructions = "",
                                    const ShowProgress& progress = {});

/// Throws InputError where this build or this machine has no CUDA device.
void require_cuda();
/// The model's method on the CUDA device, with `threads` host threads. `timed`: passes are timed, and synchronised.
std::unique_ptr<Solver> make_solver_on_cuda(const Model& model, int threads, const ShowProgress& progress = {},
                                            bool timed = false);

/// The device that make_solver_on_cuda() uses.
struct DeviceStats {
  std::string name;
  double bytes_per_second = 0;  // bandwidth of a copy within its memory, reads and writes
};
/// Measures the device. Throws InputError if there is none.
DeviceStats cuda_device();

}  // namespace malha
