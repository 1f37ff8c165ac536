#include "tools/tune.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "host/base/file.h"
#include "host/scene.h"
#include "kernels/compute.h"
#include "tools/bench/status.h"
#include "tools/study/tune_report.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

/// A line that redraws itself on a terminal; plain lines every few seconds otherwise.
class Shown {
 public:
  void operator()(const std::string& what, double part) {
    status_.show(what, part);
    constexpr double silence = 5;  // s
    const auto now = std::chrono::steady_clock::now();
    if (isatty(STDERR_FILENO) || std::chrono::duration<double>(now - said_at_).count() < silence) return;
    std::fprintf(stderr, "%s\n", what.c_str());
    said_at_ = now;
  }
  void clear() { status_.clear(); }

 private:
  bench::Status status_;
  std::chrono::steady_clock::time_point said_at_ = std::chrono::steady_clock::now();
};

void prepare(const fs::path& file) {
  if (const fs::path folder = file.parent_path(); !folder.empty()) make_folder(folder);
  check_writable(file);
}

}  // namespace

int tune(const Arguments& arguments, const std::atomic<bool>& stop) {
  const Scene scene = load_scene(arguments.scene);
  study::check_tunable(scene);
  const fs::path out =
      !arguments.out.empty() ? arguments.out : "out/" + fs::path(arguments.scene).stem().string() + "_tuned.json";
  const fs::path json = arguments.tune.json;
  prepare(out);
  if (!json.empty()) prepare(json);
  const study::TuneOptions options{arguments.tune.error, arguments.tune.seconds,
                                   arguments.threads > 0 ? arguments.threads : available_threads()};
  Shown shown;
  const study::Tuned tuned = study::tune(scene, options, std::ref(shown), stop);
  shown.clear();
  std::cout << study::tune_table(tuned, options);
  if (!tuned.best) {
    std::cerr << arguments.scene << ": " << study::why_not_tuned(tuned, options) << "\n";
    return kUnmet;
  }
  write_whole(out, to_json(tuned.trials[*tuned.best].scene));
  std::cout << "scene       " << out.string() << "\n";
  if (json.empty()) return kDone;
  write_whole(json, study::tune_json(tuned, options).dump(2) + "\n");
  std::cout << "trials      " << json.string() << "\n";
  return kDone;
}

}  // namespace malha
