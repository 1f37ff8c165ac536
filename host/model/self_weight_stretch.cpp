// SPDX-License-Identifier: Apache-2.0
#include "host/model/self_weight_stretch.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace malha {

namespace {

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
    section_at(a > b && a > c ? i : b > c ? j : k).sheet += t.Y * norm(turned) / 2;
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

}  // namespace

std::vector<Vector> stretch_by_weight(const SuspendedBody& body, const std::vector<Spring>& springs,
                                      const std::vector<SheetTriangle>& sheet) {
  return SelfWeightStretch(body).stretch(springs, sheet);
}

}  // namespace malha
