// SPDX-License-Identifier: Apache-2.0
// Quick version of the study "accuracy": orders of convergence, and accuracy at equal work.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <set>

#include "tests/support.h"
#include "tests/tools/study/quick_study.h"
#include "tools/study/accuracy/accuracy.h"
#include "tools/study/accuracy/cases.h"
#include "tools/study/accuracy/points.h"
#include "tools/study/reference/catenary.h"
#include "tools/study/reference/steps.h"
#include "tools/study/reference/tetrahedra.h"

namespace malha::study {
namespace {

const Findings& quick_accuracy() { return quick_findings<run_accuracy>(); }

Points quick_points(const std::string& of, double time = 1) { return points_at(quick_accuracy().rows, of, time); }

const Point& point_of(const Points& points, const std::string& series, const std::string& settings) {
  for (const Point& point : points)
    if (point.series == series && point.settings == settings) return point;
  throw std::runtime_error("there is no " + series + " " + settings);
}

const Json& row_of(const std::string& of, const std::string& series, const std::string& settings, double time = 1) {
  for (const Json& row : quick_accuracy().rows)
    if (row["case"] == of && row["series"] == series && row["settings"] == settings && row["time_s"] == time)
      return row;
  throw std::runtime_error("there is no " + series + " " + settings);
}

TEST(StudyAccuracy, FindsTheOrdersOfTheIntegrators) {
  for (const char* of : {"oscillator", "orbit", "sheet7", "drum5", "shell", "chain"}) {
    const Points points = quick_points(of);
    EXPECT_NEAR(order_of(points, "RK4"), 4, 0.3) << of;
    // A spring that oscillates five times a second needs more substeps than Newton's method is run with; XPBD with one
    // spring is backward Euler.
    const bool one_spring = of == std::string("oscillator") || of == std::string("orbit");
    EXPECT_NEAR(order_of(points, one_spring ? "XPBD, substeps, double" : "backward Euler, Newton"), 1, 0.35) << of;
    // For bodies, substeps with a symmetric sweep are more accurate than as many substeps of exact backward Euler.
    if (!one_spring) {
      EXPECT_LT(point_of(points, "XPBD, substeps, double", "16x1").error,
                0.6 * point_of(points, "backward Euler, Newton", "16 a frame").error)
          << of;
    }
  }
}

double error_of_order(const std::string& series, int substeps) {
  for (const Json& row : quick_accuracy().rows)
    if (row["case"] == "order" && row["series"] == series && row["substeps"] == substeps)
      return row["rms_error_m"].get<double>();
  throw std::runtime_error("there is no " + series);
}

TEST(StudyAccuracy, FindsThatConvergedSubstepsAreOfSecondOrderExceptAtTheStart) {
  const auto slope = [](const char* series) {
    return std::log(error_of_order(series, 10) / error_of_order(series, 40)) / std::log(4);
  };
  EXPECT_NEAR(slope("the same, to half a substep later"), 2, 0.35);
  EXPECT_NEAR(slope("malha, as many iterations as substeps"), 1, 0.2);
  for (const int n : {10, 20, 40}) {
    // The first-order error is due to the whole kick of the first substep: v h / 2 at 3 m/s, RMS.
    EXPECT_NEAR(error_of_order("malha, as many iterations as substeps", n), 3.0 / 60 / n / 2, 0.3 * 3.0 / 60 / n / 2)
        << n;
    EXPECT_LT(error_of_order("malha, 1 iteration", n), 0.3 * error_of_order("one way, gradients at the end", n)) << n;
  }
}

/// With a rotating spring XPBD is more accurate: it moves the ends along their direction at the start of the substep.
TEST(StudyAccuracy, FindsThatXpbdOfOneSpringIsBackwardEulerUnlessItRotates) {
  for (const char* of : {"oscillator", "orbit"}) {
    const Points points = quick_points(of);
    for (const char* n : {"1", "4", "16"}) {
      const Point& xpbd = point_of(points, "XPBD, substeps, double", std::string(n) + "x1");
      const Point& newton = point_of(points, "backward Euler, Newton", std::string(n) + " a frame");
      const double off = xpbd.error / newton.error - 1;
      // One substep a frame hardly resolves the rotation, so that the two directions differ much.
      const double most = n == std::string("1") ? 0.05 : 0;
      EXPECT_TRUE(of == std::string("oscillator") ? std::abs(off) < 1e-6 : off < most) << of << " " << n << ": " << off;
    }
  }
}

TEST(StudyAccuracy, FindsThatIterationsAndRefinementConvergeToBackwardEuler) {
  for (const char* of : {"sheet7", "drum5", "shell", "chain"}) {
    const Points points = quick_points(of);
    const double one = point_of(points, "backward Euler, Newton", "1 a frame").error;
    // Iterations ignore the rotation of gradients within a step, which causes a part of the step's error.
    EXPECT_NEAR(point_of(points, "XPBD, iterations", "1x256").error, one, 0.05 * one) << of;
    const double sixteen = point_of(points, "backward Euler, Newton", "16 a frame").error;
    EXPECT_NEAR(point_of(points, "Desbrun, refine, 16 substeps", "16, r = 16").error, sixteen, 0.1 * sixteen) << of;
  }
}

TEST(StudyAccuracy, FindsThatSubstepsAreMoreAccurateThanIterationsAtEqualWork) {
  for (const char* of : {"oscillator", "orbit", "sheet7", "drum5", "shell", "chain", "beam"}) {
    const Points points = quick_points(of);
    const Point& substeps = point_of(points, "XPBD, substeps, double", "64x1");
    const Point& iterations = point_of(points, "XPBD, iterations", "1x64");
    EXPECT_EQ(substeps.sweeps, iterations.sweeps);
    EXPECT_LT(substeps.error, iterations.error / 2) << of;
  }
}

TEST(StudyAccuracy, FindsThatFloatIsAsAccurateAsDoubleWithManySubsteps) {
  const Points points = quick_points("shell");
  const Point& in_double = point_of(points, "XPBD, substeps, double", "256x1");
  EXPECT_LT(point_of(points, "XPBD, substeps, float", "256x1").error, 1.5 * in_double.error);
  EXPECT_NEAR(point_of(points, "XPBD, substeps, float", "4x1").error,
              point_of(points, "XPBD, substeps, double", "4x1").error, 1e-3)
      << "few substeps are as accurate in float";
}

TEST(StudyAccuracy, FindsMethodsThatConserveMomentumOfAFreeBody) {
  const Points points = quick_points("shell");
  const double whole = 0.5;  // kg m^2/s: the shell's angular momentum is 0.6
  const Point& inertia = point_of(points, "Desbrun, corrector inertia", "16, r = 0");
  EXPECT_LT(inertia.angular_momentum, 1e-10);
  EXPECT_GT(point_of(points, "Desbrun, corrector off", "16, r = 0").angular_momentum, whole);
  EXPECT_GT(point_of(points, "Desbrun, corrector paper", "64, r = 0").angular_momentum, whole);
  EXPECT_GT(inertia.error, point_of(points, "XPBD, substeps, double", "16x1").error);
  for (const Point& point : points) {
    if (point.series.ends_with("float") || point.series.ends_with("int16") || point.series.starts_with("PBD")) continue;
    EXPECT_LT(point.momentum, 1e-9) << point.series << " " << point.settings << ": all conserve momentum in double";
  }
}

TEST(StudyAccuracy, KnowsTheMotionOfATautSheetForFiveSeconds) {
  EXPECT_LT(row_of("drum5", "RK4", "1 a frame", 5)["truth_known_to_m"], 1e-9);
  const Points late = quick_points("drum5", 5);
  EXPECT_LT(point_of(late, "RK4", "64 a frame").error, 1e-8);
  EXPECT_NEAR(order_of(late, "RK4"), 4, 0.3);
  const Point& cheap = point_of(late, "XPBD, substeps, double", "16x1");
  const Point& costly = point_of(late, "XPBD, substeps, double", "256x1");
  EXPECT_LT(costly.error, cheap.error / 4) << "the motion is not chaotic";
}

TEST(StudyAccuracy, KeepsAllSpringsOfATautSheetUnderTension) {
  for (const AccuracyCase& of : accuracy_cases(true)) {
    if (!of.taut) continue;
    const auto system = system_of(of);
    State state = system->start;
    double sunk = 0;
    for (int step = 0; step < 5 * 60 * 64; ++step) {
      rk4(*system, kFrame / 64, state);
      ASSERT_GT(system->strains(state.x).minCoeff(), 0.05) << "of 0.11 at the start; step " << step;
      sunk = std::max(sunk, -state.x.minCoeff());
    }
    EXPECT_GT(sunk, 0.05) << "it moves";
  }
}

// Each step multiplies the energy of an undamped mode by 1 + (omega h)^2.
TEST(StudyAccuracy, FindsThatExplicitEulerGainsTheTheoreticalEnergy) {
  const Points points = quick_points("oscillator");
  for (const int n : {64, 256}) {
    const std::string settings = std::to_string(n) + " a frame";
    const double h = kFrame / n, growth = std::pow(1 + 1000 * h * h, 60 * n) - 1;  // omega^2 = 1000 / s^2
    EXPECT_NEAR(point_of(points, "explicit Euler", settings).energy, growth, 1e-9 * growth) << n;
    EXPECT_LT(std::abs(point_of(points, "symplectic Euler", settings).energy), std::sqrt(1000) * h / 2) << n;
  }
  for (const char* of : {"oscillator", "orbit", "shell", "chain", "drum5"}) {
    const Points all = quick_points(of);
    EXPECT_GT(point_of(all, "explicit Euler", "256 a frame").energy, 0) << of;
    EXPECT_GT(point_of(all, "explicit Euler", "256 a frame").error,
              2 * point_of(all, "symplectic Euler", "256 a frame").error)
        << of;
  }
}

TEST(StudyAccuracy, FindsThatPbdErrsInDoubleAsInFloat) {
  for (const char* of : {"sheet7", "drum5", "chain"}) {
    const Points points = quick_points(of);
    for (const char* settings : {"1x1", "1x16", "1x64"}) {
      const double in_double = point_of(points, "PBD, iterations, double", settings).error;
      EXPECT_GT(in_double, 0.01) << of << " " << settings;
      EXPECT_NEAR(point_of(points, "PBD, iterations, float", settings).error, in_double, 1e-3) << of << " " << settings;
    }
  }
}

TEST(StudyAccuracy, FindsThatOnlyExplicitMethodsDivergeAtLargeSteps) {
  // 451 rad/s in steps of 1/60 s: 2 / omega_max takes 4 substeps.
  EXPECT_EQ(row_of("sheet7", "symplectic Euler", "1 a frame")["status"], "diverged");
  EXPECT_EQ(row_of("sheet7", "symplectic Euler", "4 a frame")["status"], "finished");
  EXPECT_EQ(row_of("sheet7", "explicit Euler", "16 a frame")["status"], "diverged") << "it has no stable step";
  for (const Json& row : quick_accuracy().rows) {
    if (!row["ours"].get<bool>() || row["series"].get<std::string>().ends_with("paper")) continue;
    EXPECT_EQ(row["status"], "finished") << row["key"];
  }
}

TEST(StudyAccuracy, FindsTheElasticCatenary) {
  const Points points = quick_points("catenary", 5);
  const double own = 5.7e-4;  // m: distance of the equilibrium of 8 springs from the continuous line
  for (const char* settings : {"1, r = 0", "64, r = 0"})
    EXPECT_NEAR(point_of(points, "Desbrun, substeps", settings).error, own, 1e-5) << "for any step";
  EXPECT_NEAR(point_of(points, "XPBD, substeps, double", "256x1").error, own, 1e-5);
  EXPECT_GT(point_of(points, "PBD, iterations, float", "1x64").error, 0.05) << "PBD has no stiffness in N/m";
}

TEST(StudyAccuracy, FindsTheHeavyElasticaByFilteredBendingAtTheFewestSubsteps) {
  const Points points = quick_points("cantilever", 5);
  const double filtered = point_of(points, "XPBD, substeps, filtered bending, float", "4x1").error;
  EXPECT_LT(filtered, 0.02);
  EXPECT_GT(point_of(points, "XPBD, substeps, float", "4x1").error, 5 * filtered);
  // Both converge to the equilibrium of the mesh.
  EXPECT_NEAR(point_of(points, "XPBD, substeps, filtered bending, float", "256x1").error,
              point_of(points, "XPBD, substeps, float", "256x1").error, 2e-3);
}

TEST(StudyAccuracy, FindsThatFilteredBendingSwingsAsBackwardEulerAndAsTheTruth) {
  const Points points = quick_points("swing1", 0.3);
  for (const char* n : {"1", "4", "16"}) {
    const double filtered = point_of(points, "XPBD, substeps, filtered bending, float", std::string(n) + "x1").error;
    const double newton = point_of(points, "backward Euler, Newton", std::string(n) + " a frame").error;
    EXPECT_NEAR(filtered / newton, 1, 0.15) << n;
  }
  const double filtered = point_of(points, "XPBD, substeps, filtered bending, float", "4x1").error;
  EXPECT_LT(filtered, 0.01);
  EXPECT_GT(point_of(points, "XPBD, substeps, float", "4x1").error, 10 * filtered);
  EXPECT_GT(point_of(points, "Desbrun, substeps", "4, r = 0").error, 10 * filtered);
  // The hinges are a discretisation other than that of the true motion, which many substeps come near all the same.
  for (const char* series : {"XPBD, substeps, filtered bending, float", "XPBD, substeps, float"})
    EXPECT_LT(point_of(points, series, "256x1").error, 2e-4) << series;
}

TEST(StudyAccuracy, HasSentencesATableAndChartsOfCostAndWorkForEachCase) {
  std::set<std::string> charts;
  for (const Section& section : quick_accuracy().sections) {
    EXPECT_FALSE(section.sentences.empty()) << section.title;
    ASSERT_TRUE(section.chart);
    charts.insert(section.chart->name);
    EXPECT_FALSE(section.chart->series.empty()) << section.title;
    for (const auto& row : section.table.rows) EXPECT_EQ(row.size(), section.table.columns.size());
  }
  for (const char* of : {"oscillator", "orbit", "sheet7", "drum5", "shell", "chain", "catenary", "cantilever", "swing1",
                         "beam", "sunk_beam"})
    EXPECT_TRUE(charts.contains(std::string(of) + "_cost") && charts.contains(std::string(of) + "_work")) << of;
}

TEST(StudyReference, AGridThatBendsComesToRestAsAHeavyElastica) {
  const auto off = [](int cells) {
    const AccuracyCase strip = cantilever(cells);
    return rms_distance(relax_to_rest(*spring_system(strip.scene), 1e-4), strip.exact(0).x);
  };
  const double coarse = off(8), fine = off(16);
  EXPECT_LT(coarse, 0.02);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.4) << "second order in the edge, with the clamp at the second row";
}

TEST(StudyReference, AStiffTautLineHangsInAParabola) {
  const std::vector<Vec3> line = elastic_catenary(1, 1.001, 1, 1e9, 10);
  EXPECT_NEAR(line[10][0], 1, 1e-12);
  EXPECT_NEAR(line[10][1], 0, 1e-12);
  EXPECT_NEAR(-line[5][1], std::sqrt(3.0 / 8 * 0.001), 1e-4) << "length - span = 8/3 sag^2 / span";
}

TEST(StudyAccuracy, StopsOnCtrlCAndResumes) {
  const TemporaryFolder folder;
  MalhaProcess process({"study", "accuracy", "--quick", "--out", "out"}, folder / ".");
  const auto journal = folder / "out/accuracy.quick.cells.jsonl";
  const auto cells = [&] {
    const std::string bytes = bytes_of(journal);
    return std::count(bytes.begin(), bytes.end(), '\n') - 1;
  };
  while (process.running() && cells() < 5) usleep(1000);
  process.send(SIGINT);
  const Ended ended = process.wait();
  EXPECT_EQ(ended.status, 130) << ended.err;
  EXPECT_TRUE(has(ended.err, "interrupted; go on with: malha study accuracy --quick --out out\n")) << ended.err;
  const auto kept = cells();
  EXPECT_GE(kept, 5);
  const std::string bytes = bytes_of(journal);
  EXPECT_EQ(bytes.back(), '\n') << "whole lines";
  MalhaProcess again({"study", "accuracy", "--quick", "--out", "out"}, folder / ".");
  while (again.running() && cells() <= kept) usleep(1000);
  again.send(SIGINT);
  again.wait();
  EXPECT_EQ(bytes_of(journal).substr(0, bytes.size()), bytes) << "finished cells are not measured again";
}

}  // namespace
}  // namespace malha::study
