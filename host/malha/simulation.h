// SPDX-License-Identifier: Apache-2.0
// malha's public interface: a scene is loaded (host/malha/scene.h), simulated step by step, and looked at.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "malha/error.h"
#include "malha/measures.h"
#include "malha/particle_handle.h"
#include "malha/scene.h"
#include "malha/substep_callback.h"
#include "malha/user_constraint.h"

namespace malha {

/// Where the kernels run. The results are the same bits on each, and on any number of threads. Cuda: builds that have
/// it.
enum class Backend { OpenMP, Serial, Cuda };
inline const std::vector<std::string> kBackends{"openmp", "serial", "cuda"};  ///< their names, in this order
/// Throws InputError for what is none of them.
Backend backend_named(const std::string& name);

struct SimulationOptions {
  int threads = 0;  ///< OpenMP: 0 means as many as OpenMP offers (OMP_NUM_THREADS, or the cores), at most
  bool adaptive_threads =
      false;  ///< steps run on all threads, or on one while other programs make that faster. So always for 0
  Backend backend = Backend::OpenMP;
  std::string instructions = {};  ///< "": the widest that the CPU has; or "baseline", "avx2", "avx512"
  std::string machine = "cpu";    ///< what patches are cut for: malha plan --help lists them all. Bits depend on it
  bool timed_passes = false;      ///< Cuda: times of passes, for which every one of them is waited for; else always
  bool interactive = false;       ///< allows pull() and hold(). Costs memory where levels or patches keep some
  std::vector<UserConstraint> constraints = {};  ///< user constraints: slow, and for as long as the simulation lives
  // Of a set-up that takes long; part in [0, 1], or -1 where what begins does not know how far it is.
  std::function<void(const char* what, double part)> progress = {};
};

struct Model;     ///< host/model/model.h, for the parts of malha that look closer
class Solver;     ///< host/solver/solver.h
struct RunTimes;  ///< host/report/report.h

class Simulation {
 public:
  /// Reads the scene's meshes and lays everything out. Throws InputError for what cannot be simulated.
  explicit Simulation(const Scene& scene, const SimulationOptions& options = {});
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Advances by the scene's dt. Throws Diverged when a particle is no longer finite, or when bodies move with over 100
  /// times the energy that anything gave them: nothing but report() makes sense afterwards. What a constraint of the
  /// caller's own throws leaves everything as it was before the step.
  void step();

  /// A step that can be looked at after each of its substeps: the same bits as step(), not the same speed. A scene that
  /// sleeps has no substeps. Throws InputError where `interactive` is not set.
  void step(const SubstepCallback& after);

  /// Runs the check for divergence now, which step() runs every 32 steps. Call it before results are used. Throws
  /// Diverged.
  void check_divergence();

  /// Puts a pinned particle elsewhere (m) between two steps; nothing is laid out or factored anew. `particle`: as in
  /// positions(). Throws InputError for one that is not pinned, or that keyframes move.
  void move_pin(int particle, const Vec3& to);
  /// The same of several, all of them or none.
  void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to);

  /// Puts all particles elsewhere (m), or gives them other velocities (m/s), between two steps; in the order of
  /// positions(). Pins stay where they are put, and keep the velocity 0, or that of their keyframes. What contacts and
  /// sleep remember is forgotten. After Diverged new positions let it go on: velocities that are not finite are then 0.
  /// Throws InputError for another number of them, and for what is no number or beyond 1e18.
  void set_positions(const std::vector<Vec3>& x);
  void set_velocities(const std::vector<Vec3>& v);

  /// Gravity (m/s^2) from now on. Where levels are used, which are laid out for a weight, all is laid out anew.
  /// Not stored in checkpoints; set it again before resuming.
  void set_gravity(const Vec3& gravity);

  /// The velocity of the wind (m/s) from now on; checkpoints likewise. Throws InputError for a scene without wind.
  void set_wind(const Vec3& velocity);

  /// The particles that pins hold for good where they are, ascending. Pins on keyframes, and those that are released
  /// some time, are not among them.
  std::vector<int> pins() const;

  /// These are the pins from now on. What is released has its mass again, what is new rests where it is. All is laid
  /// out anew, which takes as long as the set-up did. Pins on keyframes or with a release stay as they are. A
  /// checkpoint or state goes with the pins that were set when it was made. Throws InputError, and leaves everything as
  /// it was, for a particle that is not there or that such a pin or a rigid attachment has or had, a body that
  /// is pinned altogether, and a scene that has torn.
  void set_pins(std::vector<int> particles);

  /// Drags a particle: from the next step on a spring of this compliance (m/N, 1e-12 to 1e12) pulls it to a point (m).
  /// Another call changes the point. `particle`: as in positions(), whose numbers tearing may shift: see handles().
  /// Other bodies keep their bits, except by contact, sleep, and Desbrun's "tolerance".
  /// Throws InputError for a particle that is not there or that is pinned, and where `interactive` is not set.
  void pull(int particle, const Vec3& to, double compliance);

