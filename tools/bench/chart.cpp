#include "tools/bench/chart.h"

#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <set>
#include <sstream>
#include <system_error>

#include "host/base/shown.h"

namespace malha::bench {

namespace {

/// A gnuplot data block and how it is drawn.
struct Series {
  std::string block, style, title;
};

bool is_drawn(const Row& row) { return row.library == "bullet" || row.schedule == Schedule{10, 1}; }

std::string colour(const Row& row) {
  if (row.library == "bullet") return "#d95f02";
  return row.threads == 1 ? "#1f4e9c" : "#1b9e77";
}

std::string name(const Row& row) {
  return (row.library == "bullet" ? "Bullet, " : "malha, ") + counted(row.threads, "thread");
}

/// Lines of the grids, and open marks of the irregular mesh, for each library and number of threads.
std::vector<Series> series(const std::vector<Row>& rows) {
  std::map<std::string, std::pair<Series, std::string>> blocks;  // by a key that sorts them as the legend shows them
  const auto add = [&blocks](const std::string& key, const Series& how, const std::string& data) {
    auto& [drawn, lines] = blocks.try_emplace(key, how, "").first->second;
    lines += data;
  };
  for (const Row& row : rows) {
    if (!is_drawn(row)) continue;
    const bool grid = row.case_name == "grid";
    char key[64], data[160], floor[80];
    std::snprintf(key, sizeof key, "%d %04d %s", row.library == "bullet", row.threads, grid ? "grid" : "irregular");
    std::snprintf(data, sizeof data, "%.9g %.9g %.9g %.9g\n", row.side, row.ns_per_projection(), row.ns_min(),
                  row.ns_max());
    const std::string lines = "lw 2 lc rgb '" + colour(row) + "'";
    add(key,
        {"", grid ? "with yerrorlines pt 7 ps 0.9 " + lines : "with yerrorbars pt 6 ps 1.4 " + lines,
         name(row) + (grid ? "" : ", irregular")},
        data);
    if (row.library == "bullet") continue;
    std::snprintf(floor, sizeof floor, "%.9g %.9g\n", row.side, row.floor_ns());
    add("2" + std::string(key),
        {"", grid ? "with linespoints dt 2 pt 7 ps 0.4 " + lines : "with points pt 2 " + lines,
         "floor, " + name(row).substr(7) + (grid ? "" : ", irregular")},
        floor);
  }
  std::vector<Series> all;
  for (auto& [key, entry] : blocks) {
    auto& [drawn, data] = entry;
    drawn.block = "$block" + std::to_string(all.size()) + " << END\n" + data + "END\n";
    all.push_back(drawn);
  }
  return all;
}

/// A string as gnuplot takes it.
std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char letter : text) quoted += letter == '\'' ? "''" : std::string(1, letter);
  return quoted + "'";
}

std::string script(const std::vector<Row>& rows, const std::string& svg, const std::string& png) {
  std::set<int> sides;
  for (const Row& row : rows) sides.insert(static_cast<int>(row.side));
  std::ostringstream text, plot;
  const std::vector<Series> all = series(rows);
  for (const Series& one : all) text << one.block;
  text << "set logscale xy\nset xlabel 'particles a side (irregular mesh: square root of their number)'\nset ylabel "
          "'ns per projection (whole step)'\n"
       << "set title 'A hanging cloth in float: malha with 10 substeps of 1 iteration, Bullet with 10 iterations'\n"
       << "set xrange [" << *sides.begin() / 1.4 << ":" << *sides.rbegin() * 1.4 << "]\n"
       << "set key outside right center Left reverse spacing 1.3\nset grid lt 1 lw 1 lc rgb '#dddddd'\nset border 3\n"
       << "set tics nomirror\nset format y '%g'\nset xtics (";
  for (const int side : sides) text << (side == *sides.begin() ? "" : ", ") << side;
  text << ")\n";
  for (std::size_t k = 0; k < all.size(); ++k)
    plot << (k == 0 ? "plot " : ", ") << "$block" << k << " " << all[k].style << " title '" << all[k].title << "'";
  text << "set terminal svg size 1100,620 font 'sans,15' background rgb 'white'\nset output " << quote(svg) << "\n"
       << plot.str() << "\nset terminal pngcairo size 1600,900 font 'sans,15' background rgb 'white'\nset output "
       << quote(png) << "\n"
       << plot.str() << "\nunset output\n";
  return text.str();
}

/// The exit status of gnuplot fed with the script; 127 where there is none.
int feed_gnuplot(const std::string& text) {
  const auto before = std::signal(SIGPIPE, SIG_IGN);  // where it ends early, its status says so
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

std::string draw_chart(const std::vector<Row>& rows, const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  const fs::path svg = folder / "projection.svg", png = folder / "projection.png";
  const fs::path new_svg = svg.string() + ".tmp", new_png = png.string() + ".tmp";
  std::error_code error, ignored;
  fs::remove(svg, ignored), fs::remove(png, ignored);  // those of an earlier run would not fit the new rows
  const int status = feed_gnuplot(script(rows, new_svg.string(), new_png.string()));
  if (status == 0) {
    fs::rename(new_svg, svg, error);
    if (!error) fs::rename(new_png, png, error);
    if (!error) return "";
  }
  fs::remove(new_svg, ignored), fs::remove(new_png, ignored);
  if (status == 127) return "gnuplot is not here (Debian: gnuplot-nox)";
  return status != 0 ? "gnuplot failed" : "cannot write " + svg.string() + ": " + error.message();
}

}  // namespace malha::bench
