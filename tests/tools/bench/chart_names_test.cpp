// SPDX-License-Identifier: Apache-2.0
// Labels of series beside their last points, in gnuplot's charts.
#include <map>
#include <regex>

#include "tests/support.h"
#include "tools/bench/gnuplot.h"

namespace malha::bench {
namespace {

struct Name {
  double x, height;
  std::string colour;
};

std::map<std::string, Name> names_in(const std::string& settings) {
  std::map<std::string, Name> names;
  const std::regex label("set label '(.*)' at first (.*), graph (\\S+) .*textcolor rgb '(.*)'");
  std::smatch of;
  std::istringstream lines(settings);
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, of, label)) names[of[1]] = {std::stod(of[2]), std::stod(of[3]), of[4]};
  return names;
}

TEST(SeriesLabels, AreAtTheLastPointInTheColourOfTheLine) {
  const std::string settings = label_series_ends({{"1 1\n10 10\n", "with lines lc rgb '#0072b2' pt 7", "a"},
                                                  {"1 2\n5 900\n", "with lines lc rgb '#d55e00'", "b's"}});
  EXPECT_TRUE(has(settings, "set yrange [1:1000]\n")) << settings;
  const auto names = names_in(settings);
  EXPECT_EQ(names.at("a").x, 10);
  EXPECT_EQ(names.at("a").colour, "#0072b2");
  EXPECT_NEAR(names.at("a").height, 1.0 / 3, 1e-5) << "one of three decades";
  EXPECT_EQ(names.at("b''s").x, 5) << "quoted for gnuplot";
}

TEST(SeriesLabels, DoNotOverlap) {
  std::vector<Series> same;
  for (int k = 0; k < 6; ++k) same.push_back({"1 1\n2 30\n", "with lines", std::to_string(k)});
  const auto names = names_in(label_series_ends(same, false));
  for (int k = 1; k < 6; ++k)
    EXPECT_NEAR(names.at(std::to_string(k)).height - names.at(std::to_string(k - 1)).height, 0.047, 1e-5);
  EXPECT_NEAR((names.at("0").height + names.at("5").height) / 2, 1 / 1.05, 1e-5) << "around the end of the lines";
}

TEST(SeriesLabels, LeaveSpaceForErrorBarsInTheChart) {
  EXPECT_TRUE(has(label_series_ends({{"1 50 20 3000\n", "with yerrorlines", "a"}}), "set yrange [10:10000]\n"));
  EXPECT_TRUE(has(label_series_ends({{"1 1 0.5 2\n", "with yerrorlines", "a"}}, false), "set yrange [0:2.1]\n"));
}

}  // namespace
}  // namespace malha::bench
