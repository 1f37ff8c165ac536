// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/cases.h"

#include <cmath>

#include "tools/bench/output.h"
#include "tools/study/reference/catenary.h"
#include "tools/study/reference/elastica.h"
#include "tools/study/reference/tetrahedra.h"

namespace malha::study {

namespace {

constexpr Vec3 kEarth{0, -9.81, 0};

ConstraintSpec springs(double stiffness, std::vector<std::string> on, double rest_scale = 1) {
  ConstraintSpec spec;
  spec.type = "distance", spec.elements = std::move(on), spec.compliance = 1 / stiffness, spec.parameter = rest_scale;
  return spec;
}

Scene scene_of(BodySpec body, const Vec3& gravity) {
  Scene scene;
  scene.file = "malha study", scene.name = body.name, scene.gravity = gravity, scene.solver.dt = kFrame;
  scene.bodies = {std::move(body)};
  return scene;
}

BodySpec body_of(const std::string& name, const Shape& shape, double mass, std::vector<Pin> pins,
                 const ConstraintSpec& constraint) {
  BodySpec body;
  body.name = name, body.shape = shape, body.mass = mass, body.pins = std::move(pins);
  body.constraints = {constraint};
  return body;
}

/// A mass of 1 kg on a spring of 1000 N/m and 1 m, pinned at the other end, starts at 1.5 m (XPBD 2016, section 6).
BodySpec mass_on_a_spring(const std::string& name) {
  // Half of the mass is at each end.
  return body_of(name, ChainShape{{0, 0, 0}, {1.5, 0, 0}, 1}, 2, {ListPin{{0}}}, springs(1000, {"edges"}, 1 / 1.5));
}

AccuracyCase oscillator() {
  AccuracyCase test_case;
  test_case.name = "oscillator", test_case.title = "A mass on a spring, to and fro";
  test_case.what = "1 kg on a spring of 1000 N/m and 1 m, released at 1.5 m: five periods a second.";
  test_case.scene = scene_of(mass_on_a_spring(test_case.name), {});
  test_case.exact = [](double t) {
    const double omega = std::sqrt(1000);
    State state{Vector::Zero(6), Vector::Zero(6)};
    state.x[3] = 1 + 0.5 * std::cos(omega * t), state.v[3] = -0.5 * omega * std::sin(omega * t);
    return state;
  };
  return test_case;
}

AccuracyCase orbit() {
  const double omega = std::sqrt(1000 * 0.5 / 1.5);  // a stretch of 0.5 m keeps 1 kg on a circle of 1.5 m
  BodySpec body = mass_on_a_spring("orbit");
  body.velocity = {0, 1.5 * omega, 0};
  AccuracyCase test_case;
  test_case.name = "orbit", test_case.title = "A mass on a spring, round and round";
  test_case.what = "The same spring on a circle of 1.5 m, whose centripetal force is that of the stretch.";
  test_case.scene = scene_of(std::move(body), {});
  test_case.exact = [omega](double t) {
    const double c = std::cos(omega * t), s = std::sin(omega * t);
    State state{Vector::Zero(6), Vector::Zero(6)};
    state.x[3] = 1.5 * c, state.x[4] = 1.5 * s, state.v[3] = -1.5 * omega * s, state.v[4] = 1.5 * omega * c;
    return state;
  };
  return test_case;
}

/// A sheet of n x n particles with springs along edges and diagonals, horizontal at the start.
AccuracyCase square(const std::string& name, const std::string& title, int n, double stiffness, double rest_scale,
                    const std::vector<Pin>& pins, int reference) {
  const std::string side = std::to_string(n);
  AccuracyCase test_case;
  test_case.name = name + side, test_case.title = title + " of " + side + " x " + side + " particles";
  test_case.what = bench::formatted("1 m and 0.2 kg, springs of %g N/m along edges and diagonals, ", stiffness);
  test_case.scene = scene_of(body_of(test_case.name, GridShape{{1, 1}, {n - 1, n - 1}}, 0.2, pins,
                                     springs(stiffness, {"edges", "shear"}, rest_scale)),
                             kEarth);
  test_case.reference = reference;
  return test_case;
}

AccuracyCase sheet(int n, double stiffness, int reference) {
  AccuracyCase test_case = square("sheet", "A sheet", n, stiffness, 1, {RowPin{}}, reference);
  test_case.what += "pinned at one side and released horizontally.";
  return test_case;
}

/// A sheet whose springs are under tension, at rest and in motion, so that nothing buckles.
AccuracyCase drum(int n, double stiffness, int reference) {
  const double e = 1e-6;
  AccuracyCase test_case = square(
      "drum", "A taut sheet", n, stiffness, 0.9,
      {RowPin{}, RowPin{true}, BoxPin{{-e, -1, -1}, {e, 1, 2}}, BoxPin{{1 - e, -1, -1}, {1 + e, 1, 2}}}, reference);
  test_case.what +=
      "pinned at its four sides and horizontal. Its springs are a tenth shorter at rest than at the start, and the "
      "weight makes it oscillate under tension throughout. Newton's method, whose factors are expensive here, is run "
      "for "
      "1 s only.";
  test_case.taut = true, test_case.newton_end_time = 1;
  return test_case;
}

/// A free shell that rotates and, because it starts at its rest lengths, pulsates.
AccuracyCase shell(int subdivisions, int reference) {
  AccuracyCase test_case;
  BodySpec body = body_of("shell", SphereShape{0.5, subdivisions}, 1, {}, springs(100, {"edges"}));
  body.velocity = {0.3, 0.2, -0.1}, body.spin = {2, 3, -1};
  test_case.name = "shell", test_case.title = "A free body: a turning shell";
  test_case.what = "A sphere of 0.5 m and 1 kg of springs of 100 N/m, thrown and turning at 3.7 rad/s without gravity.";
  test_case.scene = scene_of(std::move(body), {});
  test_case.reference = reference;
  return test_case;
}

constexpr double kSpan = 1, kChainMass = 0.1, kChainEA = 12.5;  // m, kg, N

BodySpec chain_body(const std::string& name, int segments) {
  return body_of(name, ChainShape{{0, 0, 0}, {kSpan, 0, 0}, segments}, kChainMass, {ListPin{{0, segments}}},
                 springs(kChainEA * segments / kSpan, {"edges"}));
}

AccuracyCase chain(int segments, int reference) {
  AccuracyCase test_case;
  test_case.name = "chain", test_case.title = "A chain released between two pins";
  test_case.what =
      bench::formatted("%d springs, 1 m and 0.1 kg, EA = %g N, straight and slack at the start.", segments, kChainEA);
  test_case.scene = scene_of(chain_body(test_case.name, segments), kEarth);
  test_case.reference = reference;
  return test_case;
}

/// Adds drag (N s/m per particle) that damps the slowest mode about critically. `slowest`: its frequency, rad/s.
void damp(AccuracyCase& test_case, double mass, int particles, double slowest) {
  test_case.scene.wind = Wind{{0, 0, 0}, 2 * slowest * mass / particles};
  test_case.at_rest = true, test_case.times = {5};
}

AccuracyCase catenary(int segments) {
  AccuracyCase test_case;
  test_case.name = "catenary", test_case.title = "The same chain come to rest: the elastic catenary";
  test_case.what = "Air drag of the particles brings it to rest.";
  test_case.scene = scene_of(chain_body(test_case.name, segments), kEarth);
  const std::vector<Vec3> line = elastic_catenary(kSpan, kSpan, kChainMass * 9.81, kChainEA, segments);
  const State truth{flat(line), Vector::Zero(3 * segments + 3)};
  test_case.exact = [truth](double) { return truth; };
  const Vector equilibrium = relax_to_rest(*spring_system(test_case.scene), 1e-9);
  test_case.discretisation_error = (equilibrium - truth.x).norm() / std::sqrt(segments + 1.0);
  test_case.expected = bench::formatted(
      "The equilibrium of the springs is %.1e m (RMS) from that of the continuous line, which sags by %.4f m: this "
      "error "
      "is the discretisation's, not the methods'.",
      test_case.discretisation_error, -line[segments / 2][1]);
  damp(test_case, kChainMass, segments + 1, 9);
  return test_case;
}

constexpr double kStripDensity = 0.1, kStripWidth = 0.25;  // kg/m^2, m

/// A strip of 1 m with `cells` cells along, clamped by its first two rows of particles. `gamma`: density g L^3 / D.
AccuracyCase clamped_strip(const std::string& name, const std::string& title, int cells, double gamma) {
  const int across = cells / 4;
  const double D = kStripDensity * 9.81 * std::pow(1 - 1.0 / cells, 3) / gamma;
  ListPin clamp;
  for (int i = 0; i < 2 * (across + 1); ++i) clamp.particles.push_back(i);
  AccuracyCase test_case;
  test_case.name = name, test_case.title = title;
  BodySpec body = body_of(name, GridShape{{kStripWidth, 1}, {across, cells}}, kStripDensity * kStripWidth, {clamp},
                          springs(1e5, {"edges", "shear"}));
  ConstraintSpec bending;
  bending.type = "bending", bending.rigidity = D;
  body.constraints.push_back(bending);
  test_case.what = bench::formatted(
      "1 x 0.25 m of 0.1 kg/m^2 in %d cells along, springs of 1e5 N/m, bending of a rigidity of %.4f N m: density g "
      "L^3 / D is %g from the clamp on. ",
      cells, D, gamma);
  test_case.scene = scene_of(std::move(body), kEarth);
  test_case.bends = true, test_case.refine = 0;
  return test_case;
}

/// Its swing down without drag. `time`: s, before it swings back.
AccuracyCase strip_swing(int cells, double gamma, double time, int reference) {
  AccuracyCase test_case =
      clamped_strip(bench::formatted("swing%g", gamma),
                    bench::formatted("A clamped strip that swings, Gamma %g", gamma), cells, gamma);
  test_case.what +=
      "Released horizontally, without drag. The true motion has bending by second differences along rows and columns. "
      "Methods can come no nearer to it than their hinges do, of which projected ones resist angles and filtered ones "
      "chords.";
  test_case.times = {time}, test_case.reference = reference, test_case.dense = 0;
  return test_case;
}

constexpr double kBeamLength = 1, kBeamWidth = 0.2, kYoung = 1e6, kDensity = 1000,
                 kBeamGravity = 1;  // m, m, Pa, kg/m^3, m/s^2

BodySpec beam_body(const std::string& name, int cells) {
  ConstraintSpec material;
  material.type = "neo_hookean", material.young_modulus = kYoung, material.parameter = 0.3;
  BodySpec body = body_of(name, TetBoxShape{{kBeamLength, kBeamWidth, kBeamWidth}, {5 * cells, cells, cells}}, 1,
                          {BoxPin{{-kBeamLength, -1, -1}, {-kBeamLength / 2 + 1e-6, 1, 1}}}, material);
  body.mass.reset(), body.density = kDensity;
  return body;
}

AccuracyCase beam(int cells, int reference) {
  AccuracyCase test_case;
  test_case.name = "beam", test_case.title = "A beam of tetrahedra, released";
  test_case.what = bench::formatted(
      "1 x 0.2 x 0.2 m, %d cells across, 1 MPa, 1000 kg/m^3, pinned at one end, gravity 1 m/s^2.", cells);
  test_case.scene = scene_of(beam_body(test_case.name, cells), {0, -kBeamGravity, 0});
  test_case.reference = reference, test_case.tetrahedra = true;
  return test_case;
}

/// Mean deflection of the free end, m.
double tip(const System& system, const Vector& x) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < system.count(); ++i)
    if (system.start.x[3 * i] > kBeamLength / 2 - 1e-6) sum += system.start.x[3 * i + 1] - x[3 * i + 1], ++count;
  return sum / count;
}

