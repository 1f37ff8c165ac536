// SPDX-License-Identifier: Apache-2.0
// What the rest of the host sees of a solver, whatever its method, executor and precision.
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
#include "malha/measures.h"
#include "malha/particle_handle.h"
#include "malha/substep_callback.h"
#include "malha/user_constraint.h"

namespace malha {

/// Of a scene that names sleep.
struct SleepStats {
  int particles = 0;  // asleep now
  double since = 0;   // s, if there are any
};

class Solver {
 public:
  virtual ~Solver() = default;
  /// Advances by the scene's dt. Throws Diverged naming step, particle and body. `after`: see SubstepCallback; may be
  /// empty.
  virtual void step(const SubstepCallback& after = {}) = 0;
  /// Runs the periodic divergence check now. Throws Diverged.
  virtual void check_divergence() = 0;
  virtual double time() const = 0;  // s
  virtual std::int64_t steps() const = 0;
  virtual std::vector<Vec3> positions() const = 0;   // m, in the user's order
  virtual std::vector<Vec3> velocities() const = 0;  // m/s
  virtual Measures measure() const = 0;
  /// The strains alone: a fraction of what measure() takes. Host memory is read, and the places of a device.
  virtual StrainSample strains() const = 0;
  virtual const std::vector<LengthRun>& lengths() const = 0;
  /// How many steps from sample to sample cost some hundredths of the steps at most; 0: there is nothing to sample. The
  /// same whatever the machine.
  virtual int steps_to_sample() const = 0;
  /// Of edges with triangles, of bodies that collide; counted by itself.
  virtual std::int64_t crossings() const = 0;
  virtual const SolverStats& facts() const = 0;
  /// Of Desbrun's filter, measured when asked; none: the method has no filter.
  virtual std::optional<FilterErrors> filter_errors() const { return std::nullopt; }
  virtual const std::array<double, kPassNames.size()>& pass_seconds() const = 0;  // per pass, since the start
  /// Of each level (facts().levels) since the start, within those of the passes.
  virtual std::vector<double> level_seconds() const { return {}; }
  /// Puts pinned particles (the user's numbers) elsewhere. Throws InputError for one that is not pinned: then none
  /// moves.
  virtual void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to) = 0;
  /// 1/kg, in the user's order: 0 where particles are held now.
  virtual std::vector<double> inverse_masses() const = 0;
  /// The model's gravity is another one from now on;
  virtual void change_gravity() = 0;
  /// or the velocity of its wind, which it has.
  virtual void change_wind() = 0;
  /// Adds the caller's own constraints (the user's numbers), once, before the first step.
  virtual void add_user_constraints(const std::vector<UserConstraint>& all) = 0;
  /// C of each constraint of one of them.
  virtual std::vector<double> values_of_user_constraint(std::size_t index) const = 0;
  /// Pulls or holds a particle (the user's number) from the next step on. Throws InputError for one that is pinned, and
  /// where nothing can be taken, or not be held.
  virtual void take(const ParticleHandle& what) = 0;
  virtual void release(int particle) = 0;
  virtual std::vector<ParticleHandle> taken() const = 0;
  virtual void wake() = 0;
  virtual std::optional<SleepStats> sleep() const = 0;
  /// Everything that the next step depends on, and a hash of positions and velocities in the user's order.
  virtual std::string save() const = 0;
  /// Lets go of what is taken. Throws InputError, which names `file`, for a state that is of another model or that no
  /// run can have left: then nothing has changed.
  virtual void restore(const std::string& state, const std::string& file = "checkpoint") = 0;
  virtual std::uint64_t state_hash() const = 0;
  /// Goes on after so many steps from these places (m) and velocities (m/s), in the user's order, without what contacts
  /// and sleep remember.
  virtual void set_state(std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) = 0;
  /// Whether an edge is longer than it can bear.
  virtual bool overstretched() { return false; }
  /// Continues from the state of a solver of the same scene before it tore further: `from` says which of its
  /// `particles` each particle was, `seconds` what its passes took.
  virtual void restore_after_split(const std::string& state, std::size_t particles, const std::vector<int>& from,
                                   const std::array<double, kPassNames.size()>& seconds) = 0;
};

/// The instruction sets that both this build and the CPU have, the narrowest first: "baseline", "avx2", "avx512".
std::vector<std::string> instruction_sets();

/// The model's method on `threads` OpenMP threads; with 1 or 0 no parallel region is opened. `instructions`: one of
/// instruction_sets(), or "" for the widest; throws InputError for another.
/// `progress`: of a set-up that takes long; may be empty.
std::unique_ptr<Solver> make_solver(const Model& model, int threads, const std::string& instructions = "",
                                    const ShowProgress& progress = {});

/// Throws InputError where this build or this machine has no CUDA device.
void require_cuda();
/// The same method on it; `threads` are the host's, for what it computes. `timed`: passes are, which waits after each.
std::unique_ptr<Solver> make_solver_on_cuda(const Model& model, int threads, const ShowProgress& progress = {},
                                            bool timed = false);

/// Of the device that it would run on.
struct DeviceStats {
  std::string name;
  double bytes_per_second = 0;  // read and written by a copy within its memory
};
/// Measured now. Throws InputError where there is none.
DeviceStats cuda_device();

}  // namespace malha
