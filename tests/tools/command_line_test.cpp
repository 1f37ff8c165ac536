// SPDX-License-Identifier: Apache-2.0
// The command line of malha: help that suffices, and a message of one line for every error.
#include "host/base/build_info.h"
#include "tests/run_scenes.h"
#include "tests/support.h"

namespace malha {
namespace {

TEST(CommandLine, HelpsWithEveryOptionAndExample) {
  const TemporaryFolder folder;
  const Ended help = malha_command({"--help"}, folder / "."), run = malha_command({"run", "--help"}, folder / ".");
  const Ended bench = malha_command({"bench", "--help"}, folder / "."),
              projection = malha_command({"bench", "projection", "--help"}, folder / "."),
              filter = malha_command({"bench", "filter", "--help"}, folder / ".");
  EXPECT_EQ(help.status + run.status + bench.status + projection.status + filter.status, 0);
  for (const char* word : {"malha [OPTIONS] COMMAND", "run ", "picture ", "plan ", "check ", "tune ", "bench ",
                           "study ", "Examples:", "Exit status:", "130"})
    EXPECT_TRUE(has(help.out, word)) << word;
  for (const char* word : {"malha run [OPTIONS] SCENE", "--threads N", "--steps N", "--seconds S", "--out FOLDER",
                           "--every N", "--format LIST", "--checkpoint N", "--picture ", "--picture-every N",
                           "--no-picture", "--quiet", "--resume", "--backend NAME", "Examples:", "Ctrl-C"})
    EXPECT_TRUE(has(run.out, word)) << word;
  EXPECT_TRUE(has(bench.out, "projection ")) << bench.out;
  EXPECT_TRUE(has(bench.out, "filter ")) << bench.out;
  for (const char* word : {"malha bench projection [OPTIONS]", "--n LIST", "--threads LIST", "--case NAME",
                           "--repeats N", "--seconds S", "--json FILE", "--out FOLDER", "Examples:"})
    EXPECT_TRUE(has(projection.out, word)) << word;
  for (const char* word : {"malha bench filter [OPTIONS]", "--n LIST", "--threads LIST", "--kernel LIST", "--repeats N",
                           "--seconds S", "--json FILE", "--out FOLDER", "Examples:"})
    EXPECT_TRUE(has(filter.out, word)) << word;
  EXPECT_EQ(malha_command({"--version"}, folder / ".").out, std::string("malha ") + version() + "\n");
}

TEST(CommandLine, SaysHowToBuildWhatMeasuresItWhereThatIsNotBuilt) {
  const TemporaryFolder folder;
  const std::string alone = folder / "malha";
  std::filesystem::copy_file(MALHA_COMMAND, alone);
  for (const std::string word : {"tune", "bench", "study"}) {
    const std::string said =
        "malha " + word + ": tune, bench and study are not built yet; to build: tools/build, and install again\n";
    const Ended asked = MalhaProcess({word, "--help"}, folder / ".", RLIM_INFINITY, alone).wait();
    EXPECT_EQ(asked.status, 0);
    EXPECT_EQ(asked.out, said);
    const Ended ended = MalhaProcess({word}, folder / ".", RLIM_INFINITY, alone).wait();
    EXPECT_EQ(ended.status, 4);
    EXPECT_EQ(ended.err, said);
    EXPECT_EQ(malha_command({word, "--help"}, folder / ".").status, 0);
  }
  folder.write("CMakeCache.txt", "");
  EXPECT_TRUE(has(MalhaProcess({"bench"}, folder / ".", RLIM_INFINITY, alone).wait().err,
                  "to build: cmake --build '" + (folder / "").parent_path().string() + "' --target malha_measures\n"));
}

struct Slip {
  std::vector<std::string> words;
  std::string answer;
};

TEST(CommandLine, AnswersEverySlipInOneLine) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  const std::string in_run = "; see malha run --help\n";
  for (const Slip& slip : std::vector<Slip>{
           {{},
            "malha: found no command; allowed: run, view, picture, page, plan, check, materials, tune, bench, study, "
            "--help, "
            "-h, --version\n"},
           {{"rum", "scene.json"},
            "malha: found \"rum\" (did you mean 'run'?); allowed: run, view, picture, page, plan, check, materials, "
            "tune, "
            "bench, study, "
            "--help, "
            "-h, --version\n"},
           {{"run"}, "malha run: SCENE is required" + in_run},
           {{"run", "scene.json", "--thread", "2"},
            "malha run: found \"--thread\" (did you mean '--threads'?); allowed: one scene and the options of malha "
            "run" +
                in_run},
           {{"run", "scene.json", "another.json"},
            "malha run: found \"another.json\"; allowed: one scene and the options of malha run" + in_run},
           {{"check", "scene.json", "--steps", "3"},
            "malha check: found \"--steps\"; allowed: one scene and the options of malha check; see malha check "
            "--help\n"},
           {{"run", "scene.json", "--threads", "0"},
            "malha run: --threads: found \"0\"; allowed: a whole number from 1 to 1024" + in_run},
           {{"run", "scene.json", "--steps", "ten"},
            "malha run: --steps: found \"ten\"; allowed: a whole number from 1 to 1000000000" + in_run},
           {{"run", "scene.json", "--seconds", "-1"},
            "malha run: --seconds: found \"-1\"; allowed: a number > 0 (s)" + in_run},
           {{"run", "scene.json", "--seconds", "1e300"},
            "malha run: --seconds: found 1e+300; allowed: at most 2e+07 s, which are 1e9 steps of this scene\n"},
           {{"run", "scene.json", "--seconds", "1", "--steps", "1"}, "malha run: --steps excludes --seconds" + in_run},
           {{"run", "scene.json", "--picture", "--no-picture"}, "malha run: --picture excludes --no-picture" + in_run},
           {{"run", "scene.json", "--format", "vtp,vtk"},
            "malha run: --format: found \"vtk\" (did you mean 'vtp'?); allowed: vtp, pc2, ply, obj, glb, usda" +
                in_run},
           {{"run", "scene.json", "--backend", "metal"},
            "malha run: --backend: found \"metal\"; allowed: openmp, serial, cuda" + in_run},
           {{"run", "scene.json", "--steps", "1", "--steps", "2"},
            "malha run: --steps: found 2 times; allowed: once" + in_run},
           {{"plan", "scene.json", "--fps"},
            "malha plan: found \"--fps\"; allowed: one scene and the options of malha plan; see malha plan --help\n"},
           {{"run", "scene.json", "--fps", "30"},
            "malha run: found \"--fps\" (did you mean '--every'? A frame every N steps); allowed: one scene and the "
            "options of malha run" +
                in_run},
           {{"picture"}, "malha picture: OUT is required; see malha picture --help\n"},
           {{"picture", "nowhere"},
            "nowhere/report.json: cannot read: No such file or directory; allowed: a folder of results of malha run\n"},
           {{"run", "scene.json", "--out"}, "malha run: --out: 1 required FOLDER missing" + in_run}}) {
    const Ended ended = malha_command(slip.words, folder / ".");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, slip.answer);
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_EQ(files_in(folder / ".").size(), 1u);
}

TEST(CommandLine, SaysHowASceneIsMadeOfAMesh) {
  const TemporaryFolder folder;
  folder.write("body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Ended refused = malha_command({"run", "body.obj"}, folder / ".");
  EXPECT_EQ(refused.status, 2);
  EXPECT_TRUE(refused.err.starts_with("body.obj: found a mesh; allowed: a scene")) << refused.err;
  // The JSON in the message is a valid scene.
  const std::size_t from = refused.err.find('{'), to = refused.err.rfind('}');
  folder.write("made.json", refused.err.substr(from, to + 1 - from));
  EXPECT_EQ(malha_command({"check", "made.json"}, folder / ".").status, 0);
}

TEST(CommandLine, PrintsEveryFaultOfASceneOnALine) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["mass"] = 0, scene["solver"]["dt"] = 0;
  folder.write("scene.json", scene.dump());
  const Ended refused = malha_command({"run", "scene.json"}, folder / ".");
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 2) << refused.err;
}

// An empty path is a variable that was never set; where it would mean the default folder, that would be replaced.
TEST(CommandLine, RefusesAnEmptyPath) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  for (std::vector<std::string> words :
       std::vector<std::vector<std::string>>{{"run", "scene.json", "--out"},
                                             {"bench", "projection", "--out"},
                                             {"bench", "filter", "--json"},
                                             {"bench", "constraints", "--out"},
                                             {"bench", "self", "--out"},
                                             {"study", "accuracy", "--quick", "--out"},
                                             {"tune", "scene.json", "--error", "1", "--out"},
                                             {"tune", "scene.json", "--error", "1", "--json"}}) {
    const std::string option = words.back(), command = words[0] + (words[0] == "bench" ? " " + words[1] : "");
    words.emplace_back("");
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.err, "malha " + command + ": " + option + ": found \"\"; allowed: a path, not empty; see malha " +
                             command + " --help\n");
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_EQ(files_in(folder / ".").size(), 1u);
}

}  // namespace
}  // namespace malha
