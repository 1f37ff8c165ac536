// SPDX-License-Identifier: Apache-2.0
#include "host/model/coarsening_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "host/mesh/compressed_lists.h"
#include "host/mesh/edge_sides.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/model/rest_graph.h"
#include "host/model/seams.h"
#include "kernels/constraints/constraint_registry.h"

namespace malha {

namespace {

constexpr double kMuchSofter = 0.25;  // mean stiffness of a set over that of the stiffest set of its component

/// Particles of suspended bodies, and their graph distances to the pins.
struct SuspendedBody {
  const std::vector<Vector>& x;            // m, at rest
  const std::vector<double>& mass;         // kg, 0 for pinned particles
  const std::vector<int>& graph_distance;  // links to the nearest pin; 0: pinned, -1: not connected with a pin
  const std::vector<int>& part;            // connected component of each particle
  double gravity;                          // m/s^2
};

struct Spring {
  int a, b;
  double length, alpha;  // m; m/N
};

/// A triangle of an elastic sheet.
struct SheetTriangle {
  std::array<int, 3> corner;
  double Y;  // Young's modulus times thickness, N/m; that along, of an orthotropic sheet
  const Orthotropic* orthotropic = nullptr;
  Vector rest[3]{};  // m, at rest
};

/// Cross-section of a body between the particles at graph distance d and those at d - 1.
struct Section {
  int particles = 0;                // at graph distance d
  double mass = 0;                  // kg, of all particles at d or farther
  double springs = 0, sheet = 0;    // N, force per strain through it, of springs and of sheets that contract laterally
  double c4 = 0, c2s2 = 0, s4 = 0;  // of springs: stiffness along the pull, coupling, and stiffness across it

  /// Stiffness at `distance` links from the pins. Lateral contraction softens a body under tension, but not near the
  /// pins, which prevent it: their influence decays as exp(-4.2 distance / width), by the first Fadle-Papkovich root of
  /// a strip.
  double stiffness(int distance) const {
    const double contraction = s4 > 0 ? c2s2 * c2s2 / (c4 * s4) * (1 - std::exp(-4.2 * distance / particles)) : 0;
    return springs * (1 - contraction) + sheet;
  }
};

/// Static stretch of suspended bodies under their own weight.
class SelfWeightStretch {
 public:
  explicit SelfWeightStretch(const SuspendedBody& body) : body_(body), stretch_(body.x.size(), Vector{0, 0, 0}) {
    int parts = 0;
    for (const int p : body.part) parts = std::max(parts, p + 1);
    std::vector<int> cuts(parts, 1);  // one more than the largest distance; the last section has no mass
    for (int i = 0; i < count(); ++i) cuts[body.part[i]] = std::max(cuts[body.part[i]], body.graph_distance[i] + 2);
    begin_.assign(parts + 1, 0);
    for (int p = 0; p < parts; ++p) begin_[p + 1] = begin_[p] + cuts[p];
    sections_.resize(begin_.back());
    for (int i = 0; i < count(); ++i)
      if (body.graph_distance[i] > 0) section_at(i).mass += body.mass[i], ++section_at(i).particles;
    for (int p = 0; p < parts; ++p)
      for (int c = begin_[p + 1] - 2; c >= begin_[p]; --c) sections_[c].mass += sections_[c + 1].mass;
  }

  /// Returns sqrt(e) n for each particle, where e is the static strain along the unit vector n, which points away from
  /// the pins. e is the weight of all particles with a larger graph distance over the stiffness of the cross-section
  /// between. For strips and sheets that hang by a row this is accurate to some percent. For bodies that hang by points
  /// it is the stretch of rings around these. Other loads (wind, swinging) are not included.
  std::vector<Vector> stretch(const std::vector<Spring>& springs, const std::vector<SheetTriangle>& sheet) {
    find_directions(springs, sheet);
    for (const Spring& s : springs) add(s);
    for (const SheetTriangle& t : sheet) add(t);
    for (int i = 0; i < count(); ++i)
      stretch_[i] = stretch_[i] * (body_.graph_distance[i] < 0 ? 0 : std::sqrt(strain_at(i)));
    return std::move(stretch_);
  }

