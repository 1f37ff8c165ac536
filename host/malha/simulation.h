// SPDX-License-Identifier: Apache-2.0
// Public interface of malha: builds a simulation from a scene (host/malha/scene.h), steps it, and returns its state.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <memory_resource>
#include <string>
#include <vector>

#include "malha/error.h"
#include "malha/measures.h"
#include "malha/parallel_for.h"
#include "malha/particle_handle.h"
#include "malha/scene.h"
#include "malha/substep_callback.h"
#include "malha/user_constraint.h"

namespace malha {

/// The device that runs the kernels. The results have the same bits on all of them and on any number of threads. Cuda
/// is available in builds with CUDA only.
enum class Backend { OpenMP, Serial, Cuda };
inline const std::vector<std::string> kBackends{"openmp", "serial", "cuda"};  ///< names of the backends, in enum order
/// Returns the backend of this name. Throws InputError for a name that is not in kBackends.
Backend backend_named(const std::string& name);

struct SimulationOptions {
  /// Number of OpenMP threads. 0: as many as OpenMP offers (OMP_NUM_THREADS, or the cores), with `adaptive_threads`.
  int threads = 0;
  /// Steps run on all threads, or on one thread while other programs on the machine make that faster.
  bool adaptive_threads = false;
  /// Threads of the program, such as a pool of its own, instead of OpenMP's: see ParallelFor. `threads` is then the
  /// largest number of groups that a launch is divided into, and 0 the number of cores. The bits are those of OpenMP.
  ParallelFor parallel_for = {};
  /// Memory of the program, such as a pool, for what is laid out: the arrays of particles, constraints, contacts,
  /// self-collision, levels and filters, each aligned to 64 bytes; null: operator new, with large pages. It is asked
  /// by the thread that calls the simulation, by steps only where a list of contacts grows, and gets each array back at
  /// the latest when the simulation ends, which it must outlive. It may be another one for each simulation; one that
  /// simulations in several threads share must be safe for threads. Not from it come the model (std::vector: meshes,
  /// lists of constraints), the trees and triangles of environment meshes, and the results of calls. Cuda refuses it.
  std::pmr::memory_resource* memory = nullptr;
  Backend backend = Backend::OpenMP;
  /// Instruction set: "baseline", "avx2" or "avx512"; "": the widest that the CPU supports.
  std::string instructions = {};
  /// Machine whose fast memory bounds the size of the patches; `malha plan --help` lists the names. The bits of the
  /// results depend on it.
  std::string machine = "cpu";
  /// Cuda: measures the time of each pass, for which the host waits at the end of every pass. The other backends always
  /// measure it.
  bool timed_passes = false;
  /// Allows step(after), pull() and hold(). Levels and patches then keep some set-up data in memory.
  bool interactive = false;
  /// Constraints of the caller. They are slow, and act as long as the simulation lives.
  std::vector<UserConstraint> constraints = {};
  /// Called during a long set-up with what is being done and its progress in [0, 1], or -1 where that is unknown.
  std::function<void(const char* what, double part)> progress = {};
};

struct Model;     ///< host/model/model.h: the internal model, for other parts of malha
class Solver;     ///< host/solver/solver.h
struct RunTimes;  ///< host/report/report.h

/// Some calls lay the simulation out anew: the tears of step(), cut(), set_pins(), set_gravity() with levels, some
/// first calls of set_pose(), and load_checkpoint(), restore_state() and transfer_state_from() where the tears differ.
/// They make a new model and solver beside the present ones, which takes as long as the set-up did and the memory of
/// both, and swap them in. If one of them throws, or refuses a state, the simulation is as it was: its state is the
/// same, and all later steps have the same bits. step() has then advanced without its tears, and the next step() begins
/// with them.
class Simulation {
 public:
  /// Reads the meshes of the scene and builds the solver. Throws InputError for a scene that cannot be simulated, and
  /// OutOfMemory for one that needs more memory than is free.
  explicit Simulation(const Scene& scene, const SimulationOptions& options = {});
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Advances by the scene's dt. Throws Diverged when a particle is no longer finite, or when bodies move with more
  /// than 100 times the energy that was put in; after that only report() and set_positions() are meaningful. If the
  /// function of a user constraint throws, the state is restored to that before the step, and the exception is passed
  /// on.
  void step();

