// SPDX-License-Identifier: Apache-2.0
// Macklin, Müller, Chentanez 2016, section 6.1: a spring of rest length 1, initial length 1.5, mass 1 and compliance
// 0.001. The paper's figure 2 compares curves and states neither numbers nor the step; here it is 1/60 s.
#include <cmath>

#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/output.h"
#include "tools/study/published/parts.h"
#include "tools/study/rows.h"
#include "tools/study/step_length.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr double kCompliance = 0.001;
constexpr double kPi = 3.14159265358979323846;

struct SpringSetting {
  std::string title;
  std::optional<double> compliance;
  double stiffness;  // of PBD, per step
  int substeps, iterations;
};

/// malha's stiffness for PBD's k: PBD of 2006 leaves (1 - k) of an error per projection, while malha's stiffness is
/// that of all projections of a step together.
double of_a_step(double k, int iterations) { return 1 - std::pow(1 - k, iterations); }

std::vector<SpringSetting> spring_settings(bool quick) {
  std::vector<SpringSetting> all;
  for (const int n : {1, 5, 10}) all.push_back({"XPBD, " + counted(n, "iteration"), kCompliance, 1, 1, n});
  for (const int n : quick ? std::vector{10} : std::vector{10, 100})
    all.push_back({formatted("XPBD, %d substeps", n), kCompliance, 1, n, 1});
  for (const int n : {1, 5, 10})
    all.push_back({"PBD, k = 0.1, " + counted(n, "iteration"), {}, of_a_step(0.1, n), 1, n});
  return all;
}

/// Period and damping of a motion. `a`: the spring's elongation (m) after each step, which obeys a(n+1) = p a(n) +
/// q a(n-1) exactly. Least squares yield p and q, and they the period and the amplitude that is left after it; null if
/// the motion does not oscillate.
Json measured(const std::vector<double>& a, double dt) {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  for (std::size_t n = 2; n < a.size(); ++n) {
    aa += a[n - 1] * a[n - 1], ab += a[n - 1] * a[n - 2], bb += a[n - 2] * a[n - 2];
    ay += a[n] * a[n - 1], by += a[n] * a[n - 2];
  }
  const double p = (ay * bb - by * ab) / (aa * bb - ab * ab), q = (by * aa - ay * ab) / (aa * bb - ab * ab);
  const double shrinks = q < 0 ? std::sqrt(-q) : 0, turn = p / 2 / shrinks;
  if (!(std::abs(turn) < 1)) return {{"period_s", nullptr}, {"left_after_a_period", nullptr}, {"a_m", a}};
  const double steps = 2 * kPi / std::acos(turn);
  return {{"period_s", steps * dt}, {"left_after_a_period", std::pow(shrinks, steps)}, {"a_m", a}};
}

Json run_spring(const SpringSetting& setting) {
  BodySpec body;
  body.name = "spring", body.shape = ChainShape{{0, 0, 0}, {1.5, 0, 0}, 1}, body.mass = 2;  // 1 kg at each end
  body.pins = {ListPin{{0}}};
  ConstraintSpec spring;
  spring.type = "distance", spring.elements = {"edges"}, spring.parameter = 1 / 1.5;
  spring.compliance = setting.compliance, spring.stiffness = setting.stiffness;
  body.constraints = {spring};
  const double dt = kFrame / setting.substeps;  // substeps are steps, so that each is recorded
  Simulation simulation(published_scene(body, dt, 1, setting.iterations, 0), {.threads = 1});
  std::vector<double> a{0.5};
  for (int n = 0; n < 60 * setting.substeps; ++n) simulation.step(), a.push_back(simulation.positions()[1][0] - 1);
  return measured(a, dt);
}

const double kOmega = std::sqrt(1 / kCompliance);
double backward_euler_period(double dt) { return 2 * kPi * dt / std::atan(kOmega * dt); }

std::string or_none(const Json& value, const char* format, double times = 1) {
  return value.is_null() ? "none" : formatted(format, value.get<double>() * times);
}

