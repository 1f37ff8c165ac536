// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/constraints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/solver/solver.h"
#include "kernels/constraints/constraint_registry.h"
#include "malha/simulation.h"
#include "tools/bench/facts.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

/// A scene with one kind of constraint or force, and the pass of a step that computes it.
struct KindCase {
  std::string what, element;
  Scene scene;
  Pass pass;
  std::function<std::int64_t(const Simulation&)> elements;
};

Scene scene_with(BodySpec body) {
  Scene scene;
  scene.file = "malha bench constraints", scene.name = "one kind";
  scene.gravity = {0, -9.81, 0};
  scene.solver.levels = 0;  // levels would add their own constraints
  body.name = "body", body.mass = 1;
  scene.bodies = {std::move(body)};
  return scene;
}

int side_of(int particles) { return std::max(4, static_cast<int>(std::lround(std::sqrt(particles)))); }

BodySpec sheet(int particles) {
  const int side = side_of(particles);
  BodySpec body;
  body.shape = GridShape{{2, 2}, {side - 1, side - 1}};
  body.pins = {RowPin{}};
  return body;
}

BodySpec ball(int particles) {
  BodySpec body;
  int subdivisions = 1;
  while (10 * std::pow(4, subdivisions + 1) + 2 <= 1.6 * particles) ++subdivisions;
  body.shape = SphereShape{0.5, subdivisions};
  return body;
}

ConstraintSpec spec_of(const std::string& type, double parameter) {
  ConstraintSpec spec;
  spec.type = type, spec.parameter = parameter;
  return spec;
}

std::int64_t constraints_of(const Simulation& simulation) {
  std::int64_t sum = 0;
  for (const SetStats& set : simulation.solver().facts().sets) sum += set.constraints;
  return sum;
}
std::int64_t filtered_of(const Simulation& simulation) {
  std::int64_t sum = 0;
  for (const ConstraintSet& set : simulation.model().stencils) sum += set.count();
  return sum;
}
std::int64_t particles_of(const Simulation& simulation) { return simulation.model().count(); }

BodySpec block(int particles) {
  const int cells = std::max(1, static_cast<int>(std::lround(std::cbrt(particles))) - 1);
  BodySpec body;
  body.shape = TetBoxShape{{1, 1, 1}, {cells, cells, cells}};
  return body;
}

/// Adds cases with a stiffness, and with a material's modulus, if the kind has them; of bending also through the
/// filter.
template <class Kind>
void add_kind(std::vector<KindCase>& lines, int particles) {
  constexpr ElementFacts element = facts_of(Kind::element);
  constexpr Strength strength = Kind::strength;
  const auto add = [&](bool with_modulus, const std::string& way, bool filtered = false) {
    ConstraintSpec spec = spec_of(name_in_scenes<Kind>(), Kind::parameter.default_value);
    if (with_modulus) {
      const std::string unit = strength.unit;
      const double modulus = element.solid ? 1e5 : unit.starts_with("N/m") ? 100 : 1e-4;
      modulus_of(spec, strength.modulus) = modulus;
      if constexpr (std::is_same_v<Material<Kind>, Orthotropic>) spec.orthotropy = Orthotropy{modulus / 2};
    }
    if (Kind::element == Element::Edges) spec.elements = {"edges", "shear"};
    BodySpec body = element.solid ? block(particles) : sheet(particles);
    body.constraints = {std::move(spec)};
    Scene scene = scene_with(std::move(body));
    if (Kind::element == Element::Hinges)
      scene.gravity = {0, 0, 0};  // hinges alone do not hold a sheet together: it is at rest
    scene.solver.bending = filtered ? BendingMethod::Filtered : BendingMethod::Projected;
    lines.push_back({Kind::name + way, element.one, std::move(scene), filtered ? Pass::Filter : Pass::FusedSolve,
                     filtered ? filtered_of : constraints_of});
  };
  if (strength.accepts_stiffness) add(false, "");
  if (strength.modulus) add(true, strength.accepts_stiffness ? std::string(", ") + strength.modulus : "");
  if (bends<Kind>()) add(true, ", filtered", true);
}

std::vector<KindCase> plan(int particles) {
  std::vector<KindCase> lines;
  for_each_constraint([&]<class Kind>(Kind) {
    if (is_of_mesh<Kind>()) add_kind<Kind>(lines, particles);
  });
  const auto add = [&](const std::string& what, BodySpec body, Pass pass) {
    lines.push_back({what, "particle", scene_with(std::move(body)), pass, particles_of});
    return &lines.back().scene;
  };
  BodySpec balloon = ball(particles);
  balloon.constraints = {spec_of("pressure", 1)};
  add("pressure", balloon, Pass::Pressure);
  BodySpec hanging = sheet(particles);
  hanging.constraints = {spec_of("long_range", 0.02)};
  add("long_range", hanging, Pass::LongRange);
  add("air on faces", sheet(particles), Pass::Air)->wind = Wind{{1, 0, 2}, 0, 1.2};
  BodySpec tied = sheet(particles);
  Attachment& ties = tied.attachments.emplace_back();
  ties.at = BoxPin{{-9, -9, -9}, {9, 9, 9}}, ties.compliance = 1e-3;
  add("attachment", tied, Pass::Attachments);
  BodySpec damped = sheet(particles);
  damped.damping = 0.1;
  add("damping", damped, Pass::Damping);
  return lines;
}

