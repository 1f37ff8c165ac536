// SPDX-License-Identifier: Apache-2.0
// Framework of malha study: journals of cells, tables, the page, and the command. Times are never asserted.
#include <csignal>

#include "tests/support.h"
#include "tools/study/page.h"
#include "tools/study/results.h"

namespace malha::study {
namespace {

const std::atomic<bool> kNoStop{false};

class StudyCells : public testing::Test {
 protected:
  /// Requests these cells and returns those that were measured.
  std::vector<std::string> made(const std::vector<std::string>& keys, const Json& head = {{"program", "a"}}) const {
    Cells cells(folder_ / "cells.jsonl", head, true, kNoStop);
    std::vector<std::string> anew;
    for (const std::string& key : keys) {
      const Json value = cells(key, [&] { return anew.push_back(key), Json{{"of", key}}; });
      EXPECT_EQ(value["of"], key);
    }
    return anew;
  }
  using Keys = std::vector<std::string>;
  TemporaryFolder folder_;
};

TEST_F(StudyCells, AreMeasuredOnceAndStored) {
  EXPECT_EQ(made({"a", "b", "a"}), (Keys{"a", "b"}));
  EXPECT_EQ(made({"a", "b", "c"}), Keys{"c"});
  EXPECT_EQ(made({"c", "b", "a"}), Keys{});
}

TEST_F(StudyCells, OfAnotherBuildMachineOrVersionAreMeasuredAgain) {
  EXPECT_EQ(made({"a"}), Keys{"a"});
  EXPECT_EQ(made({"a"}, {{"program", "b"}}), Keys{"a"});
  EXPECT_EQ(made({"a"}, {{"program", "b"}}), Keys{});
}

TEST_F(StudyCells, SurviveACrashInTheMiddleOfALine) {
  made({"a", "b"});
  const std::string bytes = bytes_of(folder_ / "cells.jsonl");
  for (std::size_t cut = 1; cut < bytes.size(); cut += 3) {
    folder_.write("cells.jsonl", bytes.substr(0, bytes.size() - cut));
    made({"a", "b"});
    EXPECT_EQ(bytes_of(folder_ / "cells.jsonl"), bytes) << "cut by " << cut;
  }
}

TEST_F(StudyCells, DoNotOverwriteAFileThatIsNoJournal) {
  folder_.write("cells.jsonl", "not a journal\n{\"key\":\"a\",\"value\":1}\n");
  EXPECT_EQ(made({"a"}), Keys{"a"});
  EXPECT_EQ(bytes_of(folder_ / "cells.jsonl.old"), "not a journal\n{\"key\":\"a\",\"value\":1}\n")
      << "it may be hours of work";
}

TEST_F(StudyCells, AreUsedByOneProcessAtATime) {
  const Cells one(folder_ / "cells.jsonl", {}, true, kNoStop);
  EXPECT_THROW(Cells(folder_ / "cells.jsonl", {}, true, kNoStop), std::runtime_error);
}

TEST_F(StudyCells, StopBetweenCellsAndWithinThem) {
  std::atomic<bool> stop{false};
  Cells cells(folder_ / "cells.jsonl", {}, true, stop);
  cells("a", [] { return Json(1); });
  EXPECT_THROW(cells("b", [&]() -> Json { return stop = true, cells.check_interrupt(), Json(2); }), Interrupted);
  EXPECT_EQ(cells("a", []() -> Json { throw Interrupted(); }), Json(1)) << "a stored cell is not measured";
  EXPECT_THROW(cells("c", [] { return Json(3); }), Interrupted);
}

TEST_F(StudyCells, AreReadAsTheyWereWritten) {
  const Json value{{"tiny", 1.0 / 3}, {"lost", std::nan("")}};
  Json first, second;
  for (Json* back : {&first, &second}) {
    Cells cells(folder_ / "cells.jsonl", {}, true, kNoStop);
    *back = cells("a", [&] { return value; });
  }
  EXPECT_EQ(first, second);
  EXPECT_EQ(first["tiny"], 1.0 / 3) << "to the last digit";
  EXPECT_TRUE(first["lost"].is_null()) << "JSON has no NaN";
}

TEST(StudyResults, CsvHasAColumnPerKeyAndQuotesText) {
  const Json rows = Json::parse(R"([{"a": 1, "b": "x, \"y\""}, {"a": null, "c": 0.5}])");
  EXPECT_EQ(csv(rows), "a,b,c\n1,\"x, \"\"y\"\"\",\n,,0.5\n");
}

TEST(StudyPage, EmbedsAChartWithUniqueIds) {
  EXPECT_EQ(
      inline_svg("<?xml?>\n<svg width=\"9\" height='5' viewBox=\"0 0 9 5\"><g id='m'/><use xlink:href='#m'/></svg>",
                 "n"),
      "<svg height='5' viewBox=\"0 0 9 5\"><g id='n_m'/><use xlink:href='#n_m'/></svg>");
}

class StudyCommand : public testing::Test {
 protected:
  Ended study(const std::vector<std::string>& words) const {
    std::vector<std::string> all{"study"};
    all.insert(all.end(), words.begin(), words.end());
    return malha_command(all, folder_ / ".");
  }
  TemporaryFolder folder_;
};

TEST_F(StudyCommand, HasHelpForEveryStudyAndOption) {
  for (const auto& words : {std::vector<std::string>{"--help"}, {"accuracy", "--help"}}) {
    const Ended help = study(words);
    EXPECT_EQ(help.status, 0);
    for (const Study& each : studies()) EXPECT_TRUE(has(help.out, "  " + each.name + " ")) << each.name;
    for (const char* word :
         {"--quick", "--out FOLDER", "--keep", "--share I/N", "--merge DIR...", "index.html", "Ctrl-C", "Examples:"})
      EXPECT_TRUE(has(help.out, word)) << word;
  }
}

TEST_F(StudyCommand, RefusesInvalidOptionsInOneLine) {
  const std::string all = [] {
    std::string names;
    for (const Study& each : studies()) names += each.name + ", ";
    return names + "all, --help, -h\n";
  }();
  for (const auto& [words, answer] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{}, "malha study: found no study; allowed: " + all},
           {{"acuracy"}, "malha study: found \"acuracy\" (did you mean 'accuracy'?); allowed: " + all},
           {{"accuracy", "--quik"},
            "malha study: found \"--quik\" (did you mean '--quick'?); allowed: the options of malha study; see malha "
            "study --help\n"}}) {
    const Ended ended = study(words);
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, answer);
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_TRUE(files_in(folder_ / ".").empty());
}

}  // namespace
}  // namespace malha::study