  /// Holds a particle as if it were pinned, where it is, or at a point (m) to which the next step moves it.
  /// A vertex that is held does not tear. Throws InputError as pull() does, and for solvers that must know beforehand
  /// what is pinned: Desbrun's method, and one with levels. There a stiff spring is as good.
  void hold(int particle);
  void hold(int particle, const Vec3& to);

  /// Releases a particle that pull() or hold() has: it keeps its velocity. Other particles are not affected.
  void release(int particle);

  /// The handles of pull() and hold(), in the order of the calls. When a vertex tears, the particle that keeps its
  /// index in positions() keeps the handle.
  std::vector<ParticleHandle> handles() const;

  /// Cuts bodies that name "tear" along a knife's way. `edges`: those that it crosses, as particles {left, right} of
  /// the knife. Vertices on one side split as where a mesh tears, so that the two ends of an edge share no face or line
  /// any more. A vertex with nothing but crossed faces around it stays with them. Places and velocities stay. Returns
  /// how many vertices were split: each is one more particle, the last of its body. Throws InputError for a particle
  /// that is not there, an edge from one body to another, and a body without "tear": then nothing has changed.
  int cut(const std::vector<Edge>& edges);

  /// Ends the scene's sleep, if it has a "sleep" and sleeps: for what is changed from outside.
  void wake();

  double time() const;         ///< s
  std::int64_t steps() const;  ///< since the start of the scene, across resumed runs
  int threads() const;

  /// All bodies one after the other, in the scene's order and each in its mesh's order; m and m/s.
  std::vector<Vec3> positions() const;
  std::vector<Vec3> velocities() const;

  /// Inverse masses, 1/kg, in the same order: 0 for particles that a pin or hold() has now.
  std::vector<double> inverse_masses() const;

  /// C of each constraint of options.constraints[index] in the present state.
  std::vector<double> constraint_values(std::size_t index) const;

  /// The particle in positions() that each vertex of the mesh of scene.bodies[body] is, by the vertices' numbers in its
  /// file (from 0, as in pins, messages and frames). -1: nothing uses the vertex; welded ones are one particle. After
  /// them come the particles that tearing added. Throws std::out_of_range for a body that is not there.
  std::vector<int> particles_of_vertices(std::size_t body) const;

  /// The state at the end of the last step.
  Measures measure() const;

  /// Counts what crosses now; failed_expectations() and report() know the most that was found. Nothing where nothing
  /// could cross.
  void count_crossings();

  /// Vertices that have been torn or cut in two so far. Each is one more particle, the last of its body in positions().
  int tears() const;

  /// The expectations of the scene (its "expect") that the state does not meet, a line each; of crossings the most that
  /// were counted.
  std::vector<std::string> failed_expectations() const;

  /// A hash of the bits of positions and velocities: equal runs have equal hashes.
  std::uint64_t state_hash() const;

  /// Writes everything that the next step depends on, whole or not at all. Throws std::runtime_error (disk), and
  /// InputError for a state that is not finite.
  /// `frames`: how many a caller that writes frames has written by now; load_checkpoint gives the number back.
  void save_checkpoint(const std::string& path, std::int64_t frames = 0) const;

  /// Continues from a checkpoint of the same scene with the very same bits; duration, outputs and expectations may
  /// differ. Gravity and wind are those of now, and pins must be set as they were then. Lets go of what is taken by
  /// hand. Throws InputError for another scene, precision or a damaged file, and leaves the state as it was.
  std::int64_t load_checkpoint(const std::string& path);

  /// Goes on where another simulation is: at its time, to the next whole step, with the places and velocities of its
  /// bodies that have the same name and as many particles; other bodies are as at the start of this scene. For settings
  /// that change while a scene runs. What contacts remember is not taken over: the bits are those of no single run.
  void transfer_state_from(const Simulation& before);

  /// Everything that the next step depends on, as bytes, except handles, gravity, wind and pins.
  std::string save_state() const;

  /// Restores a save_state() of the same scene and precision, and releases all handles: the same bits follow as did
  /// then. Throws InputError for other bytes, and leaves everything as it was.
  void restore_state(const std::string& state);

  /// report.json: build, machine, sizes, times and the measures. `status` is a word for how the run ended, `notes` are
  /// lines about it.
  std::string report(const std::string& status, const std::vector<std::string>& notes = {}) const;

  const Model& model() const;  ///< what is left of it, see host/model/memory_estimate.h
  const Solver& solver() const;
  const RunTimes& times() const;

 private:
  struct Parts;
  void rebuild(const Scene& scene, const std::optional<std::vector<int>>& pins = std::nullopt);
  std::unique_ptr<Parts> parts_;
};

}  // namespace malha