  /// Advances by one step and calls `after` at the end of each substep. The results have the same bits as those of
  /// step(); the speed differs. A sleeping scene has no substeps. Throws what step() throws, and InputError if
  /// `interactive` is not set.
  void step(const SubstepCallback& after);

  /// Runs the check for divergence now; step() runs it every 32 to 128 steps. Call it before results are used.
  /// Throws Diverged.
  void check_divergence();

  /// Moves a pinned particle to the point `to` (m) between two steps. Nothing is rebuilt or factored again. `particle`
  /// is an index into positions(). Throws InputError for a particle that is not pinned or that keyframes move.
  void move_pin(int particle, const Vec3& to);
  /// Moves several pinned particles, each to the point of the same index (m). Throws InputError as move_pin() does;
  /// then no particle has moved.
  void move_pins(const std::vector<int>& particles, const std::vector<Vec3>& to);

  /// Replaces the positions (m) or the velocities (m/s) of all particles between two steps; one entry for each
  /// particle, in the order of positions(). A pin stays where it is put and has the velocity 0, or that of its
  /// keyframes. Cached contacts and the time at rest are reset. After Diverged, set_positions() makes further steps
  /// possible: velocities that are not finite become 0. Throws InputError for another number of entries, and for
  /// numbers that are not finite or beyond 1e18.
  void set_positions(const std::vector<Vec3>& x);
  void set_velocities(const std::vector<Vec3>& v);

  /// Sets the force on each particle (N), in the order of positions(). It acts in every substep until others are set;
  /// an empty list: none. A vertex that tears keeps its force on the half that keeps its number. Checkpoints and saved
  /// states do not contain forces, and bodies on which one acts may gain any energy. May be called in the callback of
  /// step(after), for the next substeps. Throws InputError for another number of entries, and for numbers that are not
  /// finite or beyond 1e18.
  void set_forces(const std::vector<Vec3>& forces);

  /// Replaces the scene between two steps: masses, stiffness, compliance, moduli and all other settings may differ, and
  /// bodies and objects may be added and removed. A body that has the same name and number of particles as before keeps
  /// its positions, velocities, forces and handles, so that a small change of its settings causes no jump; all others
  /// start as in the scene. Contacts of what stays keep what they remember (how much nearer than the thickness a
  /// particle or a pair may stay), where the name, surface, thickness, sides and present place of an object, or the
  /// thickness of self-collision, are the same; other pairs that are too near keep the distance that they have now. The
  /// simulated time goes on, from the next whole step if dt differs, and a scene that sleeps wakes. Everything is laid
  /// out anew, as at the start. Bodies next to bodies that come or go keep their bits where the order of their
  /// particles and constraints does, and no filter (Desbrun's, or of bending) and no search of self-collision holds
  /// them all; otherwise rounding differs.
  ///
  /// A scene that differs in nothing but its name, duration, outputs and expectations changes nothing: the bits are
  /// those without the call, and nothing is laid out. Files of animations count as unchanged.
  ///
  /// Checkpoints and saved states of before belong to the other scene. Throws InputError for a scene that cannot be
  /// simulated from its start, for one that has torn, for bodies that are in objects where they are now or, with
  /// self-collision or edges, go through others, and for other bodies or numbers of particles in a simulation with
  /// constraints of the caller; then nothing has changed.
  void set_scene(const Scene& scene);
  /// The scene, with the poses, pins, gravity and wind that were set since: to keep these, give a changed copy of it to
  /// set_scene().
  const Scene& scene() const;

  /// Sets gravity (m/s^2) from the next step on. With levels, which depend on the weight, the layout is new.
  /// Checkpoints do not contain it: set it again before resuming. Throws InputError for numbers that are not finite or
  /// beyond 1e18.
  void set_gravity(const Vec3& gravity);

  /// Sets the velocity of the wind (m/s) from the next step on. Checkpoints do not contain it either. Throws InputError
  /// for a scene without wind, and for numbers that are not finite or beyond 1e18.
  void set_wind(const Vec3& velocity);

