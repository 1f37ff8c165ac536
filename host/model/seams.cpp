// SPDX-License-Identifier: Apache-2.0
#include "host/model/seams.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "host/base/disjoint_sets.h"
#include "host/mesh/closest_of_triangles.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/pins.h"
#include "kernels/constraints/constraint_registry.h"
#include "malha/error.h"
#include "malha/text.h"

namespace malha {

namespace {

/// The joints of one seam of the scene.
class SeamFinder {
 public:
  SeamFinder(const Scene& scene, const std::vector<Body>& bodies, const std::vector<int>& body_begin, std::size_t seam)
      : scene_(scene),
        bodies_(bodies),
        spec_(scene.seams[seam]),
        here_("/seams/" + std::to_string(seam)),
        from_(number_of(spec_.from.body)),
        to_(number_of(spec_.to.body)),
        first_from_(body_begin[from_]),
        first_to_(body_begin[to_]) {}

  Joints find() const {
    check_bodies();
    Joints joints{spec_.to.surface, 1 / std::max(spec_.closing, scene_.solver.dt), spec_.compliance, {}};
    if (spec_.to.surface)
      attach(selected(spec_.from, from_, "from"), joints);
    else
      for (const auto& [i, j] : pairs())
        joints.particles.push_back(first_from_ + i), joints.particles.push_back(first_to_ + j);
    drop_pinned(joints);
    if (joints.particles.empty())
      refuse(scene_.file, here_, "a seam of pinned particles alone", "at least one particle that can move");
    return joints;
  }

 private:
  static constexpr double kTogether = 1e-6;  // m: pinned particles at one place but for rounding

  std::size_t number_of(const std::string& body) const {
    const auto found = std::ranges::find(scene_.bodies, body, &BodySpec::name);
    return static_cast<std::size_t>(found - scene_.bodies.begin());
  }

  void check_bodies() const {
    const BodySpec &from = scene_.bodies[from_], &to = scene_.bodies[to_];
    for (const BodySpec* one : {&from, &to})
      if (one->tear)
        refuse(scene_.file, here_, "a seam of the body '" + one->name + "', which tears", "bodies without \"tear\"");
    if (from.damping != to.damping)
      refuse(scene_.file, here_,
             "bodies '" + from.name + "' and '" + to.name + "', whose \"damping\" differs: " + shown(from.damping) +
                 " and " + shown(to.damping),
             "the same damping of bodies that are sewn together, which move as one");
  }

  const Mesh& mesh(std::size_t body) const { return bodies_[body].mesh; }
  std::string name(std::size_t body, int point) const {
    return "particle " + std::to_string(vertex_of(mesh(body).vertices, point)) + " of body '" +
           scene_.bodies[body].name + "'";
  }
  std::vector<int> selected(const SeamEnd& end, std::size_t body, const std::string& key) const {
    return select_particles(scene_, body, mesh(body), *end.at, here_ + "/" + key, "an end with a particle");
  }

  /// The pairs of points of both meshes.
  std::vector<Edge> pairs() const {
    std::vector<Edge> pairs = spec_.within ? nearest_pairs() : listed_pairs();
    for (const auto& [i, j] : pairs)
      if (from_ == to_ && i == j)
        refuse(scene_.file, here_, name(from_, i) + " on both sides", "two particles of each pair");
    return pairs;
  }

  std::vector<Edge> listed_pairs() const {
    std::vector<int> from, to;
    for (const auto& [i, j] : spec_.pairs) from.push_back(i), to.push_back(j);
    from = points_of(scene_, mesh(from_), from, here_ + "/pairs"),
    to = points_of(scene_, mesh(to_), to, here_ + "/pairs");
    std::vector<Edge> pairs;
    for (std::size_t k = 0; k < from.size(); ++k) pairs.push_back({from[k], to[k]});
    return pairs;
  }

