// SPDX-License-Identifier: Apache-2.0
// Charts of the benchmarks, drawn by gnuplot where it is installed. Their colours are Okabe and Ito's, which
// colour-blind readers can distinguish (#0072b2, #56b4e9, #009e73, #e69f00, #d55e00, #cc79a7, #000000); bars and shades
// use a few others.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace malha::bench {

/// The points of a series, and how gnuplot draws them.
struct Series {
  std::string data;   // one line of numbers per point
  std::string style;  // what follows the data in a plot command: "with lines lw 2"
  std::string title;  // without quotes
};

/// Draws the series into FOLDER/NAME.svg and .png; `settings` are gnuplot commands that come first. Returns the reason
/// of a failure, or an empty string. Charts of an earlier run are removed either way, since they would not fit the new
/// rows.
std::string draw(const std::string& settings, const std::vector<Series>& series, const std::filesystem::path& folder,
                 const std::string& name);

}  // namespace malha::bench
