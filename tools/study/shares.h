// SPDX-License-Identifier: Apache-2.0
// A study in shares: several processes, here or elsewhere, measure a part of its cells each, and one puts them
// together.
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

/// Number i of n: of what a study asks for, one after the other, what comes at the places i, i + n, ...
struct Share {
  int i = 1, n = 1;
  std::string text() const { return std::to_string(i) + "/" + std::to_string(n); }
};

constexpr int kMostShares = 100'000;

/// The share of "2/3"; none of other texts.
std::optional<Share> share_of(const std::string& text);

/// The file of a study's cells: NAME.cells.jsonl, NAME.quick.cells.jsonl, and of a share NAME.2of3.cells.jsonl.
std::string journal_name(const std::string& study, bool quick, const std::optional<Share>& share);

/// The first line of that file: what makes its cells comparable with those of another.
Json journal_head(const std::string& study, bool quick, const Json& build, const Json& program,
                  const std::optional<Share>& share, const bench::RunsOn& on = {});

/// The cells of all shares.
struct Merged {
  int shares = 1;                     // n
  std::set<int> given;                // those that have a journal
  std::map<std::string, Json> cells;  // objects name their "machine" where there are several
  std::vector<Json> builds;           // of each machine its build_facts() and "program"
  std::vector<std::string> found_in;  // and the first of its journals

  /// Of the machines; refuses those that have not as many as each other.
  int cores() const;
};

/// Reads the journals of a study's shares in these folders. `own` is what journal_head() says of this program. Throws
/// InputError: a folder without one or named twice, a torn line, another study, version or (unless `keep`) program, a
/// cell that is not the same in two of them.
Merged merged_shares(const std::vector<std::filesystem::path>& folders, const Json& own, bool keep);

/// What made cells, as charts and rows say it: malha, compiler and optimisation, machine; and of it the machine.
std::string maker(const Json& build);
std::string machine(const Json& build);

}  // namespace malha::study