 private:
  int count() const { return static_cast<int>(body_.x.size()); }
  Section& section_at(int i) { return sections_[begin_[body_.part[i]] + body_.graph_distance[i]]; }
  /// Computes the direction of the gradient of the graph distance, by least squares over neighbours.
  void find_directions(const std::vector<Spring>& springs, const std::vector<SheetTriangle>& sheet) {
    struct Normal {
      Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
      Eigen::Vector3d b = Eigen::Vector3d::Zero();
    };
    std::vector<Normal> at(body_.x.size());
    const auto add_pair = [&](int i, int j) {
      const Vector offset = body_.x[j] - body_.x[i];
      const Eigen::Vector3d d(offset.x, offset.y, offset.z);
      const double size2 = d.squaredNorm();
      if (size2 > 0)
        for (const int k : {i, j})
          at[k].A += d * d.transpose() / size2,
              at[k].b += d * ((body_.graph_distance[j] - body_.graph_distance[i]) / size2);
    };
    for (const Spring& s : springs) add_pair(s.a, s.b);
    for (const SheetTriangle& t : sheet)
      for (int k = 0; k < 3; ++k) add_pair(t.corner[k], t.corner[(k + 1) % 3]);
    for (int i = 0; i < count(); ++i) {
      at[i].A.diagonal().array() += 1e-6 * at[i].A.trace() + 1e-300;  // neighbours may lie in a plane or on a line
      const Eigen::Vector3d n = at[i].A.ldlt().solve(at[i].b);
      if (const double size = n.norm(); size > 0) stretch_[i] = Vector{n[0], n[1], n[2]} * (1 / size);
    }
  }
  void add(const Spring& s) {
    const int from = body_.graph_distance[s.a], to = body_.graph_distance[s.b];
    if (from < 0 || from + to == 0) return;
    const Vector n = stretch_[s.a] + stretch_[s.b], d = body_.x[s.b] - body_.x[s.a];
    const double along = dot(n, d), size2 = dot(n, n) * dot(d, d);
    const double c2 = size2 > 0 ? along * along / size2 : 0, s2 = 1 - c2, stiff = s.length / s.alpha;
    Section& cut = section_at(from > to ? s.a : s.b);
    if (from != to) cut.springs += stiff * c2 * std::sqrt(c2);
    cut.c4 += stiff * s.length * c2 * c2, cut.c2s2 += stiff * s.length * c2 * s2, cut.s4 += stiff * s.length * s2 * s2;
  }
  /// The mean width of the cross-section in a triangle is its area times the gradient of the graph distance.
  void add(const SheetTriangle& t) {
    const auto& [i, j, k] = t.corner;
    const int a = body_.graph_distance[i], b = body_.graph_distance[j], c = body_.graph_distance[k];
    if (a < 0 || (a == b && b == c)) return;
    const Vector turned = (body_.x[k] - body_.x[i]) * double(b - a) - (body_.x[j] - body_.x[i]) * double(c - a);
    double Y = t.Y;
    if (t.orthotropic) {  // the direction of the pull, carried to the triangle at rest
      const Vector to_j = body_.x[j] - body_.x[i], to_k = body_.x[k] - body_.x[i], n = cross(to_j, to_k);
      const Vector pull = stretch_[i] + stretch_[j] + stretch_[k];
      const Vector along =
          (t.rest[1] - t.rest[0]) * dot(cross(pull, to_k), n) + (t.rest[2] - t.rest[0]) * dot(cross(to_j, pull), n);
      Y *= t.orthotropic->modulus(t.orthotropic->cosine2(cross(t.rest[1] - t.rest[0], t.rest[2] - t.rest[0]), along));
    }
    section_at(a > b && a > c ? i : b > c ? j : k).sheet += Y * norm(turned) / 2;
  }

