// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/cases.h"

#include <cmath>

#include "tools/bench/output.h"
#include "tools/study/reference/catenary.h"
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

/// A kilogram on a spring of 1000 N/m and 1 m, held at the other end, starting at 1.5 m (XPBD 2016, section 6).
BodySpec mass_on_a_spring(const std::string& name) {
  // Half of the mass is at each end.
  return body_of(name, ChainShape{{0, 0, 0}, {1.5, 0, 0}, 1}, 2, {ListPin{{0}}}, springs(1000, {"edges"}, 1 / 1.5));
}

AccuracyCase oscillator() {
  AccuracyCase of;
  of.name = "oscillator", of.title = "A mass on a spring, to and fro";
  of.what = "1 kg on a spring of 1000 N/m and 1 m, let go at 1.5 m: five periods a second.";
  of.scene = scene_of(mass_on_a_spring(of.name), {});
  of.exact = [](double t) {
    const double omega = std::sqrt(1000);
    State state{Vector::Zero(6), Vector::Zero(6)};
    state.x[3] = 1 + 0.5 * std::cos(omega * t), state.v[3] = -0.5 * omega * std::sin(omega * t);
    return state;
  };
  return of;
}

AccuracyCase orbit() {
  const double omega = std::sqrt(1000 * 0.5 / 1.5);  // 0.5 m of stretch hold 1 kg on a circle of 1.5 m
  BodySpec body = mass_on_a_spring("orbit");
  body.velocity = {0, 1.5 * omega, 0};
  AccuracyCase of;
  of.name = "orbit", of.title = "A mass on a spring, round and round";
  of.what = "The same spring on a circle of 1.5 m, on which the stretch just holds the mass.";
  of.scene = scene_of(std::move(body), {});
  of.exact = [omega](double t) {
    const double c = std::cos(omega * t), s = std::sin(omega * t);
    State state{Vector::Zero(6), Vector::Zero(6)};
    state.x[3] = 1.5 * c, state.x[4] = 1.5 * s, state.v[3] = -1.5 * omega * s, state.v[4] = 1.5 * omega * c;
    return state;
  };
  return of;
}

/// n x n particles of edges and diagonals, horizontal at the start.
AccuracyCase square(const std::string& name, const std::string& title, int n, double stiffness, double rest_scale,
                    const std::vector<Pin>& pins, int reference) {
  const std::string side = std::to_string(n);
  AccuracyCase of;
  of.name = name + side, of.title = title + " of " + side + " x " + side + " particles";
  of.what = bench::formatted("1 m and 0.2 kg, springs of %g N/m along edges and diagonals, ", stiffness);
  of.scene = scene_of(body_of(of.name, GridShape{{1, 1}, {n - 1, n - 1}}, 0.2, pins,
                              springs(stiffness, {"edges", "shear"}, rest_scale)),
                      kEarth);
  of.reference = reference;
  return of;
}

AccuracyCase sheet(int n, double stiffness, int reference) {
  AccuracyCase of = square("sheet", "A sheet", n, stiffness, 1, {RowPin{}}, reference);
  of.what += "held by one side and let go horizontally.";
  return of;
}

/// All springs are under tension, at rest and in motion, so that nothing buckles.
AccuracyCase drum(int n, double stiffness, int reference) {
  const double e = 1e-6;
  AccuracyCase of = square(
      "drum", "A taut sheet", n, stiffness, 0.9,
      {RowPin{}, RowPin{true}, BoxPin{{-e, -1, -1}, {e, 1, 2}}, BoxPin{{1 - e, -1, -1}, {1 + e, 1, 2}}}, reference);
  of.what +=
      "held by its four sides and horizontal. Its springs are a tenth shorter at rest than at the start, and the "
      "weight sets it swinging under tension throughout. Newton's method, whose factors are dear here, is run for 1 s "
      "alone.";
  of.taut = true, of.newton_until = 1;
  return of;
}

/// A free shell that turns and, because it starts at its lengths at rest, pulses.
AccuracyCase shell(int subdivisions, int reference) {
  AccuracyCase of;
  BodySpec body = body_of("shell", SphereShape{0.5, subdivisions}, 1, {}, springs(100, {"edges"}));
  body.velocity = {0.3, 0.2, -0.1}, body.spin = {2, 3, -1};
  of.name = "shell", of.title = "A free body: a turning shell";
  of.what = "A sphere of 0.5 m and 1 kg of springs of 100 N/m, thrown and turning at 3.7 rad/s without gravity.";
  of.scene = scene_of(std::move(body), {});
  of.reference = reference;
  return of;
}

constexpr double kSpan = 1, kChainMass = 0.1, kChainEA = 12.5;  // m, kg, N

BodySpec chain_body(const std::string& name, int segments) {
  return body_of(name, ChainShape{{0, 0, 0}, {kSpan, 0, 0}, segments}, kChainMass, {ListPin{{0, segments}}},
                 springs(kChainEA * segments / kSpan, {"edges"}));
}

AccuracyCase chain(int segments, int reference) {
  AccuracyCase of;
  of.name = "chain", of.title = "A chain between two pins, let go";
  of.what =
      bench::formatted("%d springs, 1 m and 0.1 kg, EA = %g N, straight and slack at the start.", segments, kChainEA);
  of.scene = scene_of(chain_body(of.name, segments), kEarth);
  of.reference = reference;
  return of;
}

/// Drag (N s/m) a particle that damps the slowest motion critically, about.
void damp(AccuracyCase& of, double mass, int particles, double slowest) {
  of.scene.wind = Wind{{0, 0, 0}, 2 * slowest * mass / particles};
  of.at_rest = true, of.times = {5};
}

