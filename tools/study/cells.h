// SPDX-License-Identifier: Apache-2.0
// The cells of a study: single measurements, each kept in a file as soon as it is done, so that a study that was
// stopped goes on where it was. Of a share only some are measured; of a merge none.
#pragma once
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/runs_on.h"
#include "tools/study/interrupted.h"
#include "tools/study/shares.h"

namespace malha::study {

class Cells {
 public:
  using Progress = std::function<void(const std::string& what, int done, int planned)>;

  /// `file` holds a line of JSON a cell after its first line, `head`. A file whose head is another becomes `file`.old
  /// and is started anew. What a crash left of its last line is cut off. Throws std::runtime_error (disk, or another
  /// process is at work on it).
  Cells(const std::filesystem::path& file, const Json& head, bool quick, const std::atomic<bool>& stop,
        Progress progress = {}, const std::optional<Share>& share = {}, bench::RunsOn on = {});

  /// The cells that shares have measured, and no others.
  Cells(const Merged& merged, bool quick, const std::atomic<bool>& stop, bench::RunsOn on = {});

  /// Whether this is the short version, which tests run.
  bool quick() const { return quick_; }
  /// Where malha is measured.
  const bench::RunsOn& runs_on() const { return on_; }

  /// How many cells there will be, for the progress line; may be called again.
  void plan(int cells) { planned_ = share_ ? (cells + share_->n - 1) / share_->n : cells; }

  /// The cell of this key: the kept one, or what make() gives, which is kept. `key` names everything that the value
  /// depends on ("sheet17 xpbd float 10x1"). Null where it is another share's to measure, or was measured by none.
  /// Throws Interrupted where the user stopped the study.
  Json operator()(const std::string& key, const std::function<Json()>& make);

  /// The cells of all items; it is to be asked partial() before any of them is looked at.
  template <class Items, class Key, class Make>
  std::vector<Json> measure_all(const Items& items, const Key& key, const Make& make) {
    std::vector<Json> all;
    for (const auto& item : items) all.push_back((*this)(key(item), [&]() -> Json { return make(item); }));
    return all;
  }

  /// Cells that depend on each other, which one share measures: `ask` asks for them, and may look at each at once. It
  /// is not called where they are another share's, and left where one of them is not there.
  void measure_together(const std::function<void()>& measure);

  /// Whether some of the cells that were asked for are not there: then a study asks for the others and says nothing.
  bool is_partial() const { return share_ || !missing_.empty(); }

  /// Of the machine that measures: a study whose cells depend on it asks here. Of a merge, throws InputError where its
  /// machines differ.
  int cores() const;

  /// To be called every now and then in a long cell: throws Interrupted where the user stopped the study.
  void check_interrupt() const {
    if (stop_) throw Interrupted();
  }

  int kept() const { return kept_; }  // cells that came from the file
  int made() const { return made_; }
  /// Of a merge, by the number of their share: cells that none has measured.
  const std::map<int, std::vector<std::string>>& missing() const { return missing_; }

 private:
  struct Missing {};  // within together()
  int next_share();

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::filesystem::path path_;
  bool quick_;
  bench::RunsOn on_;
  const std::atomic<bool>& stop_;
  Progress progress_;
  std::optional<Share> share_;    // that is measured here
  std::optional<Merged> merged_;  // that is looked at here
  std::map<std::string, Json> known_;
  std::unique_ptr<std::FILE, Close> file_;
  int planned_ = 0, kept_ = 0, made_ = 0;
  int requests_ = 0;                   // single cells and together()s so far
  int group_share_ = 0;                // together(): its share; 0 outside
  std::map<std::string, int> shares_;  // by key, of what was asked for
  std::map<int, std::vector<std::string>> missing_;
};

}  // namespace malha::study