  /// Moves an object of the environment, by its name: during the next step it moves from where it is to `pose`, where
  /// it rests until the next call; in the callback of step(after) during the next substep. This replaces its "motion".
  /// Between, the translation is linear and the rotation takes the shortest way. What is attached to the object moves
  /// with it. The first motion of an object at rest lays the simulation out anew where bodies are attached to it, or
  /// where it has "edges" and others with "edges" rest. Checkpoints do not contain poses: set them again after
  /// resuming. Throws InputError for an unknown object, an axis of length zero, numbers that are not finite or beyond
  /// 1e18, and a first motion of that kind in a callback.
  void set_pose(const std::string& object, const RigidPose& pose);

  /// Moves the vertices of an object whose "animation" is "from_code": during the next step, or the next substep as
  /// above, each moves straight from where it is to its position (m, in the object's frame, which set_pose() moves),
  /// where it rests until the next call. One position for each vertex of the object's shape, in the numbering of its
  /// file. Checkpoints do not contain them, as poses. Throws InputError for an unknown object or one without that
  /// animation, for another number of positions, and for numbers that are not finite or beyond 1e18.
  void set_vertices(const std::string& object, const std::vector<Vec3>& positions);

  /// The particles that are pinned permanently and at rest, as indices into positions(), ascending. Pins with keyframes
  /// and pins with a release time are not among them.
  std::vector<int> pins() const;

  /// Replaces the set that pins() returns. A released particle gets its mass back, a new pin rests where it is. Pins
  /// with keyframes or a release time are not changed. A checkpoint or saved state can only be loaded with the pins
  /// that were set when it was made. Throws InputError for an index out of range, for a particle of a rigid attachment
  /// or of a pin with keyframes or a release time, and for a scene that has torn. A body may be pinned altogether.
  void set_pins(std::vector<int> particles);

  /// Drags a particle: from the next step on a spring of this compliance (m/N, 1e-12 to 1e12) pulls it to the point
  /// `to` (m). A further call moves that point. `particle` is an index into positions(); tearing may shift it, see
  /// handles(). Particles that the dragged one does not affect move with the same bits as without it, except through
  /// contact, sleep and Desbrun's "tolerance". Throws InputError for an index out of range, a pinned particle, another
  /// compliance, and if `interactive` is not set.
  void pull(int particle, const Vec3& to, double compliance);

  /// Holds a particle: it acts as if it were pinned, where it is, or at the point `to` (m), to which the next step
  /// moves it. A held vertex does not tear. Throws InputError as pull() does, and for solvers that are built for a
  /// fixed set of pins: Desbrun's method, and any with levels. There, pull() with a small compliance has nearly the
  /// same effect.
  void hold(int particle);
  void hold(int particle, const Vec3& to);

  /// Releases a particle that pull() or hold() moves; it keeps its velocity. Does nothing for any other particle.
  void release(int particle);

  /// The particles that pull() and hold() move now, in the order of the calls. When such a vertex tears, the handle
  /// stays with the particle that keeps its position in the order of positions(), and has its new index.
  std::vector<ParticleHandle> handles() const;

  /// Cuts bodies that have "tear" along the path of a knife. `edges` are the edges that it crosses, as particles {left,
  /// right} of the knife (indices into positions()). The vertices on one side are split as by tearing, so that the two
  /// ends of each edge no longer share a face or line. A vertex all of whose faces are crossed is not split. Positions
  /// and velocities do not change. Returns the number of vertices that were split; each adds a particle, the last of
  /// its body. Throws InputError for an index out of range, an edge between two bodies, and a body without "tear".
  int cut(const std::vector<Edge>& edges);

  /// Wakes a sleeping scene, for changes that the solver does not detect. Does nothing in a scene without "sleep".
  void wake();

  double time() const;         ///< simulated time, s
  std::int64_t steps() const;  ///< number of steps since the start of the scene, including those before a checkpoint
  int threads() const;         ///< number of threads that the solver uses

