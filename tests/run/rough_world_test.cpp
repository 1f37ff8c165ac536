// SPDX-License-Identifier: Apache-2.0
// The command under adverse conditions: closed pipes, control bytes that must not reach a terminal, too little memory.
#include <sys/resource.h>

#include <atomic>
#include <fstream>
#include <new>

#include "host/base/memory_size.h"
#include "host/base/parallel_tasks.h"
#include "host/model/model.h"
#include "malha/text.h"
#include "tests/refusal.h"
#include "tests/run_scenes.h"
#include "tests/scene_builders.h"
#include "tests/support.h"

namespace malha {
namespace {

/// The exit status of a shell that runs a line in this folder, where $malha is the command.
int in_shell(const std::string& line, const TemporaryFolder& folder) {
  const std::string all = "cd '" + (folder / ".").string() + "' && malha='" + MALHA_COMMAND + "' && " + line;
  const int state = std::system(("bash -c '" +
                                 [&] {
                                   std::string quoted_line;
                                   for (const char letter : all)
                                     quoted_line += letter == '\'' ? "'\\''" : std::string(1, letter);
                                   return quoted_line;
                                 }() +
                                 "'")
                                    .c_str());
  return WIFEXITED(state) ? WEXITSTATUS(state) : -WTERMSIG(state);
}

TEST(AClosedPipe, DoesNotEndTheRun) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  // true closes the pipe at once; the run writes to it once it is certainly closed.
  for (const char* line : {"{ sleep 0.2; $malha run scene.json --threads 1 2>/dev/null; echo $? >status; } | true",
                           "{ sleep 0.2; $malha run scene.json --threads 1 2>&1 >/dev/null; echo $? >status; } | true",
                           "$malha run scene.json --threads 1 >&- 2>&-; echo $? >status"}) {
    in_shell(line, folder);
    EXPECT_EQ(bytes_of(folder / "status"), "0\n") << line;
    EXPECT_TRUE(std::filesystem::exists(folder / "out/scene/report.json")) << line;
    std::filesystem::remove_all(folder / "out");
  }
}

TEST(AFullDisk, IsStillAnErrorOfStandardOutput) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  for (const char* words : {"check scene.json", "plan scene.json", "run scene.json --steps 1", "--version", "--help",
                            "run --help", "view --help", "bench --help"})
    EXPECT_EQ(in_shell("$malha " + std::string(words) + " >/dev/full 2>said", folder), 4) << words;
  EXPECT_EQ(bytes_of(folder / "said"), "malha: cannot write to standard output\n");
}

TEST(APathWithoutEnd, IsRefusedBeforeMemoryEnds) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"] = {{"mesh", "a.obj"}};
  scene["bodies"][0]["constraints"][0]["elements"] = {"edges"};
  folder.write("scene.json", scene.dump());
  std::filesystem::create_symlink("/dev/zero", folder / "a.obj");
  for (const char* line :
       {"$malha check scene.json 2>said", "$malha check /dev/zero 2>said", "yes | $malha check - 2>said"}) {
    EXPECT_EQ(in_shell(line, folder), 2) << line;
    EXPECT_TRUE(has(bytes_of(folder / "said"), "; allowed: a file, or at most so much from a pipe")) << line;
  }
  std::filesystem::remove(folder / "a.obj");
  folder.write("real.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
  EXPECT_EQ(in_shell("mkfifo a.obj && { cat real.obj >a.obj & $malha check scene.json >said; }", folder), 0);
  EXPECT_EQ(bytes_of(folder / "said"), "scene.json: ok: 4 particles in 1 body\n") << "a pipe that ends is read";
}

bool is_clean(const std::string& text) {
  const std::string lines = text.ends_with("\n") ? text.substr(0, text.size() - 1) : text;
  return printable(lines) == lines;
}