AccuracyCase sunk_beam(int cells) {
  AccuracyCase test_case;
  test_case.name = "sunk_beam", test_case.title = "The same beam come to rest";
  test_case.what =
      "Air drag of the particles brings it to rest; compared with the equilibrium of the same energy, by relaxation.";
  test_case.scene = scene_of(beam_body(test_case.name, cells), {0, -kBeamGravity, 0});
  const auto system = tetrahedron_system(test_case.scene);
  const State truth{relax_to_rest(*system, 1e-7), Vector::Zero(system->start.x.size())};
  test_case.exact = [truth](double) { return truth; };
  const double bernoulli =
      kDensity * kBeamGravity * 12 * std::pow(kBeamLength, 4) / (8 * kYoung * kBeamWidth * kBeamWidth);
  test_case.expected = bench::formatted(
      "There its end has sunk by %.4f m, %.2f of the %.4f m by Euler and Bernoulli: the difference is due to the mesh "
      "(tetrahedra of constant strain lock), not to the methods.",
      tip(*system, truth.x), tip(*system, truth.x) / bernoulli, bernoulli);
  test_case.tetrahedra = true;
  damp(test_case, kDensity * kBeamLength * kBeamWidth * kBeamWidth, system->count(), 6);
  return test_case;
}

}  // namespace

