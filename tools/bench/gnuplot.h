// SPDX-License-Identifier: Apache-2.0
// Charts, drawn by gnuplot where it is installed. Their colours are Okabe and Ito's, which the colour-blind tell apart
// (#0072b2, #56b4e9, #009e73, #e69f00, #d55e00, #cc79a7, #000000), and of bars and shades some more.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace malha::bench {

/// Points and how they are drawn.
struct Series {
  std::string data;   // a line of numbers a point
  std::string style;  // as gnuplot takes it after the data: "with lines lw 2"
  std::string title;  // without quotes
};

/// Settings by which the name of each series stands beside its last point, not in a key, and apart from the others.
/// From 0 or, where `logarithmic`, from a power of ten to the next one above all values and error bars.
std::string names_at_ends(const std::vector<Series>& all, bool logarithmic = true);

/// Draws the series into FOLDER/NAME.svg and .png; `settings` are gnuplot's lines before. Gives back why it could not,
/// or nothing. Charts of an earlier run are gone either way: they would not fit the new rows. `caption`: a line in
/// small print below, which says what made the chart; "": none.
std::string draw(const std::string& settings, const std::vector<Series>& series, const std::filesystem::path& folder,
                 const std::string& name, const std::string& caption = "");

}  // namespace malha::bench
