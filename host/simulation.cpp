#include "host/simulation.h"

#include "host/base/stopwatch.h"
#include "host/model/footprint.h"
#include "host/results/checkpoint.h"
#include "host/results/expect.h"
#include "host/results/report.h"
#include "host/solver/solver.h"
#include "kernels/compute.h"

namespace malha {

struct Simulation::Parts {
  Model model;  // the solver refers to it
  std::unique_ptr<Solver> solver;
  RunTimes times;
  int threads = 1;
};

Simulation::Simulation(const Scene& scene, const SimulationOptions& options) : parts_(std::make_unique<Parts>()) {
  const bool serial = options.backend == Backend::Serial;
  parts_->threads = serial ? 1 : options.threads > 0 ? options.threads : available_threads();
  parts_->times.model_seconds = seconds([&] { parts_->model = build_model(scene); });
  parts_->times.solver_seconds = seconds([&] {
    parts_->solver = make_solver(parts_->model, serial ? 0 : parts_->threads, options.instructions, options.progress);
    keep_what_runs_need(parts_->model);
  });
}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

void Simulation::step() {
  parts_->times.step_seconds.push_back(seconds([this] { parts_->solver->step(); }));
}

void Simulation::move_pin(int particle, const Vec3& to) { parts_->solver->move_pin(particle, to); }

void Simulation::wake() { parts_->solver->wake(); }

double Simulation::time() const { return parts_->solver->time(); }
std::int64_t Simulation::steps() const { return parts_->solver->steps(); }
int Simulation::threads() const { return parts_->threads; }
std::vector<Vec3> Simulation::positions() const { return parts_->solver->positions(); }
std::vector<Vec3> Simulation::velocities() const { return parts_->solver->velocities(); }
Measures Simulation::measure() const { return parts_->solver->measure(); }
std::uint64_t Simulation::state_hash() const { return parts_->solver->state_hash(); }

std::vector<std::string> Simulation::unmet() const {
  return unmet_expectations(parts_->model.scene.expect, measure(), positions());
}

void Simulation::save_checkpoint(const std::string& path, std::int64_t frames) const {
  write_checkpoint(path, parts_->model, {parts_->solver->save(), frames});
}

std::int64_t Simulation::load_checkpoint(const std::string& path) {
  const Checkpoint checkpoint = read_checkpoint(path, parts_->model);
  parts_->solver->restore(checkpoint.state);
  return checkpoint.frames;
}

std::string Simulation::report(const std::string& status, const std::vector<std::string>& notes) const {
  return report_json(status, notes, parts_->model, *parts_->solver, parts_->threads, parts_->times);
}

const Model& Simulation::model() const { return parts_->model; }
const Solver& Simulation::solver() const { return *parts_->solver; }
const RunTimes& Simulation::times() const { return parts_->times; }

}  // namespace malha
