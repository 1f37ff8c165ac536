// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/gnuplot.h"

#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <map>
#include <sstream>
#include <system_error>

namespace malha::bench {

namespace {

/// Quotes a string for gnuplot.
std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char letter : text) quoted += letter == '\'' ? "''" : std::string(1, letter);
  return quoted + "'";
}

/// Place and font of a caption; "noenhanced" keeps gnuplot from reading its letters as markup.
constexpr const char* kCaptionPlace =
    " at screen 0.01, screen 0.025 left noenhanced font ',10' textcolor rgb '#555555'\n";

std::string script(const std::string& settings, const std::vector<Series>& series, const std::string& svg,
                   const std::string& png, const std::string& caption) {
  std::ostringstream text, plot;
  for (std::size_t k = 0; k < series.size(); ++k) {
    text << "$block" << k << " << END\n" << series[k].data << "END\n";
    plot << (k == 0 ? "plot " : ", ") << "$block" << k << " " << series[k].style << " title '" << series[k].title
         << "'";
  }
  text << "set key outside right center Left reverse spacing 1.3\n"
       << "set grid lt 1 lw 1 lc rgb '#dddddd'\nset border 3\nset tics nomirror\n"
       << settings << (caption.empty() ? "" : "set bmargin 5.5\nset label 999 " + quote(caption) + kCaptionPlace)
       << "set terminal svg size 1100,620 font 'sans,15' background rgb 'white'\nset output " << quote(svg) << "\n"
       << plot.str() << "\nset terminal pngcairo size 1600,900 font 'sans,15' background rgb 'white'\nset output "
       << quote(png) << "\n"
       << plot.str() << "\nunset output\n";
  return text.str();
}

/// Runs gnuplot on the script and returns its exit status; 127 if it is not installed.
int feed_gnuplot(const std::string& text) {
  const auto before = std::signal(SIGPIPE, SIG_IGN);  // if gnuplot ends early, its status tells
  std::FILE* pipe = popen("command -v gnuplot >/dev/null || exit 127; exec gnuplot", "w");
  int status = 127;
  if (pipe != nullptr) {
    std::fwrite(text.data(), 1, text.size(), pipe);
    status = pclose(pipe);
    status = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  }
  std::signal(SIGPIPE, before);
  return status;
}

/// The last point of a series, and the range of all its values.
struct Extent {
  double x = 0, y = 0, least = 1e300, most = 0;
};

Extent extent(const std::string& data) {
  Extent all;
  std::istringstream lines(data);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    if (!(numbers >> all.x >> all.y)) continue;
    double value = all.y;
    do all.least = std::min(all.least, value), all.most = std::max(all.most, value);
    while (numbers >> value);
  }
  return all;
}

/// Moves ascending heights apart until neighbours differ by `gap`: the mean of moving all of them up, and all of them
/// down.
std::vector<double> with_least_gap(const std::vector<double>& heights, double gap) {
  std::vector<double> up = heights, down = heights;
  for (std::size_t k = 1; k < up.size(); ++k) up[k] = std::max(up[k], up[k - 1] + gap);
  for (std::size_t k = down.size(); k-- > 1;) down[k - 1] = std::min(down[k - 1], down[k] - gap);
  for (std::size_t k = 0; k < up.size(); ++k) up[k] = (up[k] + down[k]) / 2;
  return up;
}

}  // namespace

std::string label_series_ends(const std::vector<Series>& all, bool logarithmic) {
  double least = 1e300, most = 0;
  for (const Series& series : all) {
    const Extent of = extent(series.data);
    least = std::min(least, of.least), most = std::max(most, of.most);
  }
  const auto scale = [&](double y) { return logarithmic ? std::log10(y) : y; };
  const double low = logarithmic ? std::floor(scale(least)) : 0;
  const double high = logarithmic ? std::max(std::ceil(scale(most)), low + 1) : 1.05 * most;
  std::map<double, std::vector<std::pair<double, const Series*>>> ends;  // by x; each with its height in the chart
  for (const Series& series : all) {
    const Extent of = extent(series.data);
    ends[of.x].emplace_back((scale(of.y) - low) / (high - low), &series);
  }
  std::ostringstream text;
  text << "unset key\nset rmargin at screen 0.74\nset style textbox opaque noborder margins 0.2,0.2\nset yrange ["
       << (logarithmic ? std::pow(10, low) : 0) << ":" << (logarithmic ? std::pow(10, high) : high) << "]\n";
  for (auto& [x, group] : ends) {
    std::stable_sort(group.begin(), group.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<double> heights;
    for (const auto& end : group) heights.push_back(end.first);
    constexpr double line = 0.047;  // height of a line of text, in heights of the chart
    heights = with_least_gap(heights, line);
    for (std::size_t k = 0; k < group.size(); ++k) {
      const Series& series = *group[k].second;
      const std::size_t colour = series.style.find("rgb '");
      text << "set label " << quote(series.title) << " at first " << x << ", graph " << heights[k]
           << " left offset 1.4,0 noenhanced front boxed textcolor "
           << (colour == std::string::npos ? "rgb 'black'" : series.style.substr(colour, 13)) << "\n";
    }
  }
  return text.str();
}

std::string draw(const std::string& settings, const std::vector<Series>& series, const std::filesystem::path& folder,
                 const std::string& name, const std::string& caption) {
  namespace fs = std::filesystem;
  const fs::path svg = folder / (name + ".svg"), png = folder / (name + ".png");
  const fs::path new_svg = svg.string() + ".tmp", new_png = png.string() + ".tmp";
  std::error_code error, ignored;
  fs::remove(svg, ignored), fs::remove(png, ignored);
  const int status = feed_gnuplot(script(settings, series, new_svg.string(), new_png.string(), caption));
  if (status == 0) {
    fs::rename(new_svg, svg, error);
    if (!error) fs::rename(new_png, png, error);
    if (!error) return "";
  }
  fs::remove(new_svg, ignored), fs::remove(new_png, ignored);
  if (status == 127) return "gnuplot is not installed (Debian: gnuplot-nox)";
  return status != 0 ? "gnuplot failed" : "cannot write " + svg.string() + ": " + error.message();
}

}  // namespace malha::bench