  double strain_of(int cut, int distance) const {
    const double stiffness = sections_[cut].stiffness(distance);
    return stiffness > 0 ? body_.gravity * sections_[cut].mass / stiffness : 0;
  }
  /// The strain at a particle: the mean of the sections on both sides of it; for pins that of the first section.
  double strain_at(int i) const {
    const int graph_distance = body_.graph_distance[i], cut = begin_[body_.part[i]] + graph_distance;
    const double outer = strain_of(cut + 1, graph_distance + 1);
    return graph_distance == 0 ? outer : (strain_of(cut, graph_distance) + outer) / 2;
  }

  const SuspendedBody& body_;
  std::vector<Vector> stretch_;
  std::vector<int> begin_;  // first section of each part; within a part they are ordered by graph distance
  std::vector<Section> sections_;
};

/// The number of links from each of `count` particles to the nearest pinned one; -1 if it is not connected with one.
std::vector<int> graph_distances(int count, const std::vector<Link>& links, const std::vector<bool>& pinned) {
  const CompressedLists<int> near(count, [&](const auto& add) {
    for (const Link& l : links) add(l.a, l.b), add(l.b, l.a);
  });
  std::vector<int> graph_distance(count, -1), front;
  for (int i = 0; i < count; ++i)
    if (pinned[i]) graph_distance[i] = 0, front.push_back(i);
  for (std::size_t k = 0; k < front.size(); ++k)
    for (const int j : near[front[k]])
      if (graph_distance[j] < 0) graph_distance[j] = graph_distance[front[k]] + 1, front.push_back(j);
  return graph_distance;
}

class GraphBuilder {
 public:
  GraphBuilder(const Model& model, const std::vector<double>& w) : model_(model), w_(model.count()), x_(model.count()) {
    pinned_.resize(model.count()), mass_.resize(model.count());
    for (int i = 0; i < model.count(); ++i) {
      const int user = model.user_index[i];
      x_[user] = vector(model.at_rest()[i]), w_[user] = w[i], pinned_[user] = w[i] == 0,
      mass_[user] = w[i] > 0 ? 1 / w[i] : 0;
    }
  }

  CoarseningGraph build() {
    for (std::size_t s = 0; s < model_.sets.size(); ++s) {
      if (model_.sets[s].type == Distance::name) add_springs(static_cast<int>(s));
      if (is_membrane(model_.sets[s])) add_membrane(static_cast<int>(s));
      if (is_seam(model_.sets[s])) add_joints(static_cast<int>(s));
    }
    find_parts();
    const auto elastic = [this] { return std::ranges::any_of(alpha_, [](double a) { return a > 0; }); };
    if (elastic()) drop_soft_links(), find_parts();
    graph_distance_ = graph_distances(model_.count(), graph_.links, pinned_);
    for (int i = 0; i < model_.count(); ++i) {
      GraphComponent& part = graph_.parts[graph_.part[i]];
      ++part.particles, part.max_graph_distance = std::max(part.max_graph_distance, graph_distance_[i]);
    }
    const bool has_contacts = !model_.environment.empty() || model_.scene.self_collision;
    for (GraphComponent& part : graph_.parts) part.loaded = has_contacts;
    for (const MovedPins& pins : model_.moved)
      for (const int i : pins.particles) graph_.parts[graph_.part[model_.user_index[i]]].loaded |= pins.target.moves();
    for (const Link& l : graph_.links) graph_.parts[graph_.part[l.a]].soft |= model_.sets[l.set].stiffness < 1;
    for (const auto& body : model_.tetrahedra)
      for (const Tetrahedron& t : body) graph_.parts[graph_.part[model_.user_index[t[0]]]].solid = true;
    if (elastic()) compute_stretch();
    return std::move(graph_);
  }