TEST(TextForTerminals, HasNoBytesOfFilesThatATerminalWouldObey) {
  EXPECT_EQ(printable("a b\tc\nd\033[31m\x7f"), "a b?c?d?[31m?");
  EXPECT_EQ(printable("Bündel \xe2\x82\xac \xf0\x9f\x98\x80"), "Bündel \xe2\x82\xac \xf0\x9f\x98\x80");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m \xe2\x80\xa8"),
            "?31m ?")
      << "control characters of two and three bytes";
  EXPECT_EQ(printable("a\xe2\x80\xae"
                      "b\xe2\x81\xa6"
                      "c\xef\xbb\xbf"),
            "a?b?c?")
      << "writing that changes its direction";
  EXPECT_EQ(printable("\xff \xc3 \xc0\xaf \xed\xa0\x80 \xe2\x82"), "? ? ?? ??? ??") << "no UTF-8";

  const TemporaryFolder folder;
  const std::string red = "\033[31m", section = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$" + red + "\n";
  folder.write("a.msh", section);
  folder.write("scene\n" + red + ".json", "{");
  folder.write("bad.json", "{\"name\": \"" + red + "\xff\"}");
  folder.write("key.json", "{\"" + red + "\xfe\": 1}");
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"] = {{"mesh", "a.msh"}};
  folder.write("mesh.json", scene.dump());
  folder.write("ok" + red + "\n.json", swinging_sheet(false).dump());
  for (const std::string name :
       {"mesh.json", "bad.json", "key.json", "scene\n\033[31m.json", "none\n\033[31m.json", "ok\033[31m\n.json"})
    for (const char* command : {"check", "run"}) {
      const Ended ended = malha_command({command, name, "--out", "out"}, folder / ".");
      const bool runs = name.starts_with("ok");
      if (command == std::string("check")) {
        const Ended check = malha_command({"check", name}, folder / ".");
        EXPECT_EQ(check.status, runs ? 0 : 2);
        EXPECT_TRUE(is_clean(check.err) && is_clean(check.out)) << name << check.err << check.out;
        continue;
      }
      EXPECT_EQ(ended.status, runs ? 0 : 2) << name;
      EXPECT_EQ(ended.err.find('\033'), std::string::npos) << ended.err;
      EXPECT_TRUE(runs || is_clean(ended.err)) << ended.err;
    }
  // Such bytes may come from names in a scene, messages about a body, and the path of the results.
  scene = swinging_sheet(true);
  scene["name"] = scene["bodies"][0]["name"] = "n\u009b31m";
  scene["bodies"][0]["tear"] = {{"strain", 0.5}};
  scene["bodies"][0]["shape"]["grid"]["cells"] = {9, 9};
  scene["bodies"][0]["transform"]["translate"] = {0, 0.2, 0.3};
  scene["bodies"][0]["transform"]["rotate"] = {{"axis", {1, 0, 0}}, {"degrees", 90}};
  scene["environment"].erase(0), scene["expect"]["max_speed"] = 0;
  scene["expect"]["bodies"] = {{{"name", "n\u009b31m"}, {"bounds", {{"min", {0, 0, 0}}, {"max", {0, 0, 0}}}}}};
  folder.write("named\033.json", scene.dump());
  for (const std::string command : {"check", "plan", "run"}) {
    std::vector<std::string> words{command, "named\033.json"};
    if (command == "run") words.insert(words.end(), {"--out", "there\n\033[31m", "--format", "obj"});
    const Ended ended = malha_command(words, folder / ".");
    EXPECT_EQ(ended.status, command == "run" ? 1 : 0) << ended.err;
    EXPECT_EQ(printable_lines(ended.out), ended.out) << command;
    EXPECT_EQ(printable_lines(ended.err), ended.err) << command;
    EXPECT_EQ(has(ended.out, "there?"), command == "run");
    EXPECT_TRUE(has(ended.out + ended.err, "starts behind") || has(ended.out + ended.err, "start behind")) << command;
  }
  folder.write("long.json", "{\"name\": \"" + std::string(100000, 'a') + "\xff\"}");
  EXPECT_LT(malha_command({"check", "long.json"}, folder / ".").err.size(), 400u);
}

