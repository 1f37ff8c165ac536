// SPDX-License-Identifier: Apache-2.0
// Shares of studies: every cell is in one of them, and merged they equal the results of one process. Times are never
// asserted.
#include "malha/error.h"
#include "tests/refusal.h"
#include "tests/support.h"
#include "tools/study/results.h"

namespace malha::study {
namespace {

const std::atomic<bool> kNeverStopped{false};

/// A study of five squares, and of a cell that needs another one.
Findings squares(Cells& cells) {
  Findings findings;
  const std::vector<int> numbers{1, 2, 3, 4, 5};
  const std::vector<Json> kept = cells.measure_all(
      numbers, [](int x) { return "square " + std::to_string(x); },
      [](int x) -> Json {
        return {{"y", x * x}};
      });
  cells.measure_together([&] {
    const Json truth = cells("truth", []() -> Json { return {{"y", 1.0 / 3}}; });
    findings.rows.push_back(cells("error", [&]() -> Json { return {{"y", truth["y"].get<double>() - 0.3}}; }));
  });
  if (cells.is_partial()) return findings;
  for (const Json& cell : kept)
    findings.rows.push_back({{"square", cell["y"]}, {"machine", cell.value("machine", "")}});
  return findings;
}

const std::vector<std::string> kSquares{"square 1", "square 2", "square 3", "square 4", "square 5", "truth", "error"};

Json build_of(const std::string& cpu, int cores = 2) {
  return {{"malha_version", "1"}, {"compiler", "c"}, {"flags", "-O3"},
          {"instructions", "i"},  {"cpu", cpu},      {"cores", cores}};
}

Json head_of_share(const std::optional<Share>& share, const Json& build = build_of("one"),
                   const std::string& program = "p") {
  return journal_head("squares", false, build, program, share);
}

class StudyShares : public testing::Test {
 protected:
  std::filesystem::path folder(const std::string& name) const {
    make(folder_ / name);
    return folder_ / name;
  }
  static void make(const std::filesystem::path& path) { std::filesystem::create_directories(path); }

  std::filesystem::path journal(const Share& share, const std::string& in) const {
    return folder(in) / journal_name("squares", false, share);
  }
  /// Measures a share and returns the keys of the cells in its journal.
  std::vector<std::string> measured(const Share& share, const std::string& in, const Json& head) const {
    {
      Cells cells(journal(share, in), head, false, kNeverStopped, {}, share);
      squares(cells);
      EXPECT_TRUE(cells.is_partial());
    }
    std::vector<std::string> keys;
    std::istringstream lines(bytes_of(journal(share, in)));
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);) keys.push_back(Json::parse(line)["key"]);
    return keys;
  }
  std::vector<std::string> measured(const Share& share, const std::string& in) const {
    return measured(share, in, head_of_share(share));
  }
  Merged merged(const std::vector<std::string>& names, bool keep = false, const std::string& program = "p") const {
    std::vector<std::filesystem::path> folders;
    for (const std::string& name : names) folders.push_back(folder_ / name);
    return merged_shares(folders, head_of_share({}, build_of("one"), program), keep);
  }
  std::string refused(const std::vector<std::string>& names, bool keep = false) const {
    std::string words = refusal([&] { merged(names, keep); });
    const std::string root = (folder_ / "").string();
    for (std::size_t at = 0; (at = words.find(root)) != std::string::npos;) words.erase(at, root.size());
    return words;
  }
  void append(const Share& share, const std::string& in, const std::string& bytes) const {
    std::ofstream(journal(share, in), std::ios::app) << bytes;
  }
  TemporaryFolder folder_;
};

TEST_F(StudyShares, HaveEveryCellInOneOfThem) {
  for (const int n : {1, 2, 3, 6, 9}) {
    std::vector<std::string> all;
    for (int i = 1; i <= n; ++i)
      for (const std::string& key : measured({i, n}, "of" + std::to_string(n))) all.push_back(key);
    std::sort(all.begin(), all.end());
    std::vector<std::string> wanted = kSquares;
    std::sort(wanted.begin(), wanted.end());
    EXPECT_EQ(all, wanted) << n;
  }
  EXPECT_EQ(measured({2, 3}, "a"), (std::vector<std::string>{"square 2", "square 5"}));
  EXPECT_EQ(measured({3, 3}, "a"), (std::vector<std::string>{"square 3", "truth", "error"}))
      << "\"error\" needs \"truth\"";
}

