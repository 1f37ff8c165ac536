// SPDX-License-Identifier: Apache-2.0
#include "host/model/build_constraints.h"

#include <algorithm>
#include <limits>

#include "host/base/disjoint_sets.h"
#include "host/base/median.h"
#include "host/base/spelling_suggestion.h"
#include "host/mesh/generate.h"
#include "host/mesh/geodesic.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/joined_mesh.h"
#include "host/model/material.h"
#include "host/model/softening.h"
#include "host/model/stencils.h"
#include "kernels/constraints/constraint_registry.h"
#include "kernels/projection/element.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// Elements of a body's mesh on which constraints act: edges, hinges, triangles ... (kernels/projection/element.h).
struct Elements {
  std::vector<int> particles;  // facts_of(element).particles for each element, in the body's numbering
  // The compliance of each element times the modulus of its material; it is empty for constraints with stiffness or
  // compliance.
  std::vector<double> softness;
  // The rest positions of the particles (m), for bodies that are not at rest where they start.
  std::vector<Vec3> rest_corners{};
  std::vector<double> parameters{};  // of each element; empty: that of the constraint
};

struct ListedElements {
  Elements all;
  /// The rest of the mesh, for the Remainder of the constraint kind: for winged triangles it has the hinges that belong
  /// to none of them, with their softness. For other elements it is empty.
  Elements remainder;
  int non_manifold = 0;  // number of edges with more than two triangles, which have no hinge
};

/// Appends elements and their softness.
template <class List>
void add_to(Elements& elements, const List& list, const std::vector<double>& softness) {
  for (const auto& one : list) elements.particles.insert(elements.particles.end(), one.begin(), one.end());
  elements.softness.insert(elements.softness.end(), softness.begin(), softness.end());
}

/// Lists the elements of the body's mesh for a constraint. `spec.elements` selects among edges; `spec.rigidity` is that
/// of the material. `shear` is the rigidity of the diagonals of quads over that of the edges, see edge_softness().
ListedElements list_elements(Element element, const Body& body, const ConstraintSpec& spec, double shear) {
  const Mesh& mesh = body.mesh;
  const RestShape shape = body.shape();
  ListedElements listed;
  const auto add = [&listed](const auto& list, const std::vector<double>& softness = {}) {
    add_to(listed.all, list, softness);
  };
  const bool material = spec.rigidity.has_value();
  switch (element) {  // without a default, so that the compiler reports a missing element
    case Element::Edges:
      for (const std::string& on : spec.elements)
        if (on == "shear")
          add(malha::shear(mesh), material ? shear_softness(shape.places()) : std::vector<double>{});
        else
          add(body.edges, material ? edge_softness(shape, body.edges, shear) : std::vector<double>{});
      break;
    case Element::Hinges:
      if (material) {
        const PlateHinges of_plate = plate_hinges(shape, body.boundary.pinned);
        listed.non_manifold = of_plate.non_manifold;
        add(of_plate.list, of_plate.softness);
      } else {
        add(hinges(mesh, &listed.non_manifold));
      }
      break;
    case Element::Triangles:
      add(triangles(mesh));
      break;
    case Element::Tetrahedra:
      add(mesh.tetrahedra);
      break;
    case Element::WingedTriangles: {
      const WingedTriangles winged = winged_triangles(shape, body.boundary.pinned);
      listed.non_manifold = winged.non_manifold;
      add(winged.list, winged.softness);
      add_to(listed.remainder, winged.hinges, winged.hinge_softness);
      if (const std::optional<Orthotropic> two_moduli = orthotropic_of(spec))
        for (std::size_t k = 0; k < winged.hinges.size(); ++k)
          listed.remainder.softness[k] /= rigidity_across(shape, winged.hinges[k], *two_moduli);
      break;
    }
    case Element::SewnPairs:
    case Element::AttachedPoints:
      break;  // those of the scene's seams
  }
  return listed;
}

/// With more groups of pins than this, each particle is attached to its nearest pin only.
constexpr int kMostPinGroups = 8;

/// The pins of each connected group, or one group of all pins if there are more than kMostPinGroups.
std::vector<std::vector<int>> pin_groups(const std::vector<Edge>& edges, const std::vector<bool>& pinned) {
  std::vector<Edge> between;
  for (const Edge& e : edges)
    if (pinned[e[0]] && pinned[e[1]]) between.push_back(e);
  const int n = static_cast<int>(pinned.size());
  int parts = 0;
  const std::vector<int> part = components(n, between, parts);
  std::vector<int> group_of(parts, -1);
  std::vector<std::vector<int>> groups;
  std::vector<int> all;
  for (int i = 0; i < n; ++i) {
    if (!pinned[i]) continue;
    all.push_back(i);
    int& group = group_of[part[i]];
    if (group < 0) group = static_cast<int>(groups.size()), groups.emplace_back();
    groups[group].push_back(i);
  }
  if (static_cast<int>(groups.size()) > kMostPinGroups) groups = {all};
  return groups;
}

