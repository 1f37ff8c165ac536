// SPDX-License-Identifier: Apache-2.0
// Studies: measurements of malha's methods, with charts. A study is a function that measures cells and reports what
// they show, or a script in Python; the registry lists all of them.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "malha/scene.h"
#include "tools/bench/gnuplot.h"
#include "tools/study/cells.h"

namespace malha::study {

struct Chart {
  std::string name;      // the files are STUDY_NAME.svg and .png
  std::string settings;  // gnuplot commands before the plot
  std::vector<bench::Series> series = {};
};

struct Table {
  std::vector<std::string> columns = {};
  std::vector<std::vector<std::string>> rows = {};
};

/// Two scenes that are played side by side for their durations; the sides have their names.
struct Replay {
  std::string name;  // the file is STUDY_NAME.html
  std::string description;
  Scene left, right;
};

/// A part of the page: a title, sentences about the rows, a chart and a table.
struct Section {
  std::string title;
  std::vector<std::string> sentences = {};  // computed from the rows, never written by hand
  std::optional<Chart> chart = {};
  Table table = {};
  std::vector<Replay> replays = {};
};

/// Appends to a list in words: "a, b".
inline void append(std::string& list, const std::string& words, const char* between = ", ") {
  list += (list.empty() ? "" : between) + words;
}

/// The non-empty descriptions of the items, joined.
template <class Items, class Say>
std::string listed(const Items& items, const Say& describe, const char* between = ", ") {
  std::string list;
  for (const auto& item : items)
    if (const std::string words = describe(item); !words.empty()) append(list, words, between);
  return list;
}

struct Findings {
  Json rows = Json::array();  // flat objects, for NAME.csv and "rows" of NAME.json
  std::vector<Section> sections;
};

struct Study {
  std::string name;
  std::string what;               // one sentence about its subject
  Findings (*run)(Cells& cells);  // null: NAME.py measures and writes everything
  bool any_backend = false;       // false: runs on the host only
};

/// All studies, in the order in which they run and are shown.
const std::vector<Study>& studies();

}  // namespace malha::study