void add_spring(Cells& cells, Findings& findings) {
  const double exact = 2 * kPi / kOmega;
  Section section{"XPBD 2016, section 6.1: an oscillator"};
  section.table.columns = {"method", "period, s", "backward Euler's, s", "swing left after a period"};
  section.table.rows.push_back({"closed form", formatted("%.5f", exact), "", "1"});
  Chart chart{"spring",
              "set xrange [0:0.6]\nset xlabel 'time (s)'\nset ylabel 'length (m)'\nset title 'XPBD 2016, 6.1: an "
              "oscillator of compliance 0.001, step 1/60 s'\n"};
  std::string curve;
  for (int n = 0; n <= 600; ++n) curve += formatted("%g %g\n", n * 1e-3, 1 + 0.5 * std::cos(kOmega * n * 1e-3));
  chart.series.push_back({curve, "with lines lw 2 lc rgb '#000000'", "closed form"});
  static constexpr const char* styles[] = {"lc rgb '#9ecae1' pt 7",  "lc rgb '#4292c6' pt 5",  "lc rgb '#08519c' pt 9",
                                           "lc rgb '#7fbf3f' pt 13", "lc rgb '#1b7837' pt 11", "lc rgb '#fdae6b' pt 7",
                                           "lc rgb '#e6550d' pt 5",  "lc rgb '#a63603' pt 9"};
  double xpbd_off = 0, xpbd_apart = 0, finest = 0;
  std::string pbd;
  const std::vector<SpringSetting> all = spring_settings(cells.quick());
  const std::vector<Json> kept = cells.measure_all(
      all, [](const SpringSetting& setting) { return "spring: " + setting.title; }, run_spring);
  if (cells.is_partial()) return;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const SpringSetting& setting = all[k];
    const Json& cell = kept[k];
    const double dt = kFrame / setting.substeps;
    findings.rows.push_back({{"case", "spring of 2016"},
                             {"what", setting.title},
                             {"substeps", setting.substeps},
                             {"iterations", setting.iterations},
                             {"period_s", cell["period_s"]},
                             {"left_after_a_period", cell["left_after_a_period"]},
                             {"exact_period_s", exact},
                             {"backward_euler_period_s", backward_euler_period(dt)}});
    copy_machine(findings.rows.back(), cell);
    const bool xpbd = setting.compliance.has_value();
    section.table.rows.push_back({setting.title, or_none(cell["period_s"], "%.5f"),
                                  xpbd ? formatted("%.5f", backward_euler_period(dt)) : "",
                                  or_none(cell["left_after_a_period"], "%.3f")});
    if (xpbd) {
      const double period = cell["period_s"].get<double>();
      xpbd_off = std::max(xpbd_off, std::abs(period / backward_euler_period(dt) - 1));
      if (setting.substeps == 1) xpbd_apart = std::max(xpbd_apart, std::abs(period / exact - 1));
      finest = period / exact - 1;
    } else {
      append(pbd, or_none(cell["period_s"], "%.3f s"));
    }
    std::string points;
    const auto a = cell["a_m"].get<std::vector<double>>();
    for (std::size_t n = 0; n < a.size(); ++n) points += formatted("%g %g\n", static_cast<double>(n) * dt, 1 + a[n]);
    if (setting.substeps < 100)
      chart.series.push_back(
          {points,
           (setting.substeps == 1 && setting.iterations != 1 && xpbd ? "with points lw 2 ps 1.4 "
                                                                     : "with linespoints lw 1.5 ps 0.6 ") +
               std::string(styles[k % std::size(styles)]),
           setting.title});
  }
  section.sentences = {
      formatted("The period is %.5f s in closed form. The paper prints curves and no number: XPBD's period does not "
                "depend on the iterations, PBD's does.",
                exact),
      formatted(
          "malha: the error of XPBD with 1, 5 and 10 iterations is %.2g %% for all of them, because it is that of "
          "backward Euler, whose period agrees to %.1e; with the finest substeps it is %.2g %%.",
          100 * xpbd_apart, xpbd_off, 100 * finest),
      "PBD with k = 0.1 a projection and 1, 5 and 10 iterations has the periods " + pbd + "."};
  section.chart = chart;
  findings.sections.push_back(section);
}

int count_spring(bool quick) { return static_cast<int>(spring_settings(quick).size()); }

}  // namespace

const PublishedPart kSpringOf2016{count_spring, add_spring};

}  // namespace malha::study
