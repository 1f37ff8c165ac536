#include "tools/bench/self.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/shown.h"
#include "host/simulation.h"
#include "host/solver/solver.h"
#include "tools/bench/counts.h"
#include "tools/bench/facts.h"
#include "tools/bench/machine.h"
#include "tools/bench/output.h"
#include "tools/bench/status.h"
#include "tools/bench/turns.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kLayers = 4, kWarmUp = 2;  // sheets; steps
constexpr int kTogether = 500'000;       // particles: beyond, two lines need more memory than many machines have

/// Layers a little nearer than the thickness, 0.4 of a cell's side, that slide over each other and weigh on the lowest,
/// which is pinned.
Scene stack(int n) {
  const double side = 0.02, thickness = 0.008;
  const int cells = std::max(1, static_cast<int>(std::lround(std::sqrt(double(n) / kLayers))) - 1);
  Scene scene;
  scene.name = "stack";
  scene.gravity = {0, -9.81, 0};
  scene.self_collision = SelfCollision{thickness, 0.3, {}};
  for (int layer = 0; layer < kLayers; ++layer) {
    BodySpec body;
    body.name = "layer " + std::to_string(layer);
    body.shape = GridShape{{side * cells, side * cells}, {cells, cells}};
    body.density = 0.2;
    body.transform.translate = {0.3 * side * layer, 0.95 * thickness * layer, 0.4 * side * layer};
    if (layer == 0) body.pins = {BoxPin{{-1, -1, -1}, {side * (cells - 0.5), 1, side * (cells + 1)}}};
    body.velocity = {layer % 2 == 0 ? 0.2 : -0.2, 0, 0};
    ConstraintSpec distance;
    distance.type = "distance";
    distance.on = {"edges", "shear"};
    body.constraints = {distance};
    scene.bodies.push_back(body);
  }
  return scene;
}

struct Line {
  Simulation simulation;
  int threads;
  std::vector<double> collision, whole = {};  // ns a particle and substep, a number a turn
};

/// One turn: at least `enough` seconds of steps.
void take_turn(Line& line, double enough) {
  constexpr int pass = static_cast<int>(Pass::SelfCollision);
  const Solver& solver = line.simulation.solver();
  const double before = solver.pass_seconds()[pass];
  const std::int64_t first = line.simulation.steps();
  const double step = seconds_each([&] { line.simulation.step(); }, enough);
  const double per = 1e9 / (static_cast<double>(line.simulation.model().scene.solver.substeps) *
                            line.simulation.model().count());  // of a step
  const auto steps = static_cast<double>(line.simulation.steps() - first);
  line.collision.push_back((solver.pass_seconds()[pass] - before) / steps * per);
  line.whole.push_back(step * per);
}

Json row_of(const Line& line) {
  const Measures m = line.simulation.measure();
  const SolverFacts& facts = line.simulation.solver().facts();
  const double particles = line.simulation.model().count();
  return {{"particles", line.simulation.model().count()},
          {"threads", line.threads},
          {"self_collision_ns_per_particle_and_substep", median(line.collision)},
          {"step_ns_per_particle_and_substep", median(line.whole)},
          {"self_contacts_per_particle", m.self_contacts / particles},
          {"pairs_per_particle", static_cast<double>(facts.self->pairs) / particles},
          {"phases", facts.self->phases},
          {"bytes_per_particle", static_cast<double>(facts.collision_bytes) / particles},
          {"substeps_with_a_search",
           static_cast<double>(facts.self->searches) /
               (static_cast<double>(line.simulation.steps()) * line.simulation.model().scene.solver.substeps)},
          {"substeps_held_apart", facts.self->held},
          {"crossings", m.crossings},
          {"state_hash_after_warm_up", ""}};
}

std::string printed(const Json& row) {
  return formatted("%10d %8d %14.0f %14.0f %12.2f %12.0f %10.2f %10d\n", row["particles"].get<int>(),
                   row["threads"].get<int>(), row["self_collision_ns_per_particle_and_substep"].get<double>(),
                   row["step_ns_per_particle_and_substep"].get<double>(),
                   row["self_contacts_per_particle"].get<double>(), row["bytes_per_particle"].get<double>(),
                   row["substeps_with_a_search"].get<double>(), row["crossings"].get<int>());
}

}  // namespace

void run_self(const SelfOptions& options) {
  const std::vector<int> given = sorted(options.n), threads = thread_counts(options.threads);
  const std::vector<int> cases = given.empty() ? std::vector{10'000, 100'000, 1'000'000} : given;
  const Files files(options.out, "self", options.json);
  files.prepare();
  Status status;
  Printer print;
  const Json facts = machine_facts(threads);
  print(formatted(
            "%d sheets, 0.95 of the thickness apart, lie and slide on each other; float, 10 substeps of 1/600 s, %d "
            "steps of warm-up,\nthen %d x %g s a line, taking turns (over 500,000 particles: in turn); medians of ns a "
            "particle and substep.\n",
            kLayers, kWarmUp, options.repeats, options.seconds) +
        machine_lines(facts, "") +
        " particles  threads self-collision     whole step pushing a p.      bytes a p.   searches  crossings\n");
  Json rows = Json::array();
  const auto measure = [&](int n, const std::vector<int>& counts) {
    std::vector<Line> lines;
    for (const int count : counts) {
      lines.push_back({Simulation(stack(n), {.threads = count}), count, {}, {}});
      for (int step = 0; step < kWarmUp; ++step) lines.back().simulation.step();
    }
    std::vector<std::string> hashes;
    for (const Line& line : lines) hashes.push_back(hex(line.simulation.state_hash()));
    for (int turn = 0; turn < options.repeats; ++turn) {
      status.show(std::to_string(n) + " particles", double(turn) / options.repeats);
      for (Line& line : lines) take_turn(line, options.seconds);
    }
    status.clear();
    for (std::size_t k = 0; k < lines.size(); ++k) {
      rows.push_back(row_of(lines[k]));
      rows.back()["state_hash_after_warm_up"] = hashes[k];
      print(printed(rows.back()));
    }
    files.write(rows.dump(2) + "\n", facts.dump(2) + "\n", print.text());
  };
  for (const int n : cases)
    if (n <= kTogether)
      measure(n, threads);
    else
      for (const int count : threads) measure(n, {count});
  files.list();
}

}  // namespace malha::bench
