// SPDX-License-Identifier: Apache-2.0
// Cells of a study: single measurements. Each is appended to a journal as soon as it is finished, so that a study that
// was stopped can be resumed. A share measures only some cells, a merge none.
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

  /// Opens the journal `file`: its first line is `head`, and each further one a cell as JSON. A file with another head
  /// is renamed to `file`.old and started anew. A torn last line is removed. Throws std::runtime_error if the file
  /// cannot be written or another process is using it.
  Cells(const std::filesystem::path& file, const Json& head, bool quick, const std::atomic<bool>& stop,
        Progress progress = {}, const std::optional<Share>& share = {}, bench::RunsOn on = {});

  /// Reads the cells that shares have measured; measures none.
  Cells(const Merged& merged, bool quick, const std::atomic<bool>& stop, bench::RunsOn on = {});

  /// True for the short version of the study, which tests run.
  bool quick() const { return quick_; }
  /// The backend on which malha is measured.
  const bench::RunsOn& runs_on() const { return on_; }

  /// Sets the expected number of cells, for the progress line; may be called again.
  void plan(int cells) { planned_ = share_ ? (cells + share_->n - 1) / share_->n : cells; }

  /// The cell of this key: from the journal, or else the result of make(), which is stored there. `key` names
  /// everything that the value depends on ("sheet17 xpbd float 10x1"). Null if the cell belongs to another share, or no
  /// share has measured it. Throws Interrupted if the user stopped the study.
  Json operator()(const std::string& key, const std::function<Json()>& make);

  /// The cells of all items. The caller must check is_partial() before it reads any of them.
  template <class Items, class Key, class Make>
  std::vector<Json> measure_all(const Items& items, const Key& key, const Make& make) {
    std::vector<Json> all;
    for (const auto& item : items) all.push_back((*this)(key(item), [&]() -> Json { return make(item); }));
    return all;
  }

  /// Measures cells that depend on each other in one share: `measure` requests them, and may read each at once. It is
  /// not called if they belong to another share, and aborted if one of them is missing.
  void measure_together(const std::function<void()>& measure);

  /// True if some requested cells are missing: a study then requests the remaining cells and reports nothing.
  bool is_partial() const { return share_ || !missing_.empty(); }

  /// Number of cores of the machine that measures, for studies whose cells depend on it. In a merge, throws InputError
  /// if its machines differ.
  int cores() const;

  /// Throws Interrupted if the user stopped the study. Long cells must call it regularly.
  void check_interrupt() const {
    if (stop_) throw Interrupted();
  }

  int kept() const { return kept_; }  // cells from the journal
  int made() const { return made_; }
  /// In a merge, the keys of cells that no share has measured, by the number of their share.
  const std::map<int, std::vector<std::string>>& missing() const { return missing_; }

 private:
  struct Missing {};  // aborts measure_together()
  int next_share();

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::filesystem::path path_;
  bool quick_;
  bench::RunsOn on_;
  const std::atomic<bool>& stop_;
  Progress progress_;
  std::optional<Share> share_;    // the share to be measured
  std::optional<Merged> merged_;  // the cells to be read
  std::map<std::string, Json> known_;
  std::unique_ptr<std::FILE, Close> file_;
  int planned_ = 0, kept_ = 0, made_ = 0;
  int requests_ = 0;                   // single cells and groups of cells so far
  int group_share_ = 0;                // share of the group within measure_together(); 0 outside
  std::map<std::string, int> shares_;  // share of each requested cell, by key
  std::map<int, std::vector<std::string>> missing_;
};

}  // namespace malha::study
