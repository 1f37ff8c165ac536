// The cells of a study: single measurements, each kept in a file as soon as it is done, so that a study that was
// stopped goes on where it was.
#pragma once
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/study/interrupted.h"

namespace malha::study {

using Json = nlohmann::ordered_json;

class Cells {
 public:
  using Progress = std::function<void(const std::string& what, int done, int planned)>;

  /// `file` holds a line of JSON a cell after its first line, `head`. A file whose head is another becomes `file`.old
  /// and is started anew. What a crash left of its last line is cut off. Throws std::runtime_error (disk, or another
  /// process is at work on it).
  Cells(const std::filesystem::path& file, const Json& head, bool quick, const std::atomic<bool>& stop,
        Progress progress = {});

  /// Whether this is the short version, which tests run.
  bool quick() const { return quick_; }

  /// How many cells there will be, for the progress line; may be called again.
  void plan(int cells) { planned_ = cells; }

  /// The cell of this key: the kept one, or what make() gives, which is kept. `key` names everything that the value
  /// depends on ("sheet17 xpbd float 10x1"). Throws Interrupted where the user stopped the study.
  Json operator()(const std::string& key, const std::function<Json()>& make);

  /// To be called every now and then in a long cell: throws Interrupted where the user stopped the study.
  void go_on() const {
    if (stop_) throw Interrupted();
  }

  int kept() const { return kept_; }  // cells that came from the file
  int made() const { return made_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::filesystem::path path_;
  bool quick_;
  const std::atomic<bool>& stop_;
  Progress progress_;
  std::map<std::string, Json> known_;
  std::unique_ptr<std::FILE, Close> file_;
  int planned_ = 0, kept_ = 0, made_ = 0;
};

}  // namespace malha::study
