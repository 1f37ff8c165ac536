// SPDX-License-Identifier: Apache-2.0
#include "tools/study/stability/map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/bench/output.h"
#include "tools/study/rows.h"

namespace malha::study {

namespace {

using bench::formatted;

constexpr std::array<const char*, 3> kVerdicts{"stable", "bounded but wrong", "diverged"};

/// Position of a value on an axis: 0 at its first value, 1 at the next; extrapolated beyond its ends.
double axis_position(const Axis& axis, double value) {
  const std::vector<double>& v = axis.values;
  const bool rises = v.back() >= v.front();
  std::size_t k = 1;
  while (k + 1 < v.size() && (rises ? value > v[k] : value < v[k])) ++k;
  return v.size() < 2 ? 0 : double(k - 1) + std::log(value / v[k - 1]) / std::log(v[k] / v[k - 1]);
}

/// The height at which a position on the axis is drawn: the smallest value is the lowest.
double height(const Axis& axis, double axis_position) {
  return axis.values.back() < axis.values.front() ? double(axis.values.size() - 1) - axis_position : axis_position;
}

/// Layout and data of a map's chart: panels in a grid whose cells are as large as the largest panel.
class MapDrawing {
 public:
  MapDrawing(const std::vector<Panel>& panels, int across) : across_(across) {
    for (const Panel& panel : panels) {
      wide_ = std::max(wide_, double(panel.x.values.size()));
      high_ = std::max(high_, double(panel.y.values.size()));
    }
    rows_ = (static_cast<int>(panels.size()) + across - 1) / across;
    line_ = rows_ * high_ / (30 - 4.2 * rows_), high_ += 4.2 * line_;     // the chart is 30 lines of text high
    gap_ = across * wide_ * 0.055 / (1 - 0.055 * across), wide_ += gap_;  // and 18 gaps wide
    for (std::size_t k = 0; k < panels.size(); ++k)
      add(panels[k], double(k % across) * wide_, rows_ - 1 - int(k) / across,
          k % across == 0 || panels[k - 1].y.name != panels[k].y.name);
  }

  Chart chart(const std::string& name, const std::string& title) const {
    Chart chart{name, "set title '" + title + "'\n" + labels_};
    chart.settings +=
        "unset xtics\nunset ytics\nunset grid\nunset border\nset lmargin 1\nset rmargin 1\nset tmargin 3\n"
        "set key at screen 0.5,0.085 center center horizontal maxrows 1 width 1 font ',12'\n" +
        formatted("set xrange [%g:%g]\nset yrange [%g:%g]\n", -0.5 - gap_, across_ * wide_ - gap_ - 0.5,
                  -0.5 - 2.4 * line_, rows_ * high_ - 0.5 - 2.4 * line_);
    const std::array<const char*, 3> colours{"#b8dfc0", "#f3c96b", "#d9584b"};
    for (int k = 0; k < 3; ++k)
      if (!cells_[k].empty())
        chart.series.push_back(
            {cells_[k], formatted("with boxxyerror fs solid 1 noborder lc rgb '%s'", colours[k]), kVerdicts[k]});
    if (!warned_.empty())
      chart.series.push_back({warned_, "with points pt 7 ps 0.5 lc rgb '#222222'", "malha run warns"});
    if (!edges_.empty()) chart.series.push_back({edges_, "with lines lw 3 lc rgb '#222222'", "boundary, by bisection"});
    int colour = 0;
    for (const auto& [line, points] : theory_)
      chart.series.push_back(
          {points,
           formatted("with lines lw 3 dt (6,4) lc rgb '%s'", std::array{"#1f4e9c", "#8856a7", "#00838f"}[colour++ % 3]),
           line});
    return chart;
  }

 private:
  void label(const std::string& text, double x, double y, const char* how) {
    labels_ += "set label '" + text + formatted("' at %g,%g %s\n", x, y, how);
  }