AccuracyCase cantilever(int cells) {
  constexpr double gamma = 10;
  AccuracyCase test_case =
      clamped_strip("cantilever", "A clamped strip come to rest: the heavy elastica", cells, gamma);
  test_case.what += "Air drag brings it to rest.";
  const int across = cells / 4;
  const double l = 1.0 / cells, length = 1 - l;
  const std::vector<ElasticaPoint> line = heavy_elastica(gamma, cells - 1);
  std::vector<Vec3> places;
  for (int row = 0; row <= cells; ++row)
    for (int i = 0; i <= across; ++i) {
      const double x = kStripWidth * i / across;
      if (row == 0)
        places.push_back({x, 0, 0});
      else
        places.push_back({x, -length * line[row - 1].drop, l + length * line[row - 1].reach});
    }
  const State truth{flat(places), Vector::Zero(3 * static_cast<int>(places.size()))};
  test_case.exact = [truth](double) { return truth; };
  test_case.expected = bench::formatted("The continuous line falls by %.4f m over a reach of %.4f m.",
                                        length * line.back().drop, length * line.back().reach);
  test_case.sweeps = 256;
  damp(test_case, kStripDensity * kStripWidth, (across + 1) * (cells + 1), 3.5);
  return test_case;
}

std::vector<AccuracyCase> accuracy_cases(bool quick) {
  if (quick) {
    std::vector<AccuracyCase> all{oscillator(),    orbit(),        sheet(7, 100, 256),
                                  drum(5, 5, 128), shell(1, 256),  chain(8, 256),
                                  catenary(8),     cantilever(12), strip_swing(12, 1, 0.3, 1024),
                                  beam(1, 256),    sunk_beam(1)};
    for (AccuracyCase& test_case : all) {
      if (test_case.times.size() > 1 && !test_case.taut) test_case.times = {1};
      test_case.sweeps = 256, test_case.solves = 64, test_case.dense = test_case.taut || test_case.bends ? 0 : 16,
      test_case.euler = 256, test_case.rk4 = 128, test_case.newton = 16;
    }
    return all;
  }
  AccuracyCase large = sheet(100, 100, 512), taut = drum(100, 5, 128), stiff = sheet(17, 1e4, 4096);
  stiff.name += "_stiff", stiff.title += ", stiff", stiff.newton = 4;
  large.sweeps = 256, large.solves = 16, large.dense = 4, large.euler = 512, large.rk4 = 256;
  large.newton = 0, large.times = {0.5, 1};
  large.what +=
      " It becomes chaotic sooner than the smaller one, so that errors are measured after 0.5 s and 1 s; the taut "
      "sheet of "
      "as many particles shows 5 s. Newton's method is left out: its 50 iterations do not converge from the fourth "
      "frame "
      "on.";
  taut.sweeps = 256, taut.solves = 16, taut.dense = 0, taut.refine = 4, taut.euler = 128, taut.rk4 = 64;
  taut.newton = 2;
  return {oscillator(),
          orbit(),
          sheet(17, 100, 1024),
          stiff,
          large,
          taut,
          shell(2, 512),
          chain(20, 1024),
          catenary(20),
          cantilever(48),
          strip_swing(24, 1, 0.3, 2048),
          strip_swing(24, 10, 0.6, 2048),
          beam(2, 512),
          sunk_beam(2)};
}

std::unique_ptr<System> system_of(const AccuracyCase& test_case) {
  if (test_case.tetrahedra) return tetrahedron_system(test_case.scene);
  return spring_system(test_case.scene);
}

Scene with_solver(const AccuracyCase& test_case, const SolverSpec& solver, bool compliant) {
  Scene scene = test_case.scene;
  scene.solver = solver;
  scene.solver.dt = kFrame;
  if (!compliant)
    for (ConstraintSpec& spec : scene.bodies[0].constraints) spec.compliance.reset();  // stiffness 1
  return scene;
}

}  // namespace malha::study
