// SPDX-License-Identifier: Apache-2.0
#include "tools/study/accuracy/words.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tools/bench/output.h"

namespace malha::study {

namespace {

using bench::formatted;

/// A power of ten: "1e-3".
std::string power(int exponent) { return "1e" + std::to_string(exponent); }

/// The descriptions of each series' best point, joined.
std::string each_series(const Points& points, const std::function<bool(const Point&, const Point&)>& better,
                        const std::function<std::string(const Point&)>& describe) {
  std::string line;
  for (auto first = points.begin(); first != points.end();) {
    const auto end = std::find_if(first, points.end(), [&](const Point& p) { return p.series != first->series; });
    append(line, describe(*std::min_element(first, end, better)), "; ");
    first = end;
  }
  return line;
}

}  // namespace

std::string truth_sentence(const AccuracyCase& test_case, const Truth& truth) {
  const std::string frequency = formatted(
      "The largest frequency at the start is %.4g rad/s: symplectic Euler is stable from %.0f steps a frame on.",
      truth.omega, std::ceil(truth.omega * kFrame / 2));
  if (test_case.at_rest) return test_case.expected;
  if (test_case.exact) return "The true motion is known in closed form. " + frequency;
  const auto at_times = [&test_case](const std::vector<double>& away) {
    std::string line;
    for (std::size_t k = 0; k < test_case.times.size(); ++k)
      line += formatted("%s %.1e m away after %g s", k == 0 ? "" : " and", away[k], test_case.times[k]);
    return line + ". ";
  };
  std::string line = formatted(
                         "The true motion is that of the same equations by RK4 with a step of %.2g s (omega_max h = "
                         "%.2g); the motion with twice that step is",
                         kFrame / test_case.reference, truth.omega * kFrame / test_case.reference) +
                     at_times(truth.step_difference) +
                     formatted("If the start is perturbed by %g m, it is", kPerturbation) +
                     at_times(truth.perturbed_difference);
  if (const double uncertainty = truth.uncertainty.back(); uncertainty > kChaotic) {
    const bool of_step = truth.step_difference.back() > 10 * truth.perturbed_difference.back();
    line += of_step ? "That is the error of the step. "
                    : formatted("At %g s the motion is chaotic, and no smaller step helps. ", test_case.times.back());
    line += formatted("Errors below %.0e m are not significant. ", uncertainty);
  }
  return line + frequency;
}

std::string cheapest_list(const Points& points, double uncertainty, double Point::*cost, const char* unit,
                          bool malha_only) {
  std::string line;
  const auto best = [&](int exponent) {
    const double error = std::pow(10, exponent);
    return error > uncertainty ? cheapest(points, error, cost, malha_only) : nullptr;
  };
  for (int exponent = -1; exponent >= -12 && best(exponent) != nullptr; --exponent) {
    const Point& point = *best(exponent);
    if (best(exponent - 1) == &point) continue;
    append(line,
           power(exponent) + " m: " + point.series + " (" + point.settings + formatted(", %.3g %s)", point.*cost, unit),
           "; ");
  }
  return line.empty() ? "none reaches 1e-1 m" : line;
}

Table cheapest_table(const Points& points, double uncertainty) {
  Table table{{"error at most, m", "cheapest of all", "settings", "ms per s", "cheapest of malha's", "settings",
               "ms per s", "fewest sweeps of malha's", "settings", "sweeps per s"},
              {}};
  for (int exponent = 0; exponent >= -12; --exponent) {
    const double error = std::pow(10, exponent);
    if (error < uncertainty || cheapest(points, error, &Point::ms, false) == nullptr) break;
    std::vector<std::string> row{power(exponent)};
    for (const auto& [cost, is_malha] :
         {std::pair(&Point::ms, false), std::pair(&Point::ms, true), std::pair(&Point::sweeps, true)}) {
      const Point* point = cheapest(points, error, cost, is_malha);
      row.push_back(point ? point->series : "none");
      row.push_back(point ? point->settings : "");
      row.push_back(point ? formatted("%.3g", point->*cost) : "");
    }
    table.rows.push_back(row);
  }
  return table;
}

std::string orders_sentence(const Points& points) {
  std::string line;
  for (auto p = points.begin(); p != points.end(); ++p) {
    if (p != points.begin() && p->series == std::prev(p)->series) continue;
    if (const double order = order_of(points, p->series); order > 0)
      append(line, p->series + formatted(" %.1f", order), "; ");
  }
  return line.empty() ? "" : "The error falls with the sweeps to the power of: " + line + ".";
}

std::string best_sentence(const Points& points) {
  return "Smallest error of each series, with its gain or loss of energy: " +
         each_series(
             points, [](const Point& a, const Point& b) { return a.error < b.error; },
             [](const Point& best) {
               return best.series + formatted(" %.1e m", best.error) + " (" + best.settings +
                      formatted(", %+.2g %%)", 100 * best.energy);
             }) +
         ".";
}

std::string float_sentence(const Points& points) {
  const Point *best = nullptr, *costliest = nullptr;
  for (const Point& point : points) {
    if (point.series != "XPBD, substeps, float") continue;
    if (best == nullptr || point.error < best->error) best = &point;
    costliest = &point;
  }
  constexpr double worse = 2;
  if (best == nullptr || costliest->error < worse * best->error) return "";
  return "In float XPBD is best with " + best->settings + formatted(" (%.1e m), and with ", best->error) +
         costliest->settings +
         formatted(" its error is %.1e m and its energy is off by %+.2g %%: ", costliest->error,
                   100 * costliest->energy) +
         "the displacement of a substep is lost in the rounding of positions.";
}

std::string momenta_sentence(const Points& points, double time) {
  return formatted(
             "Errors of momentum (kg m/s) and angular momentum (kg m^2/s) after %g s, of each series at its highest "
             "cost: ",
             time) +
         each_series(
             points, [](const Point& a, const Point& b) { return a.sweeps > b.sweeps; },
             [](const Point& costliest) {
               return costliest.series + formatted(" %.1e, %.1e", costliest.momentum, costliest.angular_momentum) +
                      " (" + costliest.settings + ")";
             }) +
         ".";
}

std::string growth_sentence(const Points& points, double time) {
  std::string line;
  double kept = 0;
  for (const Point& point : points) {
    if (point.series == "symplectic Euler") kept = point.energy;
    if (point.series == "explicit Euler")
      append(line, formatted("%+.2g %% (", 100 * point.energy) + point.settings + ")");
  }
  return line.empty() ? ""
                      : formatted("Explicit Euler adds energy at every step, after %g s: ", time) + line +
                            formatted("; symplectic Euler with the most steps: %+.2g %%.", 100 * kept);
}

std::string diverged_sentence(const AccuracyCase& test_case, const Json& rows) {
  std::string line, series;
  for (const Json& row : rows)
    if (row["case"] == test_case.name && row["time_s"] == test_case.times.back() && row["status"] == "diverged") {
      line += row["series"] == series ? ", " : (line.empty() ? "" : "; ") + row["series"].get<std::string>() + " ";
      line += row["settings"].get<std::string>();
      series = row["series"];
    }
  return line.empty() ? "" : "Diverged: " + line + ".";
}

Table runs_table(const AccuracyCase& test_case, const Json& rows) {
  Table table{{"method", "settings", "time, s", "status", "RMS error, m", "RMS strain", "its error", "energy drift, %",
               "momentum error", "angular", "ms per s", "sweeps per s"},
              {}};
  for (const Json& row : rows) {
    if (row["case"] != test_case.name) continue;
    const auto number = [&row](const char* key, double scale = 1) {
      return row.contains(key) && row[key].is_number() ? formatted("%.3g", scale * row[key].get<double>()) : "";
    };
    table.rows.push_back({row["series"].get<std::string>(), row["settings"].get<std::string>(), number("time_s"),
                          row["status"].get<std::string>(), number("rms_error_m"), number("rms_strain"),
                          number("rms_strain_error"), number("energy_drift", 100), number("momentum_error_kg_m_per_s"),
                          number("angular_momentum_error_kg_m2_per_s"), number("ms_per_s"), number("sweeps_per_s")});
  }
  return table;
}

}  // namespace malha::study
