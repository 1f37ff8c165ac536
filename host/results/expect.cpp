#include "host/results/expect.h"

#include <cmath>
#include <sstream>

namespace malha {

namespace {

class Judge {
 public:
  /// Refuses NaN too.
  void at_most(const char* what, const std::optional<double>& allowed, double found) {
    if (allowed && !(found <= *allowed)) say(what, found, "at most", *allowed);
  }
  void at_least(const char* what, double allowed, double found) {
    if (!(found >= allowed)) say(what, found, "at least", allowed);
  }
  std::vector<std::string> lines;

 private:
  void say(const char* what, double found, const char* how, double allowed) {
    std::ostringstream line;
    line << what << ": found " << found << "; expected " << how << " " << allowed;
    lines.push_back(line.str());
  }
};

}  // namespace

std::vector<std::string> unmet_expectations(const Expect& expect, const Measures& measures,
                                            const std::vector<Vec3>& positions) {
  Judge judge;
  judge.at_most("max_strain", expect.max_strain, measures.strain_max);
  judge.at_most("rms_strain", expect.rms_strain, measures.strain_rms);
  judge.at_most("max_penetration", expect.max_penetration, measures.penetration_max);
  judge.at_most("max_crossings", expect.max_crossings, static_cast<double>(measures.crossings));
  judge.at_most("energy_not_above", expect.energy_not_above, measures.energy());
  judge.at_most("max_speed", expect.max_speed, measures.speed_max);
  if (expect.inverted_tetrahedra)
    judge.at_most("inverted_tetrahedra", *expect.inverted_tetrahedra, double(measures.inverted_tetrahedra));
  if (expect.volume_ratio)
    for (const double ratio : measures.volume_ratios) {
      judge.at_least("volume_ratio", (*expect.volume_ratio)[0], ratio);
      judge.at_most("volume_ratio", (*expect.volume_ratio)[1], ratio);
    }
  std::size_t outside = 0, not_finite = 0;
  for (const Vec3& x : positions) {
    bool finite = true, inside = true;
    for (int k = 0; k < 3; ++k) {
      finite = finite && std::isfinite(x[k]);
      if (expect.inside_min) inside = inside && x[k] >= (*expect.inside_min)[k];
      if (expect.inside_max) inside = inside && x[k] <= (*expect.inside_max)[k];
    }
    not_finite += !finite;
    outside += !inside;
  }
  if (not_finite > 0) judge.lines.push_back(std::to_string(not_finite) + " particles are not finite");
  if (outside > 0) judge.lines.push_back("inside: found " + std::to_string(outside) + " particles outside the box");
  return judge.lines;
}

}  // namespace malha