/// Adds attachments for every movable particle of a body that is connected with a pin. It is attached to the nearest
/// pin of each group of connected pins (a row of pins is one group, two corners are two), at a distance of at most (1 +
/// limit) times the geodesic distance at rest. Point i of the mesh is the particle solver_index[i].
void attach_long_range(const RestShape& shape, const std::vector<Edge>& edges, const std::vector<bool>& pinned,
                       double limit, const std::vector<int>& solver_index, LongRangeSet& set) {
  std::vector<Geodesics> of_groups;
  for (const std::vector<int>& group : pin_groups(edges, pinned)) of_groups.push_back(geodesics(shape, group));
  if (set.begin.empty()) set.begin = {0};
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    if (pinned[i]) continue;
    std::vector<std::pair<double, int>> found;
    for (const Geodesics& group : of_groups)
      if (group.source[i] >= 0) found.emplace_back(group.distance[i], group.source[i]);
    if (found.empty()) continue;
    std::sort(found.rbegin(), found.rend());
    set.particle.push_back(solver_index[i]);
    for (const auto& [distance, pin] : found)
      set.anchor.push_back(solver_index[pin]), set.max_distance.push_back(distance * (1 + limit));
    set.begin.push_back(static_cast<int>(set.anchor.size()));
  }
}

/// Makes a spring of each constraint, of which x are the start positions (m). The stiffness is 1 / compliance, or with
/// a rigidity that over the `softness` of the constraint; without either it is the constraint's stiffness times `full`
/// (N/m).
SpringSet springs_of(const ConstraintSpec& spec, double full, const Elements& all, const std::vector<Vec3>& x) {
  SpringSet set{spec.type, {}, {}, {}};
  for (std::size_t c = 0; c < all.particles.size() / 2; ++c) {
    const Edge ends{all.particles[2 * c], all.particles[2 * c + 1]};
    if (ends[0] == ends[1]) continue;
    const double alpha = spec.rigidity ? all.softness[c] / *spec.rigidity
                                       : spec.compliance.value_or(0) * (all.softness.empty() ? 1 : all.softness[c]);
    const double k = alpha > 0 ? 1 / alpha : spec.compliance || spec.rigidity ? full : spec.stiffness * full;
    if (!(k > 0)) continue;
    set.ends.push_back(ends), set.stiffness.push_back(k);
    const bool has_own = !all.rest_corners.empty();
    const Vec3 &a = has_own ? all.rest_corners[2 * c] : x[ends[0]],
               &b = has_own ? all.rest_corners[2 * c + 1] : x[ends[1]];
    set.rest.push_back((all.parameters.empty() ? spec.parameter : all.parameters[c]) * distance(a, b));
  }
  return set;
}

/// Gives stencils without compliance one: 1 / (stiffness full lever^2), as of a spring of stiffness times `full` (N/m)
/// that acts through the stencil's lever. Stencils without a lever or stiffness are removed from the set.
void soften_by_levers(const Model& model, ConstraintSet& set, double full) {
  std::vector<int> kept;
  std::vector<Vec3> kept_corners;
  std::vector<double> kept_parameters;
  set.compliance = 1, set.softness.clear();
  with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
    if constexpr (Kind::strength.accepts_stiffness)
      for (int c = 0; c < set.count(); ++c) {
        const std::size_t first = std::size_t(c) * set.arity;
        Vector3<double> q[Kind::particles];
        rest_positions(model, set).corners<Kind>(c, q);
        const double lever = Stencil::lever(q), k = set.stiffness * full * lever * lever;
        if (!(k > 0)) continue;
        set.softness.push_back(1 / k);
        if (!set.parameters.empty()) kept_parameters.push_back(set.parameters[c]);
        for (std::size_t j = first; j < first + set.arity; ++j) {
          kept.push_back(set.particles[j]);
          if (!set.rest_corners.empty()) kept_corners.push_back(set.rest_corners[j]);
        }
      }
  });
  set.particles = std::move(kept), set.rest_corners = std::move(kept_corners);
  set.parameters = std::move(kept_parameters);
}

/// Softens stencils whose stiffness k at a corner of mass m makes h^2 k / m larger than 1e5 in float, 1e12 in double,
/// if they are also over 1,000 times as stiff as the median one. Those of triangles that are almost flat have unbounded
/// weights, and would cost the filter the digits of all others.
void limit_contrast(const Model& model, ConstraintSet& set) {
  constexpr double most_times = 1e3;
  const SolverSpec& solver = model.scene.solver;
  const double h = solver.dt / solver.substeps, most = solver.precision == Precision::Float ? 1e5 : 1e12;
  std::vector<double> stiffest, limit;
  with_stencil(set, [&]<class Kind, class Stencil>(Kind, Stencil) {
    for (int c = 0; c < set.count(); ++c) {
      stiffest.push_back(stencil_of<Kind>(model, set, c).stiffest());
      double w = 0;
      for (int j = 0; j < Kind::particles; ++j)
        w = std::max(w, model.w[set.particles[std::size_t(c) * Kind::particles + j]]);
      limit.push_back(w > 0 ? most / (h * h * w) : std::numeric_limits<double>::infinity());
    }
  });
  const double usual = most_times * median(stiffest);
  if (!(usual > 0)) return;
  for (int c = 0; c < set.count(); ++c) {
    const double allowed = std::max(usual, limit[c]);
    if (stiffest[c] <= allowed) continue;
    if (set.softness.empty()) set.softness.assign(set.count(), 1);
    set.softness[c] *= stiffest[c] / allowed;
  }
}

