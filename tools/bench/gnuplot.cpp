// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/gnuplot.h"

#include <sys/wait.h>

#include <csignal>
#include <cstdio>
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

std::string script(const std::string& settings, const std::vector<Series>& series, const std::string& svg,
                   const std::string& png) {
  std::ostringstream text, plot;
  for (std::size_t k = 0; k < series.size(); ++k) {
    text << "$block" << k << " << END\n" << series[k].data << "END\n";
    plot << (k == 0 ? "plot " : ", ") << "$block" << k << " " << series[k].style << " title '" << series[k].title
         << "'";
  }
  text << "set key outside right center Left reverse spacing 1.3\n"
       << "set grid lt 1 lw 1 lc rgb '#dddddd'\nset border 3\nset tics nomirror\n"
       << settings << "set terminal svg size 1100,620 font 'sans,15' background rgb 'white'\nset output " << quote(svg)
       << "\n"
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

}  // namespace

std::string draw(const std::string& settings, const std::vector<Series>& series, const std::filesystem::path& folder,
                 const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path svg = folder / (name + ".svg"), png = folder / (name + ".png");
  const fs::path new_svg = svg.string() + ".tmp", new_png = png.string() + ".tmp";
  std::error_code error, ignored;
  fs::remove(svg, ignored), fs::remove(png, ignored);
  const int status = feed_gnuplot(script(settings, series, new_svg.string(), new_png.string()));
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