/// Bodies of 20 million particles each, as many as exceed this machine's memory.
Scene too_large() {
  Scene scene = scene_of({});
  const double each = 2e7 * 170;
  for (double sum = 0; sum <= static_cast<double>(available_memory()); sum += each) {
    BodySpec cloud =
        body("lattice" + std::to_string(scene.bodies.size()), LatticeShape{{0, 0, 0}, {1, 1, 1}, {200, 1000, 100}});
    scene.bodies.push_back(cloud);
  }
  return scene;
}

TEST(TooLittleMemory, IsReportedWithFiguresBeforeASceneIsSetUp) {
  const Scene scene = too_large();
  EXPECT_THROW(build_model(scene), OutOfMemory);
  const std::string said = refusal([&] { build_model(scene); });
  EXPECT_TRUE(has(said, "/bodies: found a scene that needs ")) << said;
  EXPECT_TRUE(has(said, " GiB; allowed: one that fits into the free memory, ")) << said;
  const TemporaryFolder folder;
  folder.write("scene.json", to_json(scene));
  for (const char* command : {"run", "plan", "check"}) {
    const Ended ended = malha_command({command, "scene.json"}, folder / ".");
    EXPECT_EQ(ended.status, 5) << ended.err;
    EXPECT_EQ(ended.err.find("scene.json: /bodies: found a scene that needs "), 0u) << ended.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(TooLittleMemory, IsReportedWithFiguresOfFilesThatDoNotFit) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  ASSERT_EQ(malha_command({"run", "scene.json", "--steps", "2"}, folder / ".").status, 0);
  const std::uintmax_t bytes = std::uintmax_t{1} << 42;  // a sparse file
  std::error_code failed;
  for (const char* name : {"out/scene/checkpoint.malha", "big.json"}) {
    std::ofstream(folder / name, std::ios::app) << "";
    std::filesystem::resize_file(folder / name, bytes, failed);
    if (failed || available_memory() > bytes) GTEST_SKIP() << "a file system without such files, or much memory";
  }
  const Ended resumed = malha_command({"run", "scene.json", "--resume"}, folder / ".");
  EXPECT_EQ(resumed.status, 5);
  EXPECT_EQ(resumed.err.find("out/scene/checkpoint.malha: found a file of 4.1e+03 GiB; allowed: what fits into the "),
            0u)
      << resumed.err;
  EXPECT_EQ(malha_command({"check", "big.json"}, folder / ".").status, 5);
}

// With clang the libraries alone use up these addresses, and LLVM's OpenMP aborts where it gets no memory for a thread.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
TEST(TooLittleMemory, IsReportedWhereItRunsOutDuringTheRun) {
  const TemporaryFolder folder;
  std::string points = "OFF\n1000000 0 0\n";
  for (int i = 0; i < 1000000; ++i) points += std::to_string(i) + " 0 0\n";
  folder.write("points.off", points);
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"] = {{"mesh", "points.off"}};
  folder.write("scene.json", scene.dump());
  EXPECT_EQ(in_shell("ulimit -v 90000; $malha check scene.json 2>said", folder), 5) << bytes_of(folder / "said");
  const std::string said = bytes_of(folder / "said");
  EXPECT_TRUE(has(said, "allowed: what fits into ")) << said;
  EXPECT_FALSE(has(said, "bad_alloc")) << said;
}

// The memory also runs out during work on all threads, and while a thread is created.
TEST(TooLittleMemory, IsReportedWhereverInTheSetUpItRunsOut) {
  const TemporaryFolder folder;
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"]["grid"]["cells"] = {150, 150};
  scene["solver"]["levels"] = 3;
  folder.write("scene.json", scene.dump());
  int too_little = 0;
  bool enough = false;
  for (int mib = 24; !enough && mib < 400; mib += mib < 120 ? 2 : 8) {
    const std::string line = "ulimit -v " + std::to_string(1024 * mib) +
                             "; $malha run scene.json --threads 2 --steps 1 --every 0 --quiet 2>said";
    const int status = in_shell(line, folder);
    const std::string said = bytes_of(folder / "said");
    // The message is the system's or that of OpenMP, which ends the process by itself.
    if (has(said, "loading shared libraries") || has(said, "cannot allocate TLS") ||
        has(said, "libgomp: Out of memory"))
      continue;
    enough = status == 0;
    too_little += !enough;
    EXPECT_TRUE(enough || (status == 5 && has(said, "found ") && !has(said, "bad_alloc")))
        << mib << " MiB: " << status << ", " << said;
  }
  EXPECT_TRUE(enough);
  EXPECT_GT(too_little, 0);
}
#endif

TEST(TasksOfThreads, ThrowWhatOneThrewWhenAllAreDone) {
  for (const int threads : {1, 2, 3}) {
    std::atomic<int> done{0};
    const auto work = [&done](int i) {
      ++done;
      if (i % 2 == 1) throw std::bad_alloc();
    };
    EXPECT_THROW(parallel_tasks(OpenMP{threads}, 9, work), std::bad_alloc) << threads;
    EXPECT_EQ(done, 9);
  }
}

TEST(ASceneOnStandardInput, IsRun) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  EXPECT_EQ(in_shell("$malha run - --steps 2 --out piped --quiet <scene.json", folder), 0);
  EXPECT_EQ(in_shell("$malha run scene.json --steps 2 --out named --quiet", folder), 0);
  EXPECT_EQ(Json::parse(bytes_of(folder / "piped/report.json"))["state_hash"],
            Json::parse(bytes_of(folder / "named/report.json"))["state_hash"]);
  EXPECT_EQ(in_shell("echo { | $malha check - 2>said", folder), 2);
  EXPECT_EQ(bytes_of(folder / "said").find("standard input: line 2, column 1: found "), 0u);
  EXPECT_EQ(in_shell("$malha run - --steps 1 --quiet <scene.json", folder), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "out/standard_input/report.json"));
  EXPECT_EQ(in_shell("$malha check - <scene.json >said", folder), 0);
  EXPECT_EQ(bytes_of(folder / "said").find("standard input: ok"), 0u);
}

