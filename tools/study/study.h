// SPDX-License-Identifier: Apache-2.0
// Studies: what malha's methods do, measured and charted. One study is a function that makes cells and says what they
// show; the registry lists all.
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
  std::string settings;  // gnuplot's lines before the plot
  std::vector<bench::Series> series = {};
};

struct Table {
  std::vector<std::string> columns = {};
  std::vector<std::vector<std::string>> rows = {};
};

/// Two scenes to be played beside each other, as long as their durations; their names are those of the sides.
struct Replay {
  std::string name;  // the file is STUDY_NAME.html
  std::string description;
  Scene left, right;
};

/// A part of the page: what was looked at, what the rows say about it, the picture and the numbers.
struct Section {
  std::string title;
  std::vector<std::string> sentences = {};  // computed from the rows, never written by hand
  std::optional<Chart> chart = {};
  Table table = {};
  std::vector<Replay> replays = {};
};

/// Adds to a list in words: "a, b".
inline void append(std::string& list, const std::string& words, const char* between = ", ") {
  list += (list.empty() ? "" : between) + words;
}

/// What `say` says of each, if anything.
template <class Items, class Say>
std::string listed(const Items& items, const Say& describe, const char* between = ", ") {
  std::string list;
  for (const auto& item : items)
    if (const std::string words = describe(item); !words.empty()) append(list, words, between);
  return list;
}

struct Findings {
  Json rows = Json::array();  // of flat objects: NAME.csv and "rows" of NAME.json
  std::vector<Section> sections;
};

struct Study {
  std::string name;
  std::string what;  // one sentence: what it shows
  Findings (*run)(Cells& cells);
  bool any_backend = false;  // on any backend: others are of the host's alone
};

/// All, in the order in which they run and are shown.
const std::vector<Study>& studies();

}  // namespace malha::study
