// Facts of the study "accuracy" in its quick version: orders of convergence, and who is more accurate at equal work.
#include <cmath>
#include <set>

#include "tests/support.h"
#include "tools/study/accuracy.h"
#include "tools/study/accuracy_points.h"

namespace malha::study {
namespace {

/// Run once for all tests.
const Findings& quick_accuracy() {
  static const std::atomic<bool> no_stop{false};
  static const Findings findings = [] {
    const TemporaryFolder folder;
    Cells cells(folder / "cells.jsonl", {}, true, no_stop);
    return run_accuracy(cells);
  }();
  return findings;
}

/// Of one case after 1 s.
std::vector<Point> quick_points(const std::string& of) { return points_at(quick_accuracy().rows, of, 1); }

const Point& point_of(const std::vector<Point>& points, const std::string& series, const std::string& settings) {
  for (const Point& point : points)
    if (point.series == series && point.settings == settings) return point;
  throw std::runtime_error("there is no " + series + " " + settings);
}

TEST(StudyAccuracy, FindsTheOrdersOfTheIntegrators) {
  for (const char* of : {"oscillator", "orbit"}) {
    const std::vector<Point> points = quick_points(of);
    EXPECT_NEAR(order_of(points, "RK4"), 4, 0.3) << of;
    EXPECT_NEAR(order_of(points, "XPBD, substeps, double"), 1, 0.3) << of << ": as backward Euler";
  }
}

TEST(StudyAccuracy, FindsThatXpbdOfOneSpringIsBackwardEuler) {
  for (const char* of : {"oscillator", "orbit"}) {
    const std::vector<Point> points = quick_points(of);
    for (const char* n : {"1", "4", "16", "64"}) {
      const Point& xpbd = point_of(points, "XPBD, substeps, double", std::string(n) + "x1");
      const Point& newton = point_of(points, "backward Euler, Newton", std::string(n) + " a frame");
      EXPECT_NEAR(xpbd.error, newton.error, 0.02 * newton.error) << of << " " << n;
    }
  }
}

TEST(StudyAccuracy, FindsThatRefineLeadsToBackwardEuler) {
  const std::vector<Point> points = quick_points("orbit");
  const double paper = point_of(points, "Desbrun, refine, 16 substeps", "16, r = 0").error;
  const double refined = point_of(points, "Desbrun, refine, 16 substeps", "16, r = 16").error;
  const double newton = point_of(points, "backward Euler, Newton", "16 a frame").error;
  EXPECT_NEAR(refined, newton, 0.01 * newton);
  EXPECT_GT(std::abs(paper - newton), std::abs(refined - newton));
}

TEST(StudyAccuracy, SaysWhoIsCheapestAndDrawsACostAndAWorkChartACase) {
  std::set<std::string> charts;
  for (const Section& section : quick_accuracy().sections) {
    EXPECT_FALSE(section.sentences.empty()) << section.title;
    ASSERT_TRUE(section.chart);
    charts.insert(section.chart->name);
    EXPECT_GE(section.chart->series.size(), 8u) << section.title;
  }
  EXPECT_TRUE(charts.contains("oscillator_cost") && charts.contains("orbit_work"));
}

}  // namespace
}  // namespace malha::study