  void add(const Panel& panel, double left, int row, bool names_y) {
    const double low = row * high_, wide = double(panel.x.values.size()), high = double(panel.y.values.size());
    label(panel.title, left - 0.5, low + high - 0.5 + 0.8 * line_, "left font ',13'");
    label(panel.x.name, left + wide / 2 - 0.5, low - 0.5 - 1.7 * line_, "center font ',11'");
    if (names_y) label(panel.y.name, left - 0.5 - 0.85 * gap_, low + high / 2 - 0.5, "center rotate font ',11'");
    for (std::size_t k = 0; k < panel.x.values.size(); ++k)
      label(short_number(panel.x.values[k]), left + double(k), low - 0.5 - 0.6 * line_, "center font ',9'");
    for (std::size_t k = 0; k < panel.y.values.size(); ++k)
      label(short_number(panel.y.values[k]), left - 0.5 - 0.08 * gap_, low + height(panel.y, double(k)),
            "right font ',9'");
    for (std::size_t c = 0; c < panel.columns.size(); ++c) {
      const Json& column = panel.columns[c];
      for (std::size_t k = 0; k < column["verdicts"].size(); ++k) {
        const double y = low + height(panel.y, double(k));
        cells_[column["verdicts"][k].get<int>()] += formatted("%g %g 0.48 0.48\n", left + double(c), y);
        if (column["warned"][k].get<bool>()) warned_ += formatted("%g %g\n", left + double(c), y);
      }
      for (const Json& edge : column["edges"]) {
        const double y =
            height(panel.y,
                   (axis_position(panel.y, edge[0].get<double>()) + axis_position(panel.y, edge[1].get<double>())) / 2);
        edges_ += formatted("%g %g\n%g %g\n\n", left + double(c) - 0.48, low + y, left + double(c) + 0.48, low + y);
      }
    }
    for (const TheoryLine& line : panel.theory) {
      auto known =
          std::find_if(theory_.begin(), theory_.end(), [&](const auto& one) { return one.first == line.title; });
      if (known == theory_.end()) known = theory_.insert(theory_.end(), {line.title, ""});
      known->second += inside(panel, line, left, low) + "\n";
    }
  }

  /// The part of a line that lies in its panel, extended by half a cell beyond its first and last point.
  static std::string inside(const Panel& panel, const TheoryLine& line, double left, double low) {
    std::string data;
    constexpr int parts = 40;
    for (std::size_t k = 0; k + 1 < line.points.size(); ++k) {
      const auto& [x0, y0] = line.points[k];
      const auto& [x1, y1] = line.points[k + 1];
      const double a0 = axis_position(panel.x, x0), a1 = axis_position(panel.x, x1);
      const double b0 = height(panel.y, axis_position(panel.y, y0)), b1 = height(panel.y, axis_position(panel.y, y1));
      const int first = k == 0 ? -parts / 2 : 0, last = k + 2 == line.points.size() ? parts + parts / 2 : parts;
      for (int part = first; part <= last; ++part) {
        const double t = double(part) / parts, b = b0 + t * (b1 - b0);
        const bool out = b < -0.5 || b > double(panel.y.values.size()) - 0.5;
        data += out ? "\n" : formatted("%g %g\n", left + a0 + t * (a1 - a0), low + b);
      }
    }
    return data;
  }

