// SPDX-License-Identifier: Apache-2.0
// Mean and median times. Measurements that are compared are taken in turns, so that other load of the machine affects
// all of them alike.
#pragma once
#include <functional>
#include <vector>

namespace malha::bench {

double median(std::vector<double> values);

/// Mean seconds of a call of work(), which is repeated for at least `min_seconds`.
double mean_seconds(const std::function<void()>& work, double min_seconds);

/// The median of a[turn] / b[turn].
double median_ratio(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace malha::bench