  /// Each particle with the nearest. Where both sides have as many, the nearest of all pairs are chosen first, and each
  /// particle once.
  std::vector<Edge> nearest_pairs() const {
    const std::vector<int> from = selected(spec_.from, from_, "from"), to = selected(spec_.to, to_, "to");
    struct Near {
      double d2;
      int i, j;
    };
    std::vector<Near> near;
    const double within2 = *spec_.within * *spec_.within * (1 + 1e-12);
    for (const int i : from) {
      double least2 = std::numeric_limits<double>::infinity();
      const std::size_t before = near.size();
      for (const int j : to) {
        const double d2 = squared_distance(mesh(from_).points[i], mesh(to_).points[j]);
        least2 = std::min(least2, d2);
        if (d2 <= within2) near.push_back({d2, i, j});
      }
      if (near.size() == before) refuse_partner(i, std::sqrt(least2));
    }
    std::ranges::sort(near, [](const Near& a, const Near& b) {
      return a.d2 != b.d2 ? a.d2 < b.d2 : a.i != b.i ? a.i < b.i : a.j < b.j;
    });
    const bool one_to_one = from.size() == to.size();
    std::vector<int> partner(mesh(from_).points.size(), -1);
    std::vector<bool> taken(mesh(to_).points.size(), false);
    for (const Near& pair : near) {
      if (partner[pair.i] >= 0 || (one_to_one && taken[pair.j])) continue;
      partner[pair.i] = pair.j, taken[pair.j] = true;
    }
    std::vector<Edge> pairs;
    for (const int i : from) {
      if (partner[i] < 0)
        refuse(scene_.file, here_ + "/within",
               name(from_, i) + ", all of whose near partners are nearer to other particles",
               "rows that lie along each other, as many particles as there are, or \"pairs\"");
      pairs.push_back({i, partner[i]});
    }
    return pairs;
  }

  [[noreturn]] void refuse_partner(int i, double least) const {
    refuse(scene_.file, here_ + "/within",
           name(from_, i) + ", which is " + shown(least) + " m from the nearest of 'to'",
           "particles at most " + shown(*spec_.within) + " m from one of 'to'");
  }

  /// Attaches particles to the closest points of the other body's surface.
  void attach(const std::vector<int>& from, Joints& joints) const {
    const std::vector<Triangle> all = triangles(mesh(to_));
    if (all.empty())
      refuse(scene_.file, here_ + "/to/surface", "the surface of '" + spec_.to.body + "', a body without faces",
             "a body with faces, or a selector");
    for (const int i : from) {
      const Vec3& p = mesh(from_).points[i];
      const ClosestOfTriangles closest = closest_of_triangles(all, mesh(to_).points, {p[0], p[1], p[2]});
      const double gap = std::sqrt(dot(closest.offset, closest.offset));
      if (!(gap <= *spec_.within)) refuse_partner(i, gap);
      joints.particles.push_back(first_from_ + i);
      for (const int corner : all[closest.triangle]) joints.particles.push_back(first_to_ + corner);
    }
  }

  /// Removes joints that cannot move, which must be closed. One free particle cannot be sewn to two pinned ones that
  /// are apart either.
  void drop_pinned(Joints& joints) const {
    const auto arity = static_cast<std::size_t>(joints.arity());
    const auto from = [&](std::size_t k) { return joints.particles[k] - first_from_; };
    const auto to = [&](std::size_t k) { return joints.particles[k] - first_to_; };
    const std::vector<bool>&from_pinned = bodies_[from_].boundary.pinned, &to_pinned = bodies_[to_].boundary.pinned;
    std::vector<int> kept;
    std::map<int, int> pin_of_from, pin_of_to;  // the pinned partner of a free particle
    for (std::size_t k = 0; k < joints.particles.size(); k += arity) {
      const bool from_moves = !from_pinned[from(k)];
      bool to_moves = false;
      for (std::size_t j = 1; j < arity; ++j) to_moves = to_moves || !to_pinned[to(k + j)];
      if (from_moves || to_moves) kept.insert(kept.end(), &joints.particles[k], &joints.particles[k] + arity);
      if (from_moves && to_moves) continue;
      if (!from_moves && !to_moves) {
        if (const double gap = gap_of(joints, k); gap > kTogether)
          refuse(scene_.file, here_,
                 name(from_, from(k)) + " and its partner in body '" + spec_.to.body + "', which pins hold " +
                     shown(gap) + " m apart",
                 "pairs of which a particle can move, or that are closed");
      } else if (!joints.to_surface && joints.compliance == 0) {
        if (from_moves)
          require_one_pin(pin_of_from, from_, from(k), to_, to(k + 1));
        else
          require_one_pin(pin_of_to, to_, to(k + 1), from_, from(k));
      }
    }
    joints.particles = std::move(kept);
  }
  void require_one_pin(std::map<int, int>& pins, std::size_t body, int point, std::size_t pinned_body, int pin) const {
    const auto [known, is_new] = pins.try_emplace(point, pin);
    const std::vector<Vec3>& x = mesh(pinned_body).points;
    if (is_new || distance(x[known->second], x[pin]) <= kTogether) return;
    refuse(scene_.file, here_,
           name(body, point) + ", which is sewn to " + name(pinned_body, known->second) + " and " +
               name(pinned_body, pin) + ", both pinned, " + shown(distance(x[known->second], x[pin])) + " m apart",
           "one of both");
  }
  /// The length of a joint at the start, m.
  double gap_of(const Joints& joints, std::size_t k) const {
    const auto at = [&](std::size_t body, int point) {
      const Vec3& x = mesh(body).points[point];
      return Vector3<double>{x[0], x[1], x[2]};
    };
    Vector3<double> X[4] = {at(from_, joints.particles[k] - first_from_)};
    for (int j = 1; j < joints.arity(); ++j) X[j] = at(to_, joints.particles[k + j] - first_to_);
    if (!joints.to_surface) return norm(X[0] - X[1]);
    double rest[3];
    SurfaceAttachment::rest(X, 1, rest);
    return rest[0];
  }