TEST_F(StudyShares, MergedEqualTheResultsOfOneProcess) {
  for (const int i : {1, 2, 3}) measured({i, 3}, std::to_string(i));
  Cells alone(folder_ / "alone", {}, false, kNeverStopped), shares(merged({"3", "1", "2"}), false, kNeverStopped);
  EXPECT_EQ(squares(shares).rows, squares(alone).rows);
  EXPECT_TRUE(shares.missing().empty());
  EXPECT_FALSE(shares.is_partial());
}

TEST_F(StudyShares, ListMissingCells) {
  measured({1, 3}, "a");
  Cells cells(merged({"a"}), false, kNeverStopped);
  squares(cells);
  EXPECT_TRUE(cells.is_partial());
  EXPECT_EQ(cells.missing(),
            (std::map<int, std::vector<std::string>>{{2, {"square 2", "square 5"}}, {3, {"square 3", "truth"}}}))
      << "cells that need \"truth\" are not requested without it";
}

TEST_F(StudyShares, OfSeveralMachinesNameTheMachineInTheRows) {
  measured({1, 2}, "a", head_of_share(Share{1, 2}, build_of("one")));
  measured({2, 2}, "a", head_of_share(Share{2, 2}, build_of("other", 8)));
  const Merged both = merged({"a"});
  Cells cells(both, false, kNeverStopped);
  const Json rows = squares(cells).rows;
  EXPECT_EQ(rows[1]["machine"], "malha 1, c -O3, i; one, 2 cores; program p");
  EXPECT_EQ(rows[2]["machine"], "malha 1, c -O3, i; other, 8 cores; program p");
  const Json json = to_json({"squares", "w", squares}, {}, false, "malha study squares", both.builds);
  EXPECT_EQ(caption(json),
            "malha 1; 2 builds or machines, which the rows name; one, 2 cores; other, 8 cores; malha study squares");
  EXPECT_EQ(json["machines"].size(), 2u);
  EXPECT_TRUE(has(refusal([&] { cells.cores(); }), "2of2.cells.jsonl: line 1: found 8 cores; allowed: 2, as in "));
}

TEST_F(StudyShares, RefuseATornLine) {
  measured({1, 2}, "a"), measured({2, 2}, "a");
  append({2, 2}, "a", "{\"key\":\"square 9\",\"val");
  EXPECT_EQ(refused({"a"}),
            "a/squares.2of2.cells.jsonl: line 6: found a torn line; allowed: complete lines of JSON; its command "
            "resumes the share there, or starts anew without this file");
  EXPECT_EQ(measured({2, 2}, "a").size(), 4u) << "the share was resumed";
  EXPECT_EQ(refused({"a"}), "");
  append({2, 2}, "a", "{\"key\":\"square 9\"}\n");
  EXPECT_TRUE(has(refused({"a"}), "line 6: found no cell; allowed: ")) << refused({"a"});
}

TEST_F(StudyShares, RefuseContradictingCells) {
  measured({1, 2}, "a"), measured({2, 2}, "b");
  append({2, 2}, "b", "{\"key\":\"square 1\",\"value\":{\"y\":1}}\n");
  EXPECT_EQ(refused({"a", "b"}), "") << "the same result is no contradiction";
  append({2, 2}, "b", "{\"key\":\"square 3\",\"value\":{\"y\":8}}\n");
  EXPECT_EQ(refused({"a", "b"}),
            "b/squares.2of2.cells.jsonl: line 7: found \"square 3\", measured again with another result than in "
            "a/squares.1of2.cells.jsonl, line 3; allowed: one journal of each share");
}

TEST_F(StudyShares, RefuseOtherVersionsProgramsAndNumbersOfShares) {
  measured({1, 2}, "a");
  Json version = build_of("one");
  version["malha_version"] = "2";
  measured({2, 2}, "version", head_of_share(Share{2, 2}, version));
  EXPECT_TRUE(has(refused({"a", "version"}), "line 1: found malha \"2\"; allowed: \"1\", as this program"));
  measured({2, 2}, "program", head_of_share(Share{2, 2}, build_of("one"), "q"));
  EXPECT_TRUE(has(refused({"a", "program"}), "line 1: found program \"q\"; allowed: \"p\", this one; or --keep"));
  EXPECT_EQ(refused({"a", "program"}, true), "") << "--keep";
  measured({2, 3}, "three");
  EXPECT_TRUE(has(refused({"a", "three"}), "line 1: found share 2/3; allowed: shares of 2, as in a/squares.1of2"));
  folder("quick");
  std::filesystem::copy(journal({1, 2}, "a"), journal({1, 2}, "quick"));
  const Json quick = journal_head("squares", true, build_of("one"), "p", Share{1, 2});
  std::ofstream(journal({1, 2}, "quick")) << quick.dump() << "\n";
  EXPECT_TRUE(has(refused({"quick"}), "line 1: found quick true; allowed: false")) << refused({"quick"});
  std::ofstream(journal({1, 2}, "quick")) << "";
  EXPECT_TRUE(has(refused({"quick"}), "found nothing; allowed: the head of a share's journal"));
}

