// SPDX-License-Identifier: Apache-2.0
// Those who are compared take turns, so that what else the machine does hits them alike.
#pragma once
#include <functional>
#include <vector>

namespace malha::bench {

double median(std::vector<double> values);

/// Seconds that work() takes, the mean over at least `enough` seconds.
double seconds_each(const std::function<void()>& work, double enough);

/// The median over the turns of a / b.
double median_ratio(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace malha::bench
