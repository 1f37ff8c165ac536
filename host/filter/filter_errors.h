// How exact a filter is, against the same system solved in double.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "host/filter/system.h"

namespace malha {

/// a = S~ F of the filter at hand, three numbers an unknown.
using ApplyFilter = std::function<std::vector<double>(const std::vector<double>& forces)>;

/// A sparse filter in double, on one thread.
class ExactFilter {
 public:
  explicit ExactFilter(const SpringSystem& system);
  ~ExactFilter();
  std::vector<double> operator()(const std::vector<double>& forces) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

struct Refined {
  std::vector<double> accelerations;
  double step = 1;  // the last, over all: what they may be off by; where the filter is too far from S, not small
};
/// S F to rounding: iterative refinement with a filter in place of S.
Refined refined(const SpringSystem& system, const ApplyFilter& apply, const std::vector<double>& forces);

/// Independent numbers in [-1, 1), the same every time, without the mean force of free bodies.
std::vector<double> noise_forces(const SpringSystem& system);
/// (A - M) d of independent displacements d: what stretched springs pull with, times dt^2.
std::vector<double> elastic_forces(const SpringSystem& system);

/// Takes the mean over mass from the accelerations of free bodies.
void remove_mean(const SpringSystem& system, std::vector<double>& accelerations);

/// |a - b| / |b|.
double relative_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace malha
