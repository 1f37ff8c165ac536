// SPDX-License-Identifier: Apache-2.0
// Shares of a study: several processes, on one machine or several, each measure a part of its cells, and one merges
// them.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/bench/runs_on.h"

namespace malha::study {

using Json = nlohmann::ordered_json;

/// Share i of n: of the cells and groups of cells that a study requests in order, those numbered i, i + n, ...
struct Share {
  int i = 1, n = 1;
  std::string text() const { return std::to_string(i) + "/" + std::to_string(n); }
};

constexpr int kMostShares = 100'000;

/// Parses a share such as "2/3"; empty for other text.
std::optional<Share> share_of(const std::string& text);

/// The file name of a study's journal: NAME.cells.jsonl, NAME.quick.cells.jsonl, and NAME.2of3.cells.jsonl for a share.
std::string journal_name(const std::string& study, bool quick, const std::optional<Share>& share);

/// The first line of a journal: everything that must agree for its cells to be comparable with those of another.
Json journal_head(const std::string& study, bool quick, const Json& build, const Json& program,
                  const std::optional<Share>& share, const bench::RunsOn& on = {});

/// The cells of all shares.
struct Merged {
  int shares = 1;                     // n
  std::set<int> given;                // shares that have a journal
  std::map<std::string, Json> cells;  // by key; objects name their "machine" if there are several
  std::vector<Json> builds;           // build_facts() and "program" of each machine
  std::vector<std::string> found_in;  // the first journal of each machine

  /// Number of cores of the machines; refuses machines with different numbers.
  int cores() const;
};

/// Reads the journals of a study's shares in these folders. `expected`: journal_head() of this program. Throws
/// InputError for a folder without a journal or named twice, a torn line, another study, version or (unless `keep`)
/// program, and a cell that differs between two journals.
Merged merged_shares(const std::vector<std::filesystem::path>& folders, const Json& expected, bool keep);

/// The program and machine that measured cells, for charts and rows: malha, compiler, optimisation and machine; and the
/// machine alone.
std::string maker(const Json& build);
std::string machine(const Json& build);

}  // namespace malha::study
