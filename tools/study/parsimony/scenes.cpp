// SPDX-License-Identifier: Apache-2.0
#include "tools/study/parsimony/scenes.h"

#include <functional>
#include <utility>

namespace malha::study {

namespace {

using Change = std::function<void(Scene&)>;

ConstraintSpec kind(const std::string& type, double stiffness = 1) {
  ConstraintSpec spec;
  spec.type = type, spec.stiffness = stiffness;
  if (type == "distance" || type == "distance_limit") spec.elements = {"edges"};
  return spec;
}

Scene scene_with(Shape shape, double mass, std::vector<ConstraintSpec> constraints) {
  BodySpec body;
  body.name = "body", body.shape = std::move(shape), body.mass = mass, body.constraints = std::move(constraints);
  Scene scene;
  scene.file = "malha study", scene.name = "parsimony", scene.gravity = {0, -9.81, 0};
  scene.solver.levels = 0;  // levels are one of the features to be added
  scene.bodies = {std::move(body)};
  return scene;
}

/// A cloth that is pinned at one side and swings down from the horizontal.
Scene cloth(int cells, std::vector<ConstraintSpec> constraints) {
  Scene scene = scene_with(GridShape{{1, 1}, {cells, cells}}, 0.2, std::move(constraints));
  scene.bodies[0].pins = {RowPin{}};
  return scene;
}

Change add(ConstraintSpec spec) {
  return [spec](Scene& scene) { scene.bodies[0].constraints.push_back(spec); };
}

ConstraintSpec limit() {
  ConstraintSpec spec = kind("distance_limit");
  spec.parameter = 0.1;
  return spec;
}

ConstraintSpec long_range() {
  ConstraintSpec spec = kind("long_range");
  spec.parameter = 0.02;
  return spec;
}

ConstraintSpec neo_hookean() {
  ConstraintSpec spec = kind("neo_hookean");
  spec.parameter = 0.4, spec.young_modulus = 1e4;
  return spec;
}

/// Adds a ball below the cloth; at y = -5 it is out of reach.
Change ball(double y, double friction) {
  return [=](Scene& scene) {
    EnvironmentSpec ball;
    ball.name = "ball", ball.shape = SphereShape{0.3, 3}, ball.friction = friction;
    ball.transform.translate = {0.5, y, 0.5};
    scene.environment = {ball};
  };
}

Change wind(double drag, double density) {
  return [=](Scene& scene) {
    if (!scene.wind) scene.wind.emplace();
    scene.wind->velocity = {0, 0, 2};
    if (drag > 0) scene.wind->drag = drag;
    if (density > 0) scene.wind->density = density;
  };
}

void move_pins(Scene& scene) { scene.bodies[0].pins[0].motion = {{0, {0, 0, 0}}, {10, {0, 0, 1}}}; }

/// Attaches the last row to its initial position.
void attach(Scene& scene) {
  Attachment attachment;
  attachment.at = RowPin{true}, attachment.compliance = 0.1;
  scene.bodies[0].attachments = {attachment};
}

void damp(Scene& scene) { scene.bodies[0].damping = 0.05; }
void sleep(Scene& scene) { scene.sleep = Sleep{1e-9, 0.5}; }  // never reached: only the checks cost time
void sleep_at_once(Scene& scene) { scene.sleep = Sleep{1e9, 0}; }
void tear(Scene& scene) { scene.bodies[0].tear = Tear{1e6}; }  // never reached: only the checks cost time
void in_double(Scene& scene) { scene.solver.precision = Precision::Double; }

void collide_with_itself(Scene& scene) {
  SelfCollision self;
  self.thickness = 0.2 / std::get<GridShape>(scene.bodies[0].shape).cells[0];  // a fifth of an edge
  scene.self_collision = self;
}

Change stiffness_as_compliance(double compliance) {
  return [=](Scene& scene) {
    for (ConstraintSpec& spec : scene.bodies[0].constraints) spec.compliance = compliance;
  };
}

Change desbrun(int refine) {
  return [=](Scene& scene) {
    scene.solver.type = "desbrun", scene.solver.substeps = 1, scene.solver.desbrun.refinement_iterations = refine;
    scene.solver.desbrun.filter = FilterKind::Sparse;
  };
}

FeatureCase make_feature_case(const std::string& feature, const std::string& base, const Scene& without,
                              const Change& change) {
  FeatureCase feature_case{feature, base, without, without};
  change(feature_case.with);
  return feature_case;
}

}  // namespace

std::vector<FeatureCase> single_features(bool quick) {
  const int cells = quick ? 31 : 99;
  const Scene loose = cloth(cells, {}), plain = cloth(cells, {kind("distance")});
  const Scene closed = scene_with(SphereShape{0.5, quick ? 3 : 5}, 0.5, {kind("distance")});
  const int side = quick ? 9 : 21;
  const Scene solid = scene_with(TetBoxShape{{1, 1, 1}, {side, side, side}}, 1, {});
  Scene touched = plain, springs = plain;
  ball(-0.296, 0)(touched);
  desbrun(0)(springs);
  Scene flying = plain;
  flying.bodies[0].pins.clear();
  const auto with = [](const std::string& feature, const Change& change, const Scene& base, const char* name) {
    return make_feature_case(feature, name, base, change);
  };
  const auto to_cloth = [&](const std::string& feature, const Change& change) {
    return make_feature_case(feature, "cloth", plain, change);
  };
  return {
      to_cloth("nothing", [](Scene&) {}),
      with("distance on edges", add(kind("distance")), loose, "particles"),
      to_cloth("distance on diagonals",
               [](Scene& s) {
                 s.bodies[0].constraints[0].elements = {"edges", "shear"};
               }),
      to_cloth("compliance", stiffness_as_compliance(1e-6)),
      to_cloth("distance_limit", add(limit())),
      to_cloth("bending", add(kind("bending", 0.1))),
      to_cloth("isometric_bending", add(kind("isometric_bending", 0.1))),
      to_cloth("drag on particles", wind(1e-6, 0)),
      to_cloth("air on faces", wind(0, 1.2)),
      to_cloth("damping", damp),
      with(
          "corrector", [](Scene& s) { s.solver.keeps_momenta = true; }, flying, "free cloth"),
      to_cloth("long_range", add(long_range())),
      to_cloth("levels", [](Scene& s) { s.solver.levels = kMaxLevels; }),
      to_cloth("moved pins", move_pins),
      to_cloth("attachments", attach),
      to_cloth("environment (out of reach)", ball(-5, 0)),
      to_cloth("environment (touched)", ball(-0.296, 0)),
      with("friction", ball(-0.296, 0.5), touched, "cloth on a ball"),
      to_cloth("self-collision (flat)", collide_with_itself),
      to_cloth("tear (not reached)", tear),
      to_cloth("sleep (awake)", sleep),
      to_cloth("sleep (asleep)", sleep_at_once),
      to_cloth("double", in_double),
      with("pressure", add(kind("pressure")), closed, "closed surface"),
      with("volume", add(kind("volume")), solid, "tetrahedra without constraints"),
      with("neo_hookean", add(neo_hookean()), solid, "tetrahedra without constraints"),
      with("refine = 1", desbrun(1), springs, "springs by Desbrun, sparse"),
  };
}

std::vector<FeatureCase> feature_ladder(bool quick) {
  Scene scene = cloth(quick ? 31 : 99, {});
  std::vector<FeatureCase> rungs;
  const auto add_rung = [&](const std::string& feature, const Change& change) {
    rungs.push_back(make_feature_case(feature, rungs.empty() ? "particles" : rungs.back().feature, scene, change));
    scene = rungs.back().with;
  };
  add_rung("distance", add(kind("distance")));
  add_rung("+ bending", add(kind("bending", 0.1)));
  add_rung("+ air on faces", wind(0, 1.2));
  add_rung("+ damping", damp);
  add_rung("+ long_range", add(long_range()));
  add_rung("+ moved pins", move_pins);
  add_rung("+ attachments", attach);
  add_rung("+ environment", ball(-0.296, 0));
  add_rung("+ friction", ball(-0.296, 0.5));
  add_rung("+ sleep", sleep);
  add_rung("+ self-collision", collide_with_itself);
  return rungs;
}

}  // namespace malha::study
