// What the rest of the host sees of a solver, whatever its method, executor and precision.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/measures.h"
#include "host/model/model.h"
#include "host/solver/batches.h"

namespace malha {

/// The passes of a step, for timings.
enum class Pass { Damping, Prediction, Collision, Projection, Pressure, Contact, State };
inline constexpr std::array<const char*, 7> kPassNames{"damping",  "prediction", "collision", "projection",
                                                       "pressure", "contact",    "state"};

struct SolverFacts {
  std::vector<SetFacts> sets;                            // in the order of projection
  double constraint_seconds = 0, collision_seconds = 0;  // of set-up
  std::size_t particle_bytes = 0, constraint_bytes = 0, collision_bytes = 0;
  std::int64_t projections_per_step = 0;  // single constraints, pressure counted once a body, contacts not
};

class Solver {
 public:
  virtual ~Solver() = default;
  /// Advances by the scene's dt. Throws Diverged naming step, particle and body.
  virtual void step() = 0;
  virtual double time() const = 0;  // s
  virtual std::int64_t steps() const = 0;
  virtual std::vector<Vec3> positions() const = 0;   // m, in the user's order
  virtual std::vector<Vec3> velocities() const = 0;  // m/s
  virtual Measures measure() const = 0;
  virtual const SolverFacts& facts() const = 0;
  virtual const std::array<double, kPassNames.size()>& pass_seconds() const = 0;  // per pass, since the start
  /// Everything that the next step depends on, and a hash of positions and velocities in the user's order.
  virtual std::string save() const = 0;
  virtual void restore(const std::string& state) = 0;  // throws InputError if it is of another model
  virtual std::uint64_t state_hash() const = 0;
};

/// The model's method on `threads` OpenMP threads, or on the Serial executor with 0.
std::unique_ptr<Solver> make_solver(const Model& model, int threads);

}  // namespace malha