  const Scene& scene_;
  const std::vector<Body>& bodies_;
  const SeamSpec& spec_;
  std::string here_;
  std::size_t from_, to_;
  int first_from_, first_to_;
};

}  // namespace

std::vector<Joints> find_joints(const Scene& scene, const std::vector<Body>& bodies,
                                const std::vector<int>& body_begin) {
  std::vector<Joints> joints;
  if (scene.solver.type == "desbrun" && !scene.seams.empty())
    refuse(scene.file, "/seams", "seams under Desbrun's method, whose filter knows each body alone", "solver type pbd");
  for (std::size_t s = 0; s < scene.seams.size(); ++s)
    joints.push_back(SeamFinder(scene, bodies, body_begin, s).find());
  return joints;
}

std::vector<Edge> edges_of(const std::vector<Joints>& joints) {
  std::vector<Edge> edges;
  for (const Joints& one : joints)
    for (std::size_t k = 0; k < one.particles.size(); k += one.arity())
      for (int j = 1; j < one.arity(); ++j) edges.push_back({one.particles[k], one.particles[k + j]});
  return edges;
}

bool is_seam(const ConstraintSet& set) { return set.type == Seam::name || set.type == SurfaceAttachment::name; }

std::vector<int> places_of_particles(int particles, const std::vector<Joints>& joints) {
  DisjointSets places(particles);
  for (const Joints& one : joints)
    for (std::size_t k = 0; !one.to_surface && k < one.particles.size(); k += 2)
      places.join(one.particles[k], one.particles[k + 1]);
  std::vector<int> lowest(particles);
  for (int i = 0; i < particles; ++i) lowest[i] = places.root(i);
  return lowest;
}

namespace {

bool is_hard_seam(const ConstraintSet& set) { return set.type == Seam::name && set.compliance.value_or(0) == 0; }

/// The particles at the place of each particle, in the list of the lowest of them. `joins`: whether a set joins pairs
/// in one place.
template <class Joins>
std::vector<std::vector<int>> particles_at_places(const Model& model, DisjointSets& places, const Joins& joins) {
  for (const ConstraintSet& set : model.sets)
    for (std::size_t k = 0; joins(set) && k < set.particles.size(); k += 2)
      places.join(set.particles[k], set.particles[k + 1]);
  std::vector<std::vector<int>> at(model.count());
  for (int i = 0; i < model.count(); ++i) at[places.root(i)].push_back(i);
  return at;
}

}  // namespace

bool has_closed_places(const Model& model) { return std::ranges::any_of(model.sets, is_hard_seam); }

bool has_shared_places(const Model& model) {
  std::vector<int> sewn;
  for (const ConstraintSet& set : model.sets)
    if (is_hard_seam(set)) sewn.insert(sewn.end(), set.particles.begin(), set.particles.end());
  std::ranges::sort(sewn);
  return std::ranges::adjacent_find(sewn) != sewn.end();
}

CompressedLists<int> closed_places(const Model& model) {
  CompressedLists<int> closed;
  if (!has_closed_places(model)) return closed;
  DisjointSets places(model.count());
  for (const std::vector<int>& all : particles_at_places(model, places, is_hard_seam)) {
    if (all.size() < 2) continue;
    closed.list.insert(closed.list.end(), all.begin(), all.end());
    closed.begin.push_back(static_cast<int>(closed.list.size()));
  }
  return closed;
}

CompressedLists<int> sewn_particles(const Model& model) {
  if (model.scene.seams.empty()) return {};
  const int n = model.count();
  DisjointSets places(n);
  const std::vector<std::vector<int>> at =
      particles_at_places(model, places, [](const ConstraintSet& set) { return set.type == Seam::name; });
  std::vector<Edge> links;  // of places
  for (const ConstraintSet& set : model.sets)
    for (std::size_t k = 0; set.type == SurfaceAttachment::name && k < set.particles.size(); k += 4)
      for (int j = 1; j < 4; ++j)
        if (const Edge link{places.root(set.particles[k]), places.root(set.particles[k + j])}; link[0] != link[1])
          links.push_back(link);
  return {static_cast<std::size_t>(n), [&](const auto& add) {
            for (const std::vector<int>& all : at)
              for (const int i : all)
                for (const int j : all)
                  if (i != j) add(i, j);
            for (const auto& [one, other] : links)
              for (const int i : at[one])
                for (const int j : at[other]) add(i, j), add(j, i);
          }};
}

std::vector<int> sewn_bodies(const Model& model) {
  DisjointSets groups(static_cast<int>(model.scene.bodies.size()));
  const auto body = [&](int i) { return body_of(model, model.user_index[i]); };
  for (const ConstraintSet& set : model.sets)
    for (std::size_t k = 0; is_seam(set) && k < set.particles.size(); k += set.arity)
      groups.join(body(set.particles[k]), body(set.particles[k + 1]));
  std::vector<int> lowest;
  for (int b = 0; b < static_cast<int>(model.scene.bodies.size()); ++b) lowest.push_back(groups.root(b));
  return lowest;
}

double time_of_closed_seams(const Model& model) {
  double closed = 0;
  for (const ConstraintSet& set : model.sets)
    if (is_seam(set) && set.per_closing > 0) closed = std::max(closed, 1 / set.per_closing);
  return closed * (1 + 1e-6);  // beyond rounding
}

namespace {

/// Adds a note if gaps close so fast that their particles would be thrown.
void note_fast_seams(Model& model) {
  constexpr double fast = 10;  // m/s
  double speed = 0, gap = 0;
  for (const ConstraintSet& set : model.sets) {
    if (!is_seam(set)) continue;
    with_kind(set.type, [&]<class Kind>(Kind) {
      for (int c = 0; c < set.count(); ++c) {
        const double r = rest_value<Kind>(rest_positions(model, set), c, material_of<Kind>(set, c));
        if (r * set.per_closing > speed) speed = r * set.per_closing, gap = r;
      }
    });
  }
  if (speed > fast)
    model.notes.push_back("\"seams\": a gap of " + shown(gap, 2) + " m closes at " + shown(speed, 2) +
                          " m/s; give its seam more time, \"closing\" (s)");
}

/// Adds a note if a seam takes the length from edges: where particles beside each other are sewn to one place.
void note_lost_edges(Model& model) {
  const CompressedLists<int> closed = closed_places(model);
  std::vector<int> place(model.x.size(), -1);
  for (int k = 0; k < static_cast<int>(closed.begin.size()) - 1; ++k)
    for (const int i : closed[k]) place[model.user_index[i]] = k;
  std::set<Edge> lost;
  for_each_face_side(model.render_mesh.faces, [&](int i, int j) {
    if (place[i] >= 0 && place[i] == place[j]) lost.insert({std::min(i, j), std::max(i, j)});
  });
  if (!lost.empty())
    model.notes.push_back(
        "\"seams\": " + counted(std::ssize(lost), "edge", "edges") +
        " whose two ends are sewn to one place, and which lose all of their length; sew a finer row " +
        "to the \"surface\" of the other body");
}

/// Adds a note if the thickness is more than half of an edge at a seam: what is beside the seam has to keep it.
void note_thickness_at_seams(Model& model) {
  std::vector<bool> is_sewn(model.x.size(), false);
  for (const ConstraintSet& set : model.sets)
    if (is_seam(set))
      for (const int i : set.particles) is_sewn[model.user_index[i]] = true;
  double shortest = std::numeric_limits<double>::infinity();
  for_each_face_side(model.render_mesh.faces, [&](int i, int j) {
    const std::vector<Vec3>& points = model.render_mesh.points;
    if (is_sewn[i] || is_sewn[j]) shortest = std::min(shortest, distance(points[i], points[j]));
  });
  const double thickness = model.scene.self_collision->thickness;
  if (thickness > shortest / 2)
    model.notes.push_back("\"self_collision\": a thickness of " + shown(thickness, 2) +
                          " m beside seams whose shortest edge has " + shown(shortest, 2) +
                          " m holds the seams open; take half of the edge or less");
}

}  // namespace

void note_unlikely_seams(Model& model) {
  if (model.scene.seams.empty()) return;
  note_fast_seams(model), note_lost_edges(model);
  if (model.scene.self_collision) note_thickness_at_seams(model);
}

}  // namespace malha
