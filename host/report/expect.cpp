// SPDX-License-Identifier: Apache-2.0
#include "host/report/expect.h"

#include <limits>

#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "malha/text.h"

namespace malha {

namespace {

class ExpectationChecker {
 public:
  explicit ExpectationChecker(const std::vector<ParticlesOfBody>& bodies) : bodies_(bodies) {}

  /// NaN fails the comparison, too.
  void at_most(const char* what, const std::optional<double>& allowed, double found) {
    if (allowed && !(found <= *allowed)) add_line(what, found, "at most", *allowed);
  }
  void at_least(const char* what, const std::optional<double>& allowed, double found) {
    if (allowed && !(found >= *allowed)) add_line(what, found, "at least", *allowed);
  }
  void within(const char* what, const Range& allowed, double found) {
    at_least(what, allowed.at_least, found), at_most(what, allowed.at_most, found);
  }

  /// Checks that particles first .. end - 1, of a body or of all (`body` empty), lie within the bounds.
  void all_within(const std::string& body, const std::vector<Vec3>& x, std::size_t first, std::size_t end,
                  const Vec3& min, const Vec3& max) {
    std::size_t outside = 0, one = end;
    for (std::size_t i = first; i < end; ++i) {
      bool in = true;
      for (int k = 0; k < 3; ++k) in = in && x[i][k] >= min[k] && x[i][k] <= max[k];
      if (!in && outside++ == 0) one = i;
    }
    if (outside == 0) return;
    lines.push_back((body.empty() ? "bounds" : "bounds of body '" + body + "'") + ": found " +
                    counted(outside, "particle") + " outside the box, such as " + number(one, body.empty()) + " at " +
                    place(x[one]) + "; expected all from " + place(min) + " to " + place(max));
  }

  std::vector<std::string> lines;

 private:
  /// Returns the particle's number as the mesh file of its body counts vertices.
  std::string number(std::size_t particle, bool with_body) const {
    for (const ParticlesOfBody& body : bodies_)
      if (body.first <= particle && particle < body.end)
        return std::to_string(vertex_of(body.vertices, static_cast<int>(particle - body.first))) +
               (with_body ? " of body '" + body.name + "'" : "");
    return std::to_string(particle);
  }
  static std::string place(const Vec3& x) { return "(" + shown(x[0]) + ", " + shown(x[1]) + ", " + shown(x[2]) + ")"; }

  void add_line(const char* what, double found, const char* how, double allowed) {
    lines.push_back(std::string(what) + ": found " + shown(found) + "; expected " + how + " " + shown(allowed));
  }

  const std::vector<ParticlesOfBody>& bodies_;
};

}  // namespace

std::vector<std::string> unmet_expectations(const Expect& expect, const Measures& measures,
                                            const std::vector<Vec3>& positions,
                                            const std::vector<ParticlesOfBody>& bodies) {
  ExpectationChecker checker(bodies);
  checker.within("max_strain", expect.max_strain, measures.strain_max);
  checker.within("rms_strain", expect.rms_strain, measures.strain_rms);
  checker.within("max_penetration", expect.max_penetration, measures.penetration_max);
  checker.within("max_crossings", expect.max_crossings, static_cast<double>(measures.crossings));
  checker.at_most("energy_not_above", expect.energy_not_above, measures.energy());
  checker.at_least("energy_not_below", expect.energy_not_below, measures.energy());
  checker.within("max_speed", expect.max_speed, measures.speed_max);
  checker.within("max_seam_gap", expect.max_seam_gap, measures.max_seam_gap);
  checker.within("inverted_tetrahedra", expect.inverted_tetrahedra, double(measures.inverted_tetrahedra));
  if (expect.volume_ratio)
    for (const double ratio : measures.volume_ratios) {
      checker.at_least("volume_ratio", (*expect.volume_ratio)[0], ratio);
      checker.at_most("volume_ratio", (*expect.volume_ratio)[1], ratio);
    }
  std::size_t not_finite = 0;
  for (const Vec3& x : positions) not_finite += !finite(x);
  if (not_finite > 0) checker.lines.push_back(counted(not_finite, "particle") + " not finite");
  constexpr double all = std::numeric_limits<double>::infinity();
  if (expect.bounds_min || expect.bounds_max)
    checker.all_within("", positions, 0, positions.size(), expect.bounds_min.value_or(Vec3{-all, -all, -all}),
                       expect.bounds_max.value_or(Vec3{all, all, all}));
  for (const ExpectOfBody& of : expect.bodies)
    for (const ParticlesOfBody& body : bodies)
      if (body.name == of.name)
        checker.all_within(of.name, positions, body.first, body.end, of.bounds_min, of.bounds_max);
  return checker.lines;
}

}  // namespace malha