  /// Positions (m) and velocities (m/s) of all particles: the bodies in the scene's order, and each body's particles in
  /// the order of its mesh.
  std::vector<Vec3> positions() const;
  std::vector<Vec3> velocities() const;

  /// Writes positions (m), velocities (m/s) or unit normals of all particles, in the order of positions(), into memory
  /// of the caller: those of particle i are the three numbers from to[stride i] on. The memory has stride times the
  /// number of particles, and stride is 3 or more. Normals are means over faces, weighted by area; (0, 0, 0) where no
  /// face is. No call but the first one for normals allocates. Throws InputError for a smaller stride.
  void copy_positions(float* to, std::size_t stride = 3) const;
  void copy_positions(double* to, std::size_t stride = 3) const;
  void copy_velocities(float* to, std::size_t stride = 3) const;
  void copy_velocities(double* to, std::size_t stride = 3) const;
  void copy_normals(float* to, std::size_t stride = 3) const;
  void copy_normals(double* to, std::size_t stride = 3) const;

  /// Inverse masses (1/kg) in the order of positions(); 0 for particles that are pinned or held now.
  std::vector<double> inverse_masses() const;

  /// The values C of the constraints in options.constraints[index] in the present state, one for each constraint.
  /// Throws std::out_of_range for an index without constraints.
  std::vector<double> constraint_values(std::size_t index) const;

  /// The index into positions() of each vertex of the mesh of scene.bodies[body], in the numbering of its file (from 0,
  /// as in pins, messages and frames); -1 for a vertex that no face, line or tetrahedron uses. Welded vertices have the
  /// same index. The particles that tearing added follow. Throws std::out_of_range for a body that does not exist.
  std::vector<int> particles_of_vertices(std::size_t body) const;

  /// Measures of the state at the end of the last step.
  Measures measure() const;

  /// Counts the edges that cross triangles now. failed_expectations() and report() use the largest of these counts.
  /// Does nothing in a scene without "self_collision" and without objects with "edges".
  void count_crossings();

  /// Number of vertices that were torn or cut in two so far. Each added one particle, the last of its body.
  int tears() const;

  /// The expectations of the scene (its "expect") that the present state does not meet, one line of text for each. The
  /// crossings are the largest number that count_crossings() found.
  std::vector<std::string> failed_expectations() const;

  /// A hash of the bits of positions and velocities: equal runs have equal hashes.
  std::uint64_t state_hash() const;

  /// Writes everything that the next step depends on to a file, completely or not at all. `frames` is the number of
  /// frames that the caller has written by now; load_checkpoint() returns it. Throws std::runtime_error if the file
  /// cannot be written, and InputError for a state that is not finite.
  void save_checkpoint(const std::string& path, std::int64_t frames = 0) const;

  /// Continues from a checkpoint of the same scene with the same bits as the run that wrote it; duration, outputs and
  /// expectations may differ. Gravity and wind are not changed, and pins must be set as they were then. All handles are
  /// released. Returns the `frames` of save_checkpoint(). Throws InputError for another scene, another precision, or a
  /// damaged file.
  std::int64_t load_checkpoint(const std::string& path);

  /// Takes over the state of another simulation, for settings that change while a scene runs: its time, rounded up to a
  /// whole step, the positions and velocities of the bodies that have the same name and number of particles, and what
  /// contacts remember, as set_scene() does. Other bodies keep the state that they have here.
  void transfer_state_from(const Simulation& before);

  /// Everything that the next step depends on, as bytes, except handles, gravity, wind and pins.
  std::string save_state() const;

  /// Restores a state that save_state() returned for the same scene and precision, and releases all handles. The steps
  /// that follow have the same bits as after save_state(). Throws InputError for any other bytes.
  void restore_state(const std::string& state);

  /// The text of report.json: build, machine, sizes, times and measures. `status` is a word for how the run ended,
  /// `notes` are lines of text about it.
  std::string report(const std::string& status, const std::vector<std::string>& notes = {}) const;

  /// The model after release_setup_memory() (host/model/memory_estimate.h), and the solver. What lays the simulation
  /// out anew ends the references to both.
  const Model& model() const;
  const Solver& solver() const;
  const RunTimes& times() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace malha
