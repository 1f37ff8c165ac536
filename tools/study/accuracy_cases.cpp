#include "tools/study/accuracy_cases.h"

#include <cmath>

namespace malha::study {

namespace {

ConstraintSpec springs(double stiffness, std::vector<std::string> on, double rest_scale = 1) {
  ConstraintSpec spec;
  spec.type = "distance", spec.on = std::move(on), spec.compliance = 1 / stiffness, spec.parameter = rest_scale;
  return spec;
}

Scene scene_of(BodySpec body, const Vec3& gravity) {
  Scene scene;
  scene.file = "malha study", scene.name = body.name, scene.gravity = gravity, scene.solver.dt = kFrame;
  scene.bodies = {std::move(body)};
  return scene;
}

/// A kilogram on a spring of 1000 N/m and 1 m, held at the other end, starting at 1.5 m (XPBD 2016, section 6).
BodySpec mass_on_a_spring(const std::string& name) {
  BodySpec body;
  body.name = name, body.shape = ChainShape{{0, 0, 0}, {1.5, 0, 0}, 1}, body.mass = 2;  // half of it at each end
  body.pins = {ListPin{{0}}};
  body.constraints = {springs(1000, {"edges"}, 1 / 1.5)};
  return body;
}

AccuracyCase oscillator() {
  AccuracyCase of{"oscillator", "A mass on a spring, to and fro", scene_of(mass_on_a_spring("oscillator"), {})};
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
  AccuracyCase of{"orbit", "A mass on a spring, round and round", scene_of(std::move(body), {})};
  of.exact = [omega](double t) {
    const double c = std::cos(omega * t), s = std::sin(omega * t);
    State state{Vector::Zero(6), Vector::Zero(6)};
    state.x[3] = 1.5 * c, state.x[4] = 1.5 * s, state.v[3] = -1.5 * omega * s, state.v[4] = 1.5 * omega * c;
    return state;
  };
  return of;
}

}  // namespace

std::vector<AccuracyCase> accuracy_cases(bool) { return {oscillator(), orbit()}; }

Scene with_solver(const AccuracyCase& of, const SolverSpec& solver, bool compliant) {
  Scene scene = of.scene;
  scene.solver = solver;
  scene.solver.dt = kFrame;
  if (!compliant)
    for (ConstraintSpec& spec : scene.bodies[0].constraints) spec.compliance.reset();  // of stiffness 1
  return scene;
}

}  // namespace malha::study