 private:
  void add(int a, int b, double length, int set, double alpha) {
    graph_.links.push_back({a, b, length, set});
    alpha_.push_back(alpha);
  }
  void add_springs(int s) {
    const ConstraintSet& set = model_.sets[s];
    for (int c = 0; c < set.count(); ++c) {
      const int a = model_.user_index[set.particles[2 * c]], b = model_.user_index[set.particles[2 * c + 1]];
      double length = norm(x_[a] - x_[b]);
      if (!set.rest_corners.empty())
        length = norm(vector(set.rest_corners[2 * c]) - vector(set.rest_corners[2 * c + 1]));
      add(a, b, length * material_of<Distance>(set, c), s, set.alpha(c));
    }
  }
  /// A joint is as long as its gap at the start, or, of an attachment, as the distances of its particle from the
  /// corners: levels let a gap close, and do not close it.
  void add_joints(int s) {
    const ConstraintSet& set = model_.sets[s];
    for (std::size_t k = 0; k < set.particles.size(); k += set.arity)
      for (int j = 1; j < set.arity; ++j) {
        const int a = set.particles[k], b = set.particles[k + j];
        add(model_.user_index[a], model_.user_index[b], norm(vector(model_.x[a]) - vector(model_.x[b])), s, 0);
      }
  }
  static bool is_membrane(const ConstraintSet& set) {
    return set.type == Membrane::name || set.type == OrthotropicMembrane::name;
  }
  /// Adds the sides of a membrane as springs of stiffness Y A / l^2, where A is the area of the incident triangles and
  /// Y the modulus in the direction of the side.
  void add_membrane(int s) {
    const ConstraintSet& set = model_.sets[s];
    const double Y = 1 / set.compliance.value_or(1);
    std::vector<double> area;
    const std::size_t begin = sheets_.size();
    for (int c = 0; c < set.count(); ++c) {
      SheetTriangle& piece = sheets_.emplace_back(
          SheetTriangle{{}, Y / set.softness_of(c), set.orthotropic ? &*set.orthotropic : nullptr, {}});
      for (int k = 0; k < 3; ++k) piece.corner[k] = model_.user_index[set.particles[3 * c + k]];
      for (int k = 0; k < 3; ++k)
        piece.rest[k] = set.rest_corners.empty() ? x_[piece.corner[k]] : vector(set.rest_corners[3 * c + k]);
      const Vector(&X)[3] = piece.rest;
      area.push_back(norm(cross(X[1] - X[0], X[2] - X[0])) / 2);
    }
    const auto visit = [&](const auto& add_side) {
      for (std::size_t t = begin; t < sheets_.size(); ++t)
        for (int k = 0; k < 3; ++k) add_side(sheets_[t].corner[k], sheets_[t].corner[(k + 1) % 3]);
    };
    for_each_edge(sorted_sides(x_.size(), visit), [&](auto first, auto last) {
      double sum = 0, length = norm(x_[first->low] - x_[first->high]);
      if (!set.rest_corners.empty()) length = 0;
      for (auto side = first; side != last; ++side) {
        const int t = side->number / 3, k = side->number % 3;
        const Vector(&X)[3] = sheets_[begin + static_cast<std::size_t>(t)].rest;
        const Vector along = X[(k + 1) % 3] - X[k];
        double modulus = 1;  // over Y
        if (const std::optional<Orthotropic>& of = set.orthotropic)
          modulus = of->modulus(of->cosine2(cross(X[1] - X[0], X[2] - X[0]), along));
        sum += area[t] * modulus / set.softness_of(t);
        if (!set.rest_corners.empty()) length += norm(along) / static_cast<double>(last - first);
      }
      if (sum > 0) add(first->low, first->high, length, s, length * length / (Y * sum));
    });
  }