TEST_F(StudyShares, RefuseFoldersWithoutAJournalAndTwice) {
  measured({1, 1}, "a");
  folder("empty");
  EXPECT_EQ(refused({"empty"}),
            "empty: found no journal of a share of squares; allowed: a folder in which malha study squares --share "
            "leaves its squares.1of2.cells.jsonl");
  EXPECT_TRUE(has(refused({"none"}), "none: found No such file or directory; allowed: a folder"));
  EXPECT_TRUE(has(refused({"a", "empty/../a"}), "--merge: found 'empty/../a' twice; allowed: each folder once"));
}

TEST(StudyShare, IsParsedFromText) {
  EXPECT_EQ(share_of("2/3")->text(), "2/3");
  for (const char* text :
       {"0/3", "4/3", "1/0", "a/b", "1", "1/", "/3", "1/3x", " 1/3", "1/3/4", "-1/3", "1/100001", ""})
    EXPECT_FALSE(share_of(text)) << text;
}

TEST(StudyShare, OfEveryStudyLeavesOutCellsOfOtherShares) {
  for (const Study& study : studies()) {
    if (!study.run) continue;  // a script
    const TemporaryFolder folder;
    Cells none(folder / "cells", {}, true, kNeverStopped, {}, Share{kMostShares, kMostShares});
    study.run(none);
    EXPECT_EQ(none.made(), 0) << study.name;
    Merged nothing;
    nothing.builds = {build_of("one")};
    Cells merged(nothing, true, kNeverStopped);
    study.run(merged);
    EXPECT_EQ(merged.missing().size(), 1u) << study.name;
  }
}

class StudyShareCommand : public testing::Test {
 protected:
  Ended study(const std::vector<std::string>& words) const {
    std::vector<std::string> all{"study", "published", "--quick"};
    all.insert(all.end(), words.begin(), words.end());
    return malha_command(all, folder_ / ".");
  }
  /// The rows without times.
  Json rows(const std::string& of) const {
    const Json json = Json::parse(bytes_of(folder_ / (of + "/published.json")));
    Json all = Json::array();
    for (const Json& row : json["rows"])
      if (!row.contains("frames_per_s")) all.push_back(row);
    return all;
  }
  TemporaryFolder folder_;
};

TEST_F(StudyShareCommand, OfThreeMergesIntoTheResultsOfOneProcess) {
  for (const std::string i : {"1", "2"}) {
    const Ended ended = study({"--share", i + "/3", "--out", i});
    EXPECT_EQ(ended.status, 0) << ended.err;
    EXPECT_TRUE(has(ended.out, "share       " + i + "/3 of published: "));
    EXPECT_EQ(files_in(folder_ / i).size(), 1u) << "only the journal";
  }
  const Ended lacking = study({"--merge", "1", "2", "--out", "all"});
  EXPECT_EQ(lacking.status, 1);
  EXPECT_TRUE(has(lacking.err, "share 3/3, which has no journal, lacks ")) << lacking.err;
  EXPECT_TRUE(has(lacking.err, "to measure: malha study published --quick --share 3/3\n")) << lacking.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "all"));
  EXPECT_EQ(study({"--share", "3/3", "--out", "3"}).status, 0);
  const Ended merged = study({"--merge", "1", "2", "3", "--out", "all"});
  EXPECT_EQ(merged.status, 0) << merged.err;
  EXPECT_EQ(study({"--out", "one"}).status, 0);
  EXPECT_EQ(rows("all").dump(1), rows("one").dump(1));
  EXPECT_GT(rows("all").size(), 20u);
}

TEST_F(StudyShareCommand, IsRefusedInOneLine) {
  for (const char* share : {"0/3", "4/3", "1/0", "a/b"}) {
    const Ended ended = study({"--share", share});
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, "malha study: --share: found \"" + std::string(share) +
                             "\"; allowed: I/N, such as 2/3, with 1 <= I <= N <= 100000; see malha study --help\n");
  }
  const Ended both = study({"--share", "1/3", "--merge", "a"});
  EXPECT_EQ(both.status, 2);
  EXPECT_EQ(both.err, "malha study: --merge: found --share beside it; allowed: one of them; see malha study --help\n");
  const Ended none = study({"--merge", "a"});
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(has(none.err, "a: found No such file or directory; allowed: ")) << none.err;
  EXPECT_TRUE(files_in(folder_ / ".").empty());
}

}  // namespace
}  // namespace malha::study