class ConstraintBuilder {
 public:
  ConstraintBuilder(Model& model, std::vector<Body>& bodies, const std::vector<Joints>& joints,
                    const std::vector<int>& solver_of, bool torn)
      : model_(model),
        bodies_(bodies),
        joints_(joints),
        solver_of_(solver_of),
        torn_(torn),
        sets_of_body_(bodies.size()) {
    if (joints.empty()) return;
    place_ = places_of_particles(static_cast<int>(solver_of.size()), joints);
    find_sewn_bodies();
  }

  /// Adds the constraints kind by kind in the registry's order, so that sweeps do not depend on the order in the scene.
  /// Sets that bodies share keep each body's order (find_set).
  void run() {
    if (!torn_)
      for (std::size_t b = 0; b < bodies_.size(); ++b) note_anisotropy(b);
    for_each_constraint([this]<class Kind>(Kind) {
      if (!is_of_mesh<Kind>()) return add_joints<Kind>();
      each_spec(name_in_scenes<Kind>(), [this](std::size_t b, const ConstraintSpec& spec, const std::string& place) {
        if (spec.orthotropy.has_value() != std::is_same_v<Material<Kind>, Orthotropic>) return;
        ConstraintSpec of = spec;
        of.type = Kind::name;
        const auto c = static_cast<std::size_t>(&spec - model_.scene.bodies[b].constraints.data());
        if (of.orthotropy) of.orthotropy->along = direction_along(b, *spec.orthotropy, place);
        add_set<Kind>(b, of, bodies_[b].maps[c], place);
      });
    });
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (bodies_[b].mesh.tetrahedra.empty()) continue;
      model_.tetrahedra.push_back(std::move(bodies_[b].mesh.tetrahedra));
      for (Tetrahedron& t : model_.tetrahedra.back())
        for (int& corner : t) corner = solver_of_[model_.render_mesh.body_begin[b] + corner];
    }
    each_spec("pressure", [this](std::size_t b, const ConstraintSpec& spec, const std::string& place) {
      std::vector<std::size_t> with = bodies_with(b, spec, place);
      with.size() > 1 || is_sewn_to_itself(b) ? add_joined_pressure(std::move(with), spec, place)
                                              : add_pressure(b, spec);
    });
    each_spec("long_range", [this](std::size_t b, const ConstraintSpec& spec, const std::string& place) {
      add_long_range(b, spec, place);
    });
    if (model_.scene.wind && model_.scene.wind->density > 0) add_air();
  }

 private:
  template <class F>
  void each_spec(const std::string& type, F&& f) {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const auto& specs = model_.scene.bodies[b].constraints;
      for (std::size_t c = 0; c < specs.size(); ++c)
        if (specs[c].type == type) f(b, specs[c], pointer("bodies", b, "constraints/") + std::to_string(c));
    }
  }

  /// The direction of an orthotropic material in the space of the rest positions, which the body's transform turns
  /// unless its rest shape is one of its own. Refuses one that leaves a triangle without a direction.
  Vec3 direction_along(std::size_t b, const Orthotropy& material, const std::string& place) const {
    const auto turned = [&](const Vec3& along) {
      Mesh line;
      line.points = {{0, 0, 0}, along};
      if (!model_.scene.bodies[b].rest) apply(model_.scene.bodies[b].transform, line);
      return minus(line.points[1], line.points[0]);
    };
    const std::vector<Triangle> all = triangles(bodies_[b].mesh);
    const RestShape shape = bodies_[b].shape();
    const auto is_across = [&](const Triangle& t, const Vec3& along) {
      Vec3 X[3];
      shape.corners(Element::Triangles, t.data(), X);
      const Vec3 n = normal(X[0], X[1], X[2]);
      return norm(n) > 0 && norm(cross(n, along)) <= 1e-6 * norm(n) * norm(along);
    };
    const Triangle* across = nullptr;
    for (const Vec3& axis : material.along ? std::vector<Vec3>{*material.along}
                                           : std::vector<Vec3>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}) {
      const Vec3 along = turned(axis);
      const auto found = std::ranges::find_if(all, [&](const Triangle& t) { return is_across(t, along); });
      if (found == all.end()) return along;
      across = &*found;
    }
    const auto vertex = [&](int k) { return std::to_string(vertex_of(bodies_[b].mesh.vertices, (*across)[k])); };
    refuse(model_.scene.file, place + "/along",
           "a direction that is perpendicular to the triangle of the vertices " + vertex(0) + ", " + vertex(1) +
               " and " + vertex(2) + " (body '" + model_.scene.bodies[b].name + "')",
           "a direction that is perpendicular to none");
  }

  template <class Kind>
  void add_set(std::size_t b, const ConstraintSpec& spec, const ConstraintMaps& maps, const std::string& place) {
    auto [all, remainder, non_manifold] = list_elements(Kind::element, bodies_[b], spec, shear_of(b));
    if (non_manifold > 0) note_crowded(b, Kind::name, non_manifold);
    if (all.particles.empty() && remainder.particles.empty()) {
      if (torn_) return;  // the body may be torn to pieces without elements
      refuse(model_.scene.file, place, "a mesh without elements for " + std::string(Kind::name),
             facts_of(Kind::element).needed);
    }
    multiply_stiffness(maps.stiffness, Kind::particles, all);
    multiply_parameter<Kind>(maps.parameter, spec, all);
    to_solver_order(b, all, Kind::element);
    const bool filtered = is_filtered<Kind>(spec, all);
    add_elements<Kind>(b, spec, std::move(all), filtered);
    if constexpr (requires { typename Kind::Remainder; }) {
      ConstraintSpec other = spec;
      other.type = Kind::Remainder::name, other.parameter = Kind::Remainder::parameter.default_value;
      other.orthotropy = {};  // which is in the softness
      multiply_stiffness(maps.stiffness, Kind::Remainder::particles, remainder);
      to_solver_order(b, remainder, Kind::Remainder::element);
      add_elements<typename Kind::Remainder>(b, other, std::move(remainder), filtered);
    }
  }

  /// The sum of a map at the particles of each element.
  static std::vector<double> sums_of(const std::vector<double>& map, int arity, const Elements& all) {
    std::vector<double> sums(all.particles.size() / static_cast<std::size_t>(arity), 0);
    for (std::size_t k = 0; k < all.particles.size(); ++k)
      sums[k / static_cast<std::size_t>(arity)] += map[all.particles[k]];
    return sums;
  }

  /// Multiplies the stiffness of each element by the mean of a map, unless it is empty, at its particles.
  static void multiply_stiffness(const std::vector<double>& map, int arity, Elements& all) {
    if (map.empty()) return;
    const std::vector<double> sums = sums_of(map, arity, all);
    if (all.softness.empty()) all.softness.assign(sums.size(), 1);
    for (std::size_t c = 0; c < sums.size(); ++c) all.softness[c] *= arity / sums[c];
  }

  /// The same for the parameter of each element, and for the compliance that it changes with it.
  template <class Kind>
  static void multiply_parameter(const std::vector<double>& map, const ConstraintSpec& spec, Elements& all) {
    if (map.empty()) return;
    for (const double sum : sums_of(map, Kind::particles, all))
      all.parameters.push_back(spec.parameter * (sum / Kind::particles));
    if constexpr (!Kind::strength.accepts_stiffness) {
      const auto softer = [&](double parameter) {
        return Kind::compliance(1, parameter) / Kind::compliance(1, spec.parameter);
      };
      if (std::ranges::all_of(all.parameters, [&](double parameter) { return softer(parameter) == 1; })) return;
      all.softness.resize(all.parameters.size(), 1);
      for (std::size_t c = 0; c < all.softness.size(); ++c) all.softness[c] *= softer(all.parameters[c]);
    }
  }

  /// Leaves out elements whose particles are all pinned, finds where the others rest, and numbers their particles in
  /// the solver's order.
  void to_solver_order(std::size_t b, Elements& all, Element element) const {
    const int arity = facts_of(element).particles;
    drop_pinned(all, arity, bodies_[b].boundary.pinned);
    if (bodies_[b].rest) {
      const RestShape shape = bodies_[b].shape();
      all.rest_corners.resize(all.particles.size());
      for (std::size_t c = 0; c < all.particles.size(); c += arity)
        shape.corners(element, &all.particles[c], &all.rest_corners[c]);
    }
    for (int& i : all.particles) i = solver_of_[model_.render_mesh.body_begin[b] + i];
  }

  /// Returns whether elements are in the solver's filter instead of a set that is projected. By PBD these are bending
  /// of a given modulus, which is filtered where it would be too soft if it was projected.
  template <class Kind>
  bool is_filtered(const ConstraintSpec& spec, const Elements& all) const {
    const SolverSpec& solver = model_.scene.solver;
    if (Kind::filtered != Filtered::Stencil || all.particles.empty()) return false;
    if (solver.type == "desbrun") return true;
    const std::optional<double> compliance = compliance_of<Kind>(spec);
    if (!bends<Kind>() || !(compliance.value_or(0) > 0) || solver.bending == BendingMethod::Projected) return false;
    if (solver.bending == BendingMethod::Filtered) return true;
    constexpr double tolerated = 0.03;
    const BendingStep step = bending_step(model_, set_of<Kind>(spec, all));
    return step.softening > tolerated && step.turning <= kMostTurning &&
           (solver.precision == Precision::Double || step.s <= kMostInFloat);
  }

  template <class Kind>
  static ConstraintSet set_of(const ConstraintSpec& spec, Elements all) {
    return {spec.type,
            Kind::particles,
            spec.stiffness,
            compliance_of<Kind>(spec),
            spec.parameter,
            std::move(all.particles),
            std::move(all.softness),
            {},
            std::move(all.rest_corners),
            false,
            orthotropic_of(spec),
            0,
            std::move(all.parameters)};
  }

  /// The rigidity of the body's diagonals over that of its edges.
  double shear_of(std::size_t b) const {
    double edges = 0, diagonals = 0;
    for (const ConstraintSpec& spec : model_.scene.bodies[b].constraints)
      if (spec.type == "distance" && spec.rigidity)
        for (const std::string& on : spec.elements) (on == "shear" ? diagonals : edges) += *spec.rigidity;
    return edges > 0 ? diagonals / edges : 0;
  }

  /// Adds a note if the mesh is not isotropic: in some direction over 1.5 times as stiff or as soft as its rigidity.
  void note_anisotropy(std::size_t b) {
    constexpr double tolerated = 1.5;
    const Body& body = bodies_[b];
    if (!body.mesh.tetrahedra.empty()) return;
    // A pattern with seams has no place for each point; the start has about its angles.
    const Mesh& mesh = body.shape().has_seams() ? body.mesh : body.shape().places();
    const auto note = [&](const std::string& type, const Isotropy& found, const std::string& cells,
                          const char* instead) {
      if (found.softest * tolerated >= 1 && found.stiffest <= tolerated) return;
      model_.notes.push_back("body '" + model_.scene.bodies[b].name + "': its \"" + type + "\" is " +
                             shown(two_digits(found.softest)) + " to " + shown(two_digits(found.stiffest)) +
                             " times as stiff as its \"rigidity\" says, by direction, on " + cells + "; take \"" +
                             instead + "\" (scenes/README.md, Materials)");
    };
    std::vector<Edge> springs;
    std::vector<double> stiffness;
    double Y = 0, G = 0;
    for (const ConstraintSpec& spec : model_.scene.bodies[b].constraints) {
      if (!spec.rigidity) continue;
      if (spec.type == "distance") {
        const Elements all = list_elements(Element::Edges, body, spec, shear_of(b)).all;
        for (std::size_t e = 0; e < all.softness.size(); ++e)
          springs.push_back({all.particles[2 * e], all.particles[2 * e + 1]}),
              stiffness.push_back(*spec.rigidity / all.softness[e]);
        for (const std::string& on : spec.elements) (on == "shear" ? G : Y) += *spec.rigidity;
      } else if (spec.type == "bending" || spec.type == "isometric_bending") {
        const PlateHinges hinges = plate_hinges(body.shape(), std::vector<bool>(body.mesh.points.size()));
        note(spec.type, isotropy_of_hinges(mesh, hinges.list, hinges.softness), "cells like these", "plate");
      }
    }
    if (Y > 0)
      note("distance", isotropy_of_springs(mesh, springs, stiffness, Y, G),
           G > 0 ? "cells that are so much longer than wide, or askew" : "triangles like these", "membrane");
  }

  void note_crowded(std::size_t b, const std::string& kind, int edges) {
    model_.notes.push_back("body '" + model_.scene.bodies[b].name + "': \"" + kind + "\" does not act at " +
                           counted(edges, "edge") + " with more than two faces, about which the sheet turns freely");
  }

  template <class Kind>
  void add_elements(std::size_t b, const ConstraintSpec& spec, Elements all, bool filtered) {
    if (all.particles.empty()) return;
    const SolverSpec& solver = model_.scene.solver;
    const std::optional<double> compliance = compliance_of<Kind>(spec);
    if (solver.type == "desbrun" && Kind::filtered == Filtered::Spring) {
      SpringSet springs = springs_of(spec, solver.desbrun.spring_constant, all, model_.x);
      if (!springs.ends.empty()) model_.springs.push_back(std::move(springs));
      return;
    }
    if (filtered) {
      ConstraintSet set = set_of<Kind>(spec, std::move(all));
      if (!(compliance.value_or(0) > 0)) soften_by_levers(model_, set, solver.desbrun.spring_constant);
      if (solver.type == "pbd") limit_contrast(model_, set);
      if (set.count() > 0) model_.stencils.push_back(std::move(set));
      return;
    }
    const bool pressed = is_pressed(b);
    ConstraintSet& set = find_set(b, spec, Kind::particles, compliance, all, pressed);
    set.particles.insert(set.particles.end(), all.particles.begin(), all.particles.end());
    set.softness.insert(set.softness.end(), all.softness.begin(), all.softness.end());
    set.rest_corners.insert(set.rest_corners.end(), all.rest_corners.begin(), all.rest_corners.end());
    set.parameters.insert(set.parameters.end(), all.parameters.begin(), all.parameters.end());
  }

  /// Tells whether a pressure acts on a body, its own or that of another body with it.
  bool is_pressed(std::size_t b) const {
    const std::vector<BodySpec>& all = model_.scene.bodies;
    for (std::size_t other = 0; other < all.size(); ++other)
      for (const ConstraintSpec& spec : all[other].constraints)
        if (spec.type == "pressure" && (other == b || std::ranges::find(spec.with, all[b].name) != spec.with.end()))
          return true;
    return false;
  }

  /// Removes elements whose particles are all pinned.
  static void drop_pinned(Elements& all, int arity, const std::vector<bool>& pinned) {
    std::size_t kept = 0;
    for (std::size_t c = 0; c < all.particles.size() / arity; ++c) {
      const int* of = &all.particles[c * arity];
      if (std::all_of(of, of + arity, [&](int i) { return pinned[i]; })) continue;
      std::copy_n(of, arity, &all.particles[kept * arity]);
      for (std::vector<double>* each : {&all.softness, &all.parameters})
        if (!each->empty()) (*each)[kept] = (*each)[c];
      ++kept;
    }
    all.particles.resize(kept * arity);
    for (std::vector<double>* each : {&all.softness, &all.parameters})
      if (!each->empty()) each->resize(kept);
  }

  /// The compliance of a constraint, given or from the modulus of its material.
  template <class Kind>
  static std::optional<double> compliance_of(const ConstraintSpec& spec) {
    if constexpr (!Kind::strength.accepts_stiffness)
      return Kind::compliance(spec.rigidity ? *spec.rigidity : spec.young_modulus.value(), spec.parameter);
    return spec.rigidity ? std::optional<double>(1 / *spec.rigidity) : spec.compliance;
  }

  /// The set of all bodies with such constraints, or a new one. A set that comes before another one of body b is not
  /// taken, because the body alone would have them in the other order.
  ConstraintSet& find_set(std::size_t b, const ConstraintSpec& spec, int arity, std::optional<double> compliance,
                          const Elements& all, bool pressed) {
    const bool is_softened = !all.softness.empty(), rests_elsewhere = !all.rest_corners.empty();
    const bool has_parameters = !all.parameters.empty();
    std::vector<std::size_t>& own = sets_of_body_[b];
    for (std::size_t k = 0; k < model_.sets.size(); ++k) {
      ConstraintSet& set = model_.sets[k];
      const bool is_own = std::ranges::find(own, k) != own.end();
      if ((!is_own && !own.empty() && k < own.back()) || set.type != spec.type || set.stiffness != spec.stiffness ||
          set.compliance != compliance || set.parameter != spec.parameter || set.softness.empty() == is_softened ||
          set.rest_corners.empty() == rests_elsewhere || set.parameters.empty() == has_parameters ||
          set.pressed != pressed || set.orthotropic != orthotropic_of(spec))
        continue;
      if (!is_own) own.push_back(k);
      return set;
    }
    own.push_back(model_.sets.size());
    return model_.sets.emplace_back(ConstraintSet{
        spec.type, arity, spec.stiffness, compliance, spec.parameter, {}, {}, {}, {}, pressed, orthotropic_of(spec)});
  }

  void add_pressure(std::size_t b, const ConstraintSpec& spec) {
    const Mesh& mesh = bodies_[b].mesh;
    require_rest_volume(b);
    require_closed(mesh, origin(model_.scene, model_.scene.bodies[b].shape),
                   "pressure needs a closed mesh (body '" + model_.scene.bodies[b].name + "')");
    PressureSet set{spec.parameter, spec.stiffness, spec.compliance, {}, triangles(mesh)};
    for (Triangle& t : set.triangles)
      for (int& corner : t) corner = solver_of_[model_.render_mesh.body_begin[b] + corner];
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      set.particles.push_back(solver_of_[model_.render_mesh.body_begin[b] + i]);
    model_.pressures.push_back(std::move(set));
  }

  /// Refuses a pressure in a body whose rest mesh encloses nothing, as that of a flat pattern does.
  void require_rest_volume(std::size_t b) const {
    const std::vector<Vec3>* const places = places_at_rest(model_.scene.bodies[b], bodies_[b]);
    if (!places) return;
    if (const double V = signed_volume(*places, triangles(bodies_[b].mesh)); !(V > 0))
      refuse(model_.scene.file, pointer("bodies", b, "rest"),
             "a rest shape that encloses " + shown(V) + " m^3, of a body with pressure",
             "a rest shape with a volume, or \"uv\", with which pressure refers to the volume at the start");
  }

  /// Body b and those with which it encloses the volume of a pressure.
  std::vector<std::size_t> bodies_with(std::size_t b, const ConstraintSpec& spec, const std::string& place) const {
    std::vector<std::size_t> all{b};
    std::vector<std::string> names;
    for (const BodySpec& body : model_.scene.bodies) names.push_back(body.name);
    for (std::size_t k = 0; k < spec.with.size(); ++k) {
      const auto found = static_cast<std::size_t>(std::ranges::find(names, spec.with[k]) - names.begin());
      const std::string here = place + "/with/" + std::to_string(k);
      if (found == names.size())
        refuse(model_.scene.file, here, "unknown body '" + spec.with[k] + "'" + did_you_mean(spec.with[k], names),
               join(names));
      if (std::ranges::find(all, found) != all.end())
        refuse(model_.scene.file, here, "'" + spec.with[k] + "' a second time", "each of the other bodies once");
      all.push_back(found);
    }
    return all;
  }

  bool is_sewn_to_itself(std::size_t b) const {
    const std::vector<int>& begin = model_.render_mesh.body_begin;
    const auto is_own = [&](int i) { return begin[b] <= i && i < begin[b + 1]; };
    return std::ranges::any_of(joints_, [&](const Joints& one) {
      return !one.to_surface && is_own(one.particles[0]) && is_own(one.particles[1]);
    });
  }

  /// A pressure in what seams close. Particles at one place are one point of its mesh, that of the lowest of them, and
  /// move as one.
  void add_joined_pressure(std::vector<std::size_t> with, const ConstraintSpec& spec, const std::string& place) {
    if (place_.empty())
      refuse(model_.scene.file, place + "/with", "bodies that no seam joins", "a scene with \"seams\"");
    const JoinedMesh joined = malha::join(bodies_, with, place_, model_.render_mesh.body_begin);
    require_closed(joined, model_.scene.file, place, [this](int user) { return name_of(user); });
    PressureSet set{spec.parameter, spec.stiffness, spec.compliance, {}, triangles(joined.mesh)};
    for (Triangle& t : set.triangles)
      for (int& corner : t) corner = solver_of_[joined.particles[corner][0]];
    for (const std::vector<int>& all : joined.particles) {
      set.particles.push_back(solver_of_[all[0]]);
      for (std::size_t k = 1; k < all.size(); ++k) set.followers.push_back({solver_of_[all[0]], solver_of_[all[k]]});
    }
    model_.pressures.push_back(std::move(set));
  }

  std::string name_of(int user) const {
    const auto& begin = model_.render_mesh.body_begin;
    const auto b = static_cast<std::size_t>(std::ranges::upper_bound(begin, user) - begin.begin() - 1);
    return "particle " + std::to_string(vertex_of(bodies_[b].mesh.vertices, user - begin[b])) + " of body '" +
           model_.scene.bodies[b].name + "'";
  }

  /// Adds the joints of this kind, those of all seams that are alike to one set.
  template <class Kind>
  void add_joints() {
    const std::size_t first = model_.sets.size();
    for (const Joints& one : joints_) {
      if (one.to_surface != std::is_same_v<Kind, SurfaceAttachment>) continue;
      const auto is_alike = [&](const ConstraintSet& set) {
        return set.compliance == one.compliance && set.per_closing == one.per_closing;
      };
      auto set = std::find_if(model_.sets.begin() + static_cast<std::ptrdiff_t>(first), model_.sets.end(), is_alike);
      if (set == model_.sets.end()) {
        set = model_.sets.insert(set, ConstraintSet{Kind::name, Kind::particles, 1, one.compliance, 1, {}, {}});
        set->per_closing = one.per_closing;
      }
      for (const int i : one.particles) set->particles.push_back(solver_of_[i]);
    }
  }

  /// Finds the bodies that seams connect with each body.
  void find_sewn_bodies() {
    DisjointSets groups(static_cast<int>(bodies_.size()));
    const auto& begin = model_.render_mesh.body_begin;
    const auto body = [&](int user) {
      return static_cast<int>(std::ranges::upper_bound(begin, user) - begin.begin()) - 1;
    };
    for (const Joints& one : joints_)
      if (!one.to_surface) groups.join(body(one.particles[0]), body(one.particles[1]));
    sewn_with_.resize(bodies_.size());
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      for (std::size_t other = 0; other < bodies_.size(); ++other)
        if (groups.root(static_cast<int>(b)) == groups.root(static_cast<int>(other))) sewn_with_[b].push_back(other);
  }

  /// The solver's particles of a body.
  std::vector<int> solver_particles(std::size_t b) const {
    const auto first = solver_of_.begin() + model_.render_mesh.body_begin[b];
    return {first, first + static_cast<std::ptrdiff_t>(bodies_[b].mesh.points.size())};
  }

  /// Tells whether tethers of a body run over the seams to pins of other bodies.
  bool has_tethers_over_seams(std::size_t b) const {
    if (sewn_with_.empty() || (sewn_with_[b].size() == 1 && !is_sewn_to_itself(b))) return false;
    return std::ranges::all_of(sewn_with_[b], [this](std::size_t one) {
      return bodies_[one].mesh.lines.empty() && bodies_[one].mesh.tetrahedra.empty() &&
             !bodies_[one].mesh.faces.empty();
    });
  }
  /// Attaches the particles of a body to the pins of all that seams join with it. What a seam has not closed yet does
  /// not pull: no tether is shorter than the distance at the start.
  void attach_over_seams(std::size_t b, double limit) {
    const std::vector<int>& begin = model_.render_mesh.body_begin;
    const JoinedMesh joined = malha::join(bodies_, sewn_with_[b], place_, begin);
    std::vector<int> solver_index;  // of each point: a pinned particle if there is one, or else one of the body
    std::vector<bool> pinned, own;
    for (const std::vector<int>& all : joined.particles) {
      const auto is_pinned = [&](int i) { return model_.w[solver_of_[i]] == 0; };
      const auto is_own = [&](int i) { return begin[b] <= i && i < begin[b + 1]; };
      const auto pin = std::ranges::find_if(all, is_pinned), of_body = std::ranges::find_if(all, is_own);
      pinned.push_back(pin != all.end()), own.push_back(of_body != all.end());
      solver_index.push_back(solver_of_[pin != all.end() ? *pin : of_body != all.end() ? *of_body : all[0]]);
    }
    LongRangeSet set;
    attach_long_range(joined.shape(), edges(joined.mesh), pinned, limit, solver_index, set);
    std::vector<bool> is_tethered(model_.x.size(), false);
    for (std::size_t k = 0; k < own.size(); ++k) is_tethered[solver_index[k]] = own[k];
    LongRangeSet& all = model_.long_range;
    if (all.begin.empty()) all.begin = {0};
    for (int k = 0; k < set.items(); ++k) {
      const int i = set.particle[k];
      if (!is_tethered[i]) continue;
      all.particle.push_back(i);
      for (int a = set.begin[k]; a < set.begin[k + 1]; ++a) {
        const double start = distance(model_.x[i], model_.x[set.anchor[a]]);
        all.anchor.push_back(set.anchor[a]), all.max_distance.push_back(std::max(set.max_distance[a], start));
      }
      all.begin.push_back(static_cast<int>(all.anchor.size()));
    }
  }

  void add_long_range(std::size_t b, const ConstraintSpec& spec, const std::string& place) {
    const Body& body = bodies_[b];
    const int before = model_.long_range.items();
    if (has_tethers_over_seams(b))
      attach_over_seams(b, spec.parameter);
    else
      attach_long_range(body.shape(), body.edges, body.boundary.pinned, spec.parameter, solver_particles(b),
                        model_.long_range);
    if (model_.long_range.items() > before) return;
    const auto& pinned = body.boundary.pinned;
    if (std::ranges::find(pinned, false) == pinned.end()) return;
    const bool has_pin = std::ranges::find(pinned, true) != pinned.end();
    const bool released =
        std::ranges::any_of(body.boundary.moved, [](const auto& m) { return m.release_time.has_value(); });
    refuse(model_.scene.file, place,
           std::string(has_pin ? "no particle that is connected with a pin" : "no pin") +
               (released ? " but those with a \"release_time\"" : ""),
           "long-range attachments on a body with pins without \"release_time\"");
  }

  void add_air() {
    for (std::size_t b = 0; b < bodies_.size(); ++b) add_air_faces(bodies_[b].mesh, solver_particles(b), model_.air);
    if (model_.air.particle.empty())
      refuse(model_.scene.file, "/wind/density", "air on the faces of bodies without faces",
             "a body with faces, or 'drag' alone");
  }

  Model& model_;
  std::vector<Body>& bodies_;
  const std::vector<Joints>& joints_;
  const std::vector<int>& solver_of_;
  bool torn_;
  std::vector<std::vector<std::size_t>> sets_of_body_;  // of each body, in the order of projection
  std::vector<int> place_;                              // see places_of_particles(); empty without seams
  std::vector<std::vector<std::size_t>> sewn_with_;     // the bodies of each body's component; empty without seams
};

}  // namespace

void build_constraints(Model& model, std::vector<Body>& bodies, const std::vector<Joints>& joints,
                       const std::vector<int>& solver_of, bool torn) {
  ConstraintBuilder(model, bodies, joints, solver_of, torn).run();
}

void add_air_faces(const Mesh& mesh, const std::vector<int>& solver_index, AirFaces& all) {
  std::vector<std::vector<int>> incident(mesh.points.size());
  for (Quad face : mesh.faces) {
    for (int& corner : face) {
      if (corner < 0) continue;
      incident[corner].push_back(static_cast<int>(all.faces.size()));
      corner = solver_index[corner];
    }
    all.faces.push_back(face);
  }
  if (all.begin.empty()) all.begin = {0};
  for (std::size_t i = 0; i < incident.size(); ++i) {
    if (incident[i].empty()) continue;
    all.particle.push_back(solver_index[i]);
    all.incident.insert(all.incident.end(), incident[i].begin(), incident[i].end());
    all.begin.push_back(static_cast<int>(all.incident.size()));
  }
}

}  // namespace malha