AccuracyCase catenary(int segments) {
  AccuracyCase of;
  of.name = "catenary", of.title = "The same chain come to rest: the elastic catenary";
  of.what = "Air drag of the particles stills it.";
  of.scene = scene_of(chain_body(of.name, segments), kEarth);
  const std::vector<Vec3> line = elastic_catenary(kSpan, kSpan, kChainMass * 9.81, kChainEA, segments);
  const State truth{flat(line), Vector::Zero(3 * segments + 3)};
  of.exact = [truth](double) { return truth; };
  const Vector own = at_rest(*spring_system(of.scene), 1e-9);
  of.known = (own - truth.x).norm() / std::sqrt(segments + 1.0);
  of.expected = bench::formatted(
      "The springs' own equilibrium is %.1e m from the line's (RMS), which sags by %.4f m: that much is the chain's, "
      "not the methods'.",
      of.known, -line[segments / 2][1]);
  damp(of, kChainMass, segments + 1, 9);
  return of;
}

constexpr double kLong = 1, kWide = 0.2, kYoung = 1e6, kDensity = 1000, kWeak = 1;  // m, m, Pa, kg/m^3, m/s^2

BodySpec beam_body(const std::string& name, int cells) {
  ConstraintSpec material;
  material.type = "neo_hookean", material.young_modulus = kYoung, material.parameter = 0.3;
  BodySpec body = body_of(name, TetBoxShape{{kLong, kWide, kWide}, {5 * cells, cells, cells}}, 1,
                          {BoxPin{{-kLong, -1, -1}, {-kLong / 2 + 1e-6, 1, 1}}}, material);
  body.mass.reset(), body.density = kDensity;
  return body;
}

AccuracyCase beam(int cells, int reference) {
  AccuracyCase of;
  of.name = "beam", of.title = "A beam of tetrahedra, let go";
  of.what =
      bench::formatted("1 x 0.2 x 0.2 m, %d cells across, 1 MPa, 1000 kg/m^3, held at one end, in 1 m/s^2.", cells);
  of.scene = scene_of(beam_body(of.name, cells), {0, -kWeak, 0});
  of.reference = reference, of.tetrahedra = true;
  return of;
}

/// Of the free end, m, on average.
double tip(const System& system, const Vector& x) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < system.count(); ++i)
    if (system.start.x[3 * i] > kLong / 2 - 1e-6) sum += system.start.x[3 * i + 1] - x[3 * i + 1], ++count;
  return sum / count;
}

AccuracyCase sunk_beam(int cells) {
  AccuracyCase of;
  of.name = "sunk_beam", of.title = "The same beam come to rest";
  of.what = "Air drag of the particles stills it; compared with the equilibrium of the same energy, by relaxation.";
  of.scene = scene_of(beam_body(of.name, cells), {0, -kWeak, 0});
  const auto system = tetrahedron_system(of.scene);
  const State truth{at_rest(*system, 1e-7), Vector::Zero(system->start.x.size())};
  of.exact = [truth](double) { return truth; };
  const double bernoulli = kDensity * kWeak * 12 * std::pow(kLong, 4) / (8 * kYoung * kWide * kWide);
  of.expected = bench::formatted(
      "There its end has sunk by %.4f m, %.2f of the %.4f m of Euler and Bernoulli: so much is the mesh's (tetrahedra "
      "of constant strain lock), not the methods'.",
      tip(*system, truth.x), tip(*system, truth.x) / bernoulli, bernoulli);
  of.tetrahedra = true;
  damp(of, kDensity * kLong * kWide * kWide, system->count(), 6);
  return of;
}

}  // namespace

std::vector<AccuracyCase> accuracy_cases(bool quick) {
  if (quick) {
    std::vector<AccuracyCase> all{oscillator(),  orbit(),     sheet(7, 100, 256), drum(5, 5, 128), shell(1, 256),
                                  chain(8, 256), catenary(8), beam(1, 256),       sunk_beam(1)};
    for (AccuracyCase& of : all) {
      if (!of.at_rest && !of.taut) of.times = {1};
      of.sweeps = 256, of.solves = 64, of.dense = of.taut ? 0 : 16, of.euler = 256, of.rk4 = 128, of.newton = 16;
    }
    return all;
  }
  AccuracyCase large = sheet(100, 100, 512), taut = drum(100, 5, 128), stiff = sheet(17, 1e4, 4096);
  stiff.name += "_stiff", stiff.title += ", stiff", stiff.newton = 4;
  large.sweeps = 256, large.solves = 16, large.dense = 4, large.euler = 512, large.rk4 = 256;
  large.newton = 0, large.times = {0.5, 1};
  large.what +=
      " It is chaotic sooner than the smaller one, so that errors are taken after 0.5 s and 1 s; the taut sheet of as "
      "many particles shows 5 s. Newton's method is left out: in the fourth frame already its 50 turns do not get "
      "there.";
  taut.sweeps = 256, taut.solves = 16, taut.dense = 0, taut.refine = 4, taut.euler = 128, taut.rk4 = 64;
  taut.newton = 2;
  return {oscillator(),  orbit(),         sheet(17, 100, 1024), stiff,        large,       taut,
          shell(2, 512), chain(20, 1024), catenary(20),         beam(2, 512), sunk_beam(2)};
}

std::unique_ptr<System> system_of(const AccuracyCase& of) {
  if (of.tetrahedra) return tetrahedron_system(of.scene);
  return spring_system(of.scene);
}

Scene with_solver(const AccuracyCase& of, const SolverSpec& solver, bool compliant) {
  Scene scene = of.scene;
  scene.solver = solver;
  scene.solver.dt = kFrame;
  if (!compliant)
    for (ConstraintSpec& spec : scene.bodies[0].constraints) spec.compliance.reset();  // of stiffness 1
  return scene;
}

}  // namespace malha::study