  void find_parts() {
    int parts = 0;
    graph_.part = components(model_.count(), edges_of(graph_.links), parts);
    graph_.parts.assign(parts, {});
  }

  /// Drops links that are much softer than others of their component, such as shear beside stiff edges: a coarse
  /// constraint made from them would be as stiff as one of the edges.
  void drop_soft_links() {
    struct Mean {
      double sum = 0;
      int count = 0;
      double value() const { return count > 0 ? sum / count : 0; }
    };
    std::map<std::pair<int, int>, Mean> mean;  // mean of length / alpha of each set in each component
    std::vector<double> stiffest(graph_.parts.size(), 0);
    const auto of = [&](const Link& l) -> Mean& { return mean[{graph_.part[l.a], l.set}]; };
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      if (is_seam(model_.sets[graph_.links[k].set])) continue;
      Mean& m = of(graph_.links[k]);
      m.sum += alpha_[k] > 0 ? graph_.links[k].length / alpha_[k] : HUGE_VAL, ++m.count;
    }
    for (const auto& [where, m] : mean) stiffest[where.first] = std::max(stiffest[where.first], m.value());
    std::size_t kept = 0;
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link l = graph_.links[k];
      if (!is_seam(model_.sets[l.set]) && !(of(l).value() >= kMuchSofter * stiffest[graph_.part[l.a]])) continue;
      graph_.links[kept] = l, alpha_[kept++] = alpha_[k];
    }
    graph_.links.resize(kept), alpha_.resize(kept);
    std::erase_if(sheets_, [&](const SheetTriangle& t) {
      return stiffest[graph_.part[t.corner[0]]] == HUGE_VAL;  // beside inextensible links the sheet is soft
    });
  }

  /// Computes the compliance loss and the static stretch of elastic components.
  void compute_stretch() {
    const double h = model_.scene.solver.dt / model_.scene.solver.substeps;
    std::vector<int> links(graph_.parts.size(), 0);
    for (std::size_t k = 0; k < alpha_.size(); ++k) {
      const Link& l = graph_.links[k];
      if (!(alpha_[k] > 0)) continue;
      GraphComponent& part = graph_.parts[graph_.part[l.a]];
      part.elastic = true;
      part.compliance_loss += h * h * (w_[l.a] + w_[l.b]) / alpha_[k], ++links[graph_.part[l.a]];
    }
    std::vector<Spring> springs;
    for (std::size_t k = 0; k < alpha_.size(); ++k)
      if (const Link& l = graph_.links[k]; alpha_[k] > 0 && !is_membrane(model_.sets[l.set]))
        springs.push_back({l.a, l.b, l.length, alpha_[k]});
    const SuspendedBody body{x_, mass_, graph_distance_, graph_.part, norm(vector(model_.scene.gravity))};
    graph_.stretch = SelfWeightStretch(body).stretch(springs, sheets_);
    std::vector<double> mass(graph_.parts.size(), 0);
    for (int i = 0; i < model_.count(); ++i) {
      const int p = graph_.part[i];
      graph_.parts[p].stretch += mass_[i] * dot(graph_.stretch[i], graph_.stretch[i]), mass[p] += mass_[i];
    }
    for (std::size_t p = 0; p < mass.size(); ++p) {
      if (mass[p] > 0) graph_.parts[p].stretch /= mass[p];
      if (links[p] > 0) graph_.parts[p].compliance_loss /= links[p];
    }
  }

  const Model& model_;
  std::vector<double> w_, mass_, alpha_;  // w_, mass_: in the user's numbering; alpha_: of each link
  std::vector<Vector> x_;
  std::vector<bool> pinned_;
  std::vector<SheetTriangle> sheets_;
  std::vector<int> graph_distance_;
  CoarseningGraph graph_;
};

}  // namespace

CoarseningGraph coarsening_graph(const Model& model, const std::vector<double>& w) {
  return GraphBuilder(model, w).build();
}

}  // namespace malha