TEST(ATooLargeFile, FailsAsOnAFullDisk) {
  const TemporaryFolder folder;
  folder.write("scene.json", swinging_sheet(false).dump());
  EXPECT_EQ(in_shell("ulimit -f 4; $malha run scene.json --steps 9 --every 1 --quiet 2>/dev/null", folder), 4);
}

TEST(ASceneThatIsALink, FindsItsMeshesBesideItsTargetToo) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "scenes/meshes");
  folder.write("scenes/meshes/a.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\nf 1 3 4\n");
  Json scene = swinging_sheet(false);
  scene["bodies"][0]["shape"] = {{"mesh", "meshes/a.obj"}};
  scene["bodies"][0]["constraints"][0]["elements"] = {"edges"};
  folder.write("scenes/scene.json", scene.dump());
  std::filesystem::create_symlink("scenes/scene.json", folder / "link.json");
  EXPECT_EQ(malha_command({"check", "link.json"}, folder / ".").out, "link.json: ok: 4 particles in 1 body\n");
  std::filesystem::create_directory(folder / "meshes");
  folder.write("meshes/a.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 0 2\nf 1 2 3\nf 1 3 4\nf 4 3 5\n");
  EXPECT_EQ(malha_command({"check", "link.json"}, folder / ".").out, "link.json: ok: 5 particles in 1 body\n")
      << "what lies beside the link is meant first";
}

}  // namespace
}  // namespace malha
