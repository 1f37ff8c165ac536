// What the rest of the host sees of a solver, whatever its method, executor and precision.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/after_substep.h"
#include "host/collision/contact_facts.h"
#include "host/collision/edge_facts.h"
#include "host/collision/self_facts.h"
#include "host/filter/filter_facts.h"
#include "host/measures.h"
#include "host/model/model.h"
#include "host/own_constraint.h"
#include "host/solver/strain.h"
#include "host/taken.h"

namespace malha {

/// The passes of a step, for timings. Visits: prediction, projection and state in one, where nothing lies between.
/// Forces, filter and correction (of free bodies' momenta) are Desbrun's.
/// Pins are those that move. ByCaller: constraints of the caller's own.
enum class Pass {
  Pins,
  Damping,
  Air,
  Forces,
  Filter,
  Correction,
  Prediction,
  Levels,
  Collision,
  Projection,
  Pressure,
  LongRange,
  Attachments,
  Contact,
  SelfCollision,
  State,
  Visits,
  Tearing,
  Sleep,
  Edges,
  ByCaller
};
inline constexpr std::array<const char*, 21> kPassNames{
    "pins",           "damping",   "air",        "forces",   "filter",     "correction",  "prediction",
    "levels",         "collision", "projection", "pressure", "long_range", "attachments", "contact",
    "self_collision", "state",     "visits",     "tearing",  "sleep",      "edges",       "own"};

/// What a person may want to know of a constraint set.
struct SetFacts {
  std::string type;
  int constraints = 0;
  int in_runs = 0;       // read and written as whole vectors
  int most_batches = 0;  // of a patch: its colours and runs
  std::size_t bytes = 0;
};

struct PatchFacts {
  int patches = 0;
  int phases = 0;                // patches of a phase are visited at once
  int columns = 0;               // patches laid out for runs
  int shared = 0;                // particles that more than one patch visits
  int most_slots = 0;            // of fast memory, in the largest patch: its particles and what pads them
  std::size_t memory_bytes = 0;  // of fast memory that a visit asks for
  std::size_t bytes = 0;
  double plan_seconds = 0;  // of set-up
};

/// Of a level (host/model/levels.h).
struct LevelFacts {
  int particles = 0, constraints = 0;
  PatchFacts patches;
};

/// Of constraints of the caller's own.
struct OwnFacts {
  std::string name;
  int constraints = 0, particles = 0, batches = 0;  // particles: of each constraint
};

struct SolverFacts {
  std::string instructions;  // of the kernels over packs
  PatchFacts patches;
  bool fused = false;              // prediction and state happen in the visits to the patches
  bool whole_steps = false;        // all substeps of a step in one parallel region
  bool flies = false;              // both, in steps in which nothing can come near the environment
  std::vector<SetFacts> sets;      // in the order of projection
  std::vector<LevelFacts> levels;  // the finest first
  int levels_every = 1;            // substeps
  std::size_t level_bytes = 0;
  int level_layouts = 0;                                 // one more for each set of pins that lets go
  double level_seconds = 0;                              // of set-up
  std::optional<FilterFacts> filter;                     // Desbrun's
  std::optional<SelfFacts> self;                         // of self-collision
  std::optional<ContactFacts> contact;                   // with the environment
  std::optional<EdgeFacts> edges;                        // with its edges and corners
  std::vector<OwnFacts> own;                             // constraints of the caller's own
  int free_bodies = 0;                                   // of Desbrun's, whose momentum is corrected
  bool corrects = false;                                 // their angular momentum too
  std::size_t spring_bytes = 0;                          // of their ends, stiffness and rest lengths
  std::size_t force_launches = 0;                        // of a sum of Desbrun's forces
  std::size_t pressure_launches = 0;                     // of one projection of all pressures
  std::size_t pressure_starts = 0;                       // launches of theirs where a substep begins
  double colour_seconds = 0;                             // of set-up: phases of patches, runs, colours
  double layout_seconds = 0;                             // particles and constraints laid out
  double constraint_seconds = 0, collision_seconds = 0;  // colours and layout of constraints; environment meshes
  std::size_t long_range_bytes = 0, air_bytes = 0;       // of attachments; of the faces in the air
  int long_range = 0, attachments = 0;                   // particles that hang on pins, and on how many in all
  int air_particles = 0;                                 // that have faces in the air
  std::size_t particle_bytes = 0, constraint_bytes = 0, collision_bytes = 0;
  // Single constraints, those of batches there and back; pressure counted once a body, contacts not.
  std::int64_t projections_per_step = 0;
};

/// Of a scene that names sleep.
struct SleepFacts {
  int particles = 0;  // asleep now
  double since = 0;   // s, if there are any
};

class Solver {
 public:
  virtual ~Solver() = default;
  /// Advances by the scene's dt. Throws Diverged naming step, particle and body. `after`: see AfterSubstep; may be
  /// empty.
  virtual void step(const AfterSubstep& after = {}) = 0;
  /// Looks for what step() looks for every some steps. Throws Diverged.
  virtual void check() = 0;
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
  virtual const SolverFacts& facts() const = 0;
  /// Of Desbrun's filter, measured when asked; none: the method has no filter.
  virtual std::optional<FilterErrors> filter_errors() const { return std::nullopt; }
  virtual const std::array<double, kPassNames.size()>& pass_seconds() const = 0;  // per pass, since the start
  /// Of each level (facts().levels) since the start, within those of the passes.
  virtual std::vector<double> seconds_of_levels() const { return {}; }
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
  virtual void constrain(const std::vector<OwnConstraint>& all) = 0;
  /// C of each constraint of one of them.
  virtual std::vector<double> values_of_own(std::size_t index) const = 0;
  /// Pulls or holds a particle (the user's number) from the next step on. Throws InputError for one that is pinned, and
  /// where nothing can be taken, or not be held.
  virtual void take(const Taken& what) = 0;
  virtual void let_go(int particle) = 0;
  virtual std::vector<Taken> taken() const = 0;
  virtual void wake() = 0;
  virtual std::optional<SleepFacts> sleep() const = 0;
  /// Everything that the next step depends on, and a hash of positions and velocities in the user's order.
  virtual std::string save() const = 0;
  /// Lets go of what is taken. Throws InputError, which names `file`, for a state that is of another model or that no
  /// run can have left: then nothing has changed.
  virtual void restore(const std::string& state, const std::string& file = "checkpoint") = 0;
  virtual std::uint64_t state_hash() const = 0;
  /// Goes on after so many steps from these places (m) and velocities (m/s), in the user's order, without what contacts
  /// and sleep remember.
  virtual void place(std::int64_t steps, const std::vector<Vec3>& x, const std::vector<Vec3>& v) = 0;
  /// Whether an edge is longer than it can bear.
  virtual bool overstretched() { return false; }
  /// Continues from the state of a solver of the same scene before it tore further: `from` says which of its
  /// `particles` each particle was, `seconds` what its passes took.
  virtual void adopt(const std::string& state, std::size_t particles, const std::vector<int>& from,
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
struct DeviceFacts {
  std::string name;
  double bytes_per_second = 0;  // read and written by a copy within its memory
};
/// Measured now. Throws InputError where there is none.
DeviceFacts cuda_device();

}  // namespace malha