struct KindRow {
  std::string what, element;
  std::int64_t elements = 0, bytes = 0;
  int threads = 1;
  std::vector<double> ns;  // per element and substep, one value a repeat
};

/// Steps a case and restarts its scene every kMostSteps steps: some bodies fall freely, and after minutes float has no
/// digits left for their shape.
class Runner {
 public:
  Runner(const KindCase& line, const RunsOn& on, int threads) : line_(line), on_(on), threads_(threads) { start(); }

  void step() {
    if (simulation_->steps() >= kMostSteps) start();
    const double before = pass_seconds();
    simulation_->step();
    seconds_ += pass_seconds() - before, ++steps_;
  }
  const Simulation& simulation() const { return *simulation_; }
  /// Mean seconds of the pass per step since the last call.
  double seconds_a_step() {
    const double each = seconds_ / static_cast<double>(steps_);
    seconds_ = 0, steps_ = 0;
    return each;
  }

 private:
  static constexpr std::int64_t kMostSteps = 600;  // 10 s

  void start() {
    simulation_.emplace(line_.scene, on_.simulation_options(threads_, true));
    for (int k = 0; k < 3; ++k) simulation_->step();
  }
  double pass_seconds() const { return simulation_->solver().pass_seconds()[static_cast<int>(line_.pass)]; }

  const KindCase& line_;
  const RunsOn& on_;
  int threads_;
  std::optional<Simulation> simulation_;
  double seconds_ = 0;
  std::int64_t steps_ = 0;
};

/// Measures all numbers of threads in turns.
std::vector<KindRow> measure(const KindCase& line, const ConstraintOptions& options, const std::vector<int>& threads) {
  std::vector<Runner> runners;
  std::vector<KindRow> rows;
  for (const int t : threads) {
    const Simulation& simulation = runners.emplace_back(line, options.on, t).simulation();
    const SolverStats& facts = simulation.solver().facts();
    const std::size_t filter_bytes = facts.filter ? facts.filter->bytes + facts.spring_bytes : 0;
    const auto bytes =
        static_cast<std::int64_t>(facts.constraint_bytes + facts.long_range_bytes + facts.air_bytes + filter_bytes);
    rows.push_back({line.what, line.element, line.elements(simulation), bytes, t, {}});
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat)
    for (std::size_t k = 0; k < rows.size(); ++k) {
      mean_seconds([&] { runners[k].step(); }, options.seconds);
      const double items = line.scene.solver.substeps * static_cast<double>(rows[k].elements);
      rows[k].ns.push_back(1e9 * runners[k].seconds_a_step() / items);
    }
  return rows;
}

Json json_of(const std::vector<KindRow>& rows) {
  Json all = Json::array();
  for (const KindRow& row : rows)
    all.push_back({{"what", row.what},
                   {"element", row.element},
                   {"elements", row.elements},
                   {"threads", row.threads},
                   {"ns", median(row.ns)},
                   {"ns_min", *std::min_element(row.ns.begin(), row.ns.end())},
                   {"ns_max", *std::max_element(row.ns.begin(), row.ns.end())},
                   {"memory_bytes", row.bytes}});
  return all;
}

std::string table_line(const std::vector<KindRow>& rows) {
  std::string line =
      formatted("%-28s %9lld %-11s %7.1f", rows[0].what.c_str(), static_cast<long long>(rows[0].elements),
                rows[0].element.c_str(), static_cast<double>(rows[0].bytes) / static_cast<double>(rows[0].elements));
  for (const KindRow& row : rows) line += formatted(" %8.2f", median(row.ns));
  return line + "\n";
}

}  // namespace

void run_constraints(const ConstraintOptions& options) {
  const std::vector<int> threads = thread_counts(options);
  Output out("constraints", options);
  out.show_progress("measuring the machine", 0);
  out.facts = machine_facts(threads, options.on);
  out.print(formatted("Every kind alone on a body of about %d particles, in float, 10 substeps of 1 iteration: ns per "
                      "element and substep\nof the kind's pass, or of the whole step for batched kinds; medians of %d "
                      "x %g s, numbers of "
                      "threads in turns.\n",
                      options.n, options.repeats, options.seconds) +
            machine_lines(out.facts, ""));
  std::string head = formatted("\n%-28s %9s %-11s %7s", "kind", "elements", "element", "bytes");
  for (const int t : threads) head += formatted(" %5d th.", t);
  out.print(head + "\n");
  std::vector<KindRow> all;
  const std::vector<KindCase> lines = plan(options.n);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    out.show_progress(lines[k].what, double(k) / double(lines.size()));
    const std::vector<KindRow> rows = measure(lines[k], options, threads);
    out.print(table_line(rows));
    all.insert(all.end(), rows.begin(), rows.end());
    out.write(json_of(all));
  }
  out.list();
}

}  // namespace malha::bench