  int across_, rows_ = 0;
  double wide_ = 0, high_ = 0, line_ = 0, gap_ = 0;  // of a panel with its labels; in cells
  std::string labels_, edges_, warned_;
  std::array<std::string, 3> cells_;
  std::vector<std::pair<std::string, std::string>> theory_;
};

Json column(const Axis& y, bool whole, const std::function<Outcome(double y)>& trial) {
  Json found = Json::object();
  for (const char* list : {"verdicts", "strains", "rms", "gains", "warned", "edges"}) found[list] = Json::array();
  std::vector<Verdict> verdicts;
  for (const double value : y.values) {
    const Outcome outcome = trial(value);
    verdicts.push_back(outcome.verdict);
    found["verdicts"].push_back(int(outcome.verdict));
    found["strains"].push_back(outcome.strain);
    found["rms"].push_back(outcome.rms);
    found["gains"].push_back(outcome.gain);
    found["warned"].push_back(outcome.warned);
  }
  for (std::size_t k = 0; k + 1 < verdicts.size(); ++k) {
    const bool holds = verdicts[k] == Verdict::Stable;
    if (holds == (verdicts[k + 1] == Verdict::Stable)) continue;
    double low = y.values[k], high = y.values[k + 1];
    Verdict how = std::max(verdicts[k], verdicts[k + 1]);
    for (int turn = 0; turn < 6; ++turn) {
      const double middle = whole ? std::round(std::sqrt(low * high)) : std::sqrt(low * high);
      if (middle == low || middle == high) break;
      const Verdict verdict = trial(middle).verdict;
      (holds == (verdict == Verdict::Stable) ? low : high) = middle;
      if (verdict != Verdict::Stable) how = verdict;
    }
    found["edges"].push_back({low, high});
    if (holds) found["stable_to"] = low, found["fails_from"] = high, found["fails_as"] = kVerdicts[int(how)];
    if (!holds) found["stable_from"] = high;
  }
  return found;
}

Table map_table(const std::vector<Panel>& panels) {
  Table table{{"", "at", "of", "stable to", "fails from", "as"}, {}};
  for (const Panel& panel : panels)
    for (std::size_t k = 0; k < panel.columns.size(); ++k) {
      const Json& column = panel.columns[k];
      const auto number = [&column](const char* what, const char* none) {
        return column.contains(what) ? formatted("%.3g", column[what].get<double>()) : std::string(none);
      };
      const bool all = !column["verdicts"].empty() && !column.contains("stable_to") &&
                       column["verdicts"].back() == int(Verdict::Stable);
      table.rows.push_back({panel.title, short_number(panel.x.values[k]), panel.y.name,
                            number("stable_to", all ? "all" : "nowhere"), number("fails_from", all ? "nowhere" : "all"),
                            column.contains("fails_as") ? column["fails_as"].get<std::string>() : ""});
    }
  return table;
}

std::string warned_sentence(const std::vector<Panel>& panels) {
  int count[2][2]{};  // [fails][warned]
  for (const Panel& panel : panels)
    for (const Json& column : panel.columns)
      for (std::size_t k = 0; panel.is_malha && k < column["verdicts"].size(); ++k)
        ++count[column["verdicts"][k] != int(Verdict::Stable)][column["warned"][k].get<bool>()];
  return formatted(
      "malha run warns (dots) of %d of the %d settings that fail with malha's methods, and of %d of the %d that are "
      "stable, which lie near the boundary or beyond that of another chart (the filter's damping, rounding).",
      count[1][1], count[1][0] + count[1][1], count[0][1], count[0][0] + count[0][1]);
}

void add_rows(const std::string& map, const std::vector<Panel>& panels, Json& rows) {
  for (const Panel& panel : panels)
    for (std::size_t k = 0; k < panel.columns.size(); ++k) {
      Json row{{"map", map},
               {"panel", panel.title},
               {"x_name", panel.x.name},
               {"x", panel.x.values[k]},
               {"y_name", panel.y.name}};
      const Json& column = panel.columns[k];
      for (const char* what : {"stable_to", "fails_from", "fails_as"})
        row[what] = column.contains(what) ? column[what] : Json();
      for (std::size_t j = 0; j < panel.y.values.size(); ++j) {
        row["y"] = panel.y.values[j];
        row["verdict"] = kVerdicts[column["verdicts"][j].get<int>()];
        row["largest_strain"] = column["strains"][j];
        row["rms_strain"] = column["rms"][j];
        row["energy_gain"] = column["gains"][j];
        row["warned"] = column["warned"][j];
        copy_machine(row, column);
        rows.push_back(row);
      }
    }
}

}  // namespace

void run_columns(Panel& panel, Cells& cells, const std::string& key, const std::string& unit, bool whole,
                 const std::function<Outcome(std::size_t k, double y)>& trial) {
  for (std::size_t k = 0; k < panel.x.values.size(); ++k)
    panel.columns.push_back(cells(key + formatted("%g", panel.x.values[k]) + unit,
                                  [&] { return column(panel.y, whole, [&](double y) { return trial(k, y); }); }));
}

void complete_map_section(Section& section, const std::string& name, const std::string& title,
                          const std::vector<Panel>& panels, int across, Json& rows) {
  section.sentences.push_back(warned_sentence(panels));
  section.chart = MapDrawing(panels, across).chart(name, title);
  section.table = map_table(panels);
  add_rows(name, panels, rows);
}

std::string short_number(double value) {
  std::string text = formatted("%.3g", value);
  const bool round = value >= 1000 && std::fmod(value, 1000) == 0;
  if (const bool small = value > 0 && value < 0.01; small || round || text.find('e') != std::string::npos) {
    const int exponent = static_cast<int>(std::floor(std::log10(value) + 1e-9));
    text = formatted("%.3ge%d", value / std::pow(10, exponent), exponent);
  }
  if (value >= 1000 && value < 10000 && !round) text = formatted("%.0f", value);
  return text;
}

}  // namespace malha::study
