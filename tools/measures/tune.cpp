#include "tools/measures/tune.h"

#include <filesystem>
#include <functional>
#include <iostream>

#include "host/base/file.h"
#include "host/error.h"
#include "host/scene.h"
#include "kernels/compute.h"
#include "tools/study/progress.h"
#include "tools/tune/report.h"

namespace malha {

namespace {

namespace fs = std::filesystem;

void prepare(const fs::path& file) {
  if (const fs::path folder = file.parent_path(); !folder.empty()) make_folder(folder);
  check_writable(file);
}

}  // namespace

int tune(const Arguments& arguments, const std::atomic<bool>& stop) {
  const Scene scene = load_scene(arguments.scene);
  study::check_tunable(scene);
  const fs::path out = !arguments.out.empty() ? arguments.out : "out/" + arguments.scene_name() + "_tuned.json";
  const fs::path json = arguments.tune.json;
  if (json.lexically_normal() == out.lexically_normal())
    refuse("malha tune", "--json", "'" + json.string() + "', which is to be the tuned scene", "another file");
  prepare(out);
  if (!json.empty()) prepare(json);
  const study::TuneOptions options{arguments.tune.error, arguments.tune.seconds,
                                   arguments.threads > 0 ? arguments.threads : available_threads()};
  study::ProgressLine progress(5);
  const study::Tuned tuned = study::tune(scene, options, std::ref(progress), stop);
  progress.clear();
  std::cout << study::tune_table(tuned, options);
  if (!tuned.best) {
    std::cerr << printable(arguments.scene_label()) << ": " << study::why_not_tuned(tuned, options) << "\n";
    return kUnmet;
  }
  write_whole(out, to_json(tuned.trials[*tuned.best].scene));
  std::cout << "scene       " << printable(out.string()) << "\n";
  if (json.empty()) return kDone;
  write_whole(json, study::tune_json(tuned, options).dump(2) + "\n");
  std::cout << "trials      " << printable(json.string()) << "\n";
  return kDone;
}

}  // namespace malha
