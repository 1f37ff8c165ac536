#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/model/parents.h"

namespace malha {

namespace {

class Sharer {
 public:
  Sharer(const RestGraph& fine, const std::vector<Parents>& parents, Coarser& coarse)
      : fine_(fine), parents_(parents), coarse_(coarse) {}

  /// Which part of the coarse links' strain each finer link with a compliance has, so that a strain that is the same
  /// everywhere is so on both levels; from it the compliance of coarse links, so that the energy is the same, and the
  /// forces of finer links.
  void share_forces() {
    RestGraph& graph = coarse_.graph;
    Means& force = coarse_.force;
    const bool any = std::any_of(fine_.links.begin(), fine_.links.end(), [](const Link& l) { return l.alpha > 0; });
    if (!any) return;
    std::vector<int> begin(graph.count() + 1, 0), at;
    for (const Link& l : graph.links) ++begin[l.a + 1], ++begin[l.b + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    at.resize(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (std::size_t l = 0; l < graph.links.size(); ++l)
      at[next[graph.links[l].a]++] = at[next[graph.links[l].b]++] = static_cast<int>(l);
    std::vector<double> stiffness(graph.links.size(), 0);  // times length squared
    for (const Link& l : fine_.links) {
      if (l.alpha > 0) {
        std::vector<StrainPart> parts = strain_parts(l, begin, at);
        for (const StrainPart& part : parts) {
          stiffness[part.link] += part.share * l.length * l.length / l.alpha;
          force.of.push_back(part.link), force.weight.push_back(part.share);
        }
      }
      force.begin.push_back(static_cast<int>(force.of.size()));
    }
    for (std::size_t k = 0; k < graph.links.size(); ++k) {
      Link& l = graph.links[k];
      if (l.alpha > 0 && stiffness[k] > 0) l.alpha = l.length * l.length / stiffness[k];
    }
    for (std::size_t e = 0; e < fine_.links.size(); ++e)
      for (int k = force.begin[e]; k < force.begin[e + 1]; ++k) {
        const Link &l = fine_.links[e], &from = graph.links[force.of[k]];
        force.weight[k] *= from.alpha / from.length * l.length / l.alpha;
      }
  }

 private:
  using Vector6 = std::array<double, 6>;
  using Vector7 = std::array<double, 7>;
  /// d d^T, as the six numbers of a symmetric tensor, of which the products of two sum up.
  static Vector6 square(const Vector& d) {
    constexpr double r = 1.4142135623730951;
    return {d.x * d.x, d.y * d.y, d.z * d.z, r * d.x * d.y, r * d.y * d.z, r * d.z * d.x};
  }

  struct StrainPart {
    int link;
    double share;
  };
  /// The least shares, of parallel and near links rather than of others, with which the strain along this link is that
  /// of coarse links around it, whatever the strain.
  std::vector<StrainPart> strain_parts(const Link& l, const std::vector<int>& begin, const std::vector<int>& at) const {
    std::vector<StrainPart> parts;

    std::vector<double> favour;
    const Vector along_l = along(fine_.x[l.b] - fine_.x[l.a], fine_.normal[l.a], 1);

    const auto follows = [&](int k) {
      double sum = 0;
      for (const int i : {l.a, l.b})
        for (const Parent& p : parents_[i])
          if (p.of == k) sum += 0.5 * p.weight;
      return sum;
    };
    for (const int i : {l.a, l.b})
      for (const Parent& p : parents_[i])
        for (int k = begin[p.of]; k < begin[p.of + 1]; ++k) {
          const Link& coarse = coarse_.graph.links[at[k]];
          const bool known = std::any_of(parts.begin(), parts.end(), [&](auto& q) { return q.link == at[k]; });
          if (coarse.set != l.set || known) continue;
          const Vector& normal = coarse_.graph.normal[coarse.a];
          const Vector there = along(coarse_.graph.x[coarse.b] - coarse_.graph.x[coarse.a], normal, 1);
          const Vector here = turned(there, normal, fine_.normal[l.a]);
          const double cosine = dot(here, along_l);
          parts.push_back({at[k], 0});

          favour.push_back((follows(coarse.a) * follows(coarse.b) + 0.02) / (1.02 - cosine * cosine));
        }
    double sum = 0;
    for (const double f : favour) sum += f * f;
    for (std::size_t c = 0; c < parts.size(); ++c) parts[c].share = favour[c] * favour[c] / sum;
    std::erase_if(parts, [](const StrainPart& part) { return std::abs(part.share) < kSmallWeight; });
    return parts;
  }

  const RestGraph& fine_;
  const std::vector<Parents>& parents_;
  Coarser& coarse_;
};

}  // namespace

void share_forces(const RestGraph& fine, const std::vector<Parents>& parents, Coarser& coarser) {
  Sharer(fine, parents, coarser).share_forces();
}

}  // namespace malha
