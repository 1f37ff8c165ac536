// SPDX-License-Identifier: Apache-2.0
#include "tools/study/cells.h"

#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "host/base/file.h"
#include "tools/bench/counts.h"

namespace malha::study {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw std::runtime_error(path.string() + ": cannot write: " + std::strerror(errno));
}

/// The complete lines of a journal whose first line is `head`, whose cells are also added to `cells`. If the first line
/// differs, only `head`.
std::string valid_lines(const std::string& bytes, const Json& head, std::map<std::string, Json>& cells) {
  std::string good = head.dump() + "\n";
  std::istringstream text(bytes.substr(0, bytes.rfind('\n') + 1));  // npos + 1 is 0
  std::string line;
  if (!std::getline(text, line) || !(Json::parse(line, nullptr, false) == head)) return good;
  while (std::getline(text, line)) {
    const Json cell = Json::parse(line, nullptr, false);
    if (!cell.is_object() || !cell.contains("key") || !cell.contains("value")) break;
    cells[cell["key"].get<std::string>()] = cell["value"];
    good += line + "\n";
  }
  return good;
}

}  // namespace

Cells::Cells(const std::filesystem::path& file, const Json& head, bool quick, const std::atomic<bool>& stop,
             Progress progress, const std::optional<Share>& share, bench::RunsOn on)
    : path_(file), quick_(quick), on_(std::move(on)), stop_(stop), progress_(std::move(progress)), share_(share) {
  file_.reset(std::fopen(path_.c_str(), "ab"));
  if (!file_) fail(path_);
  const int number = fileno(file_.get());
  if (flock(number, LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error(path_.string() + ": another malha study is using it");
  const std::string bytes = read_whole(path_), good = valid_lines(bytes, head, known_);
  const bool same_head = bytes.starts_with(good);
  if (!same_head && !bytes.empty()) write_whole(path_.string() + ".old", bytes);
  if (ftruncate(number, same_head ? static_cast<off_t>(good.size()) : 0) != 0) fail(path_);
  if (!same_head &&
      (std::fwrite(good.data(), 1, good.size(), file_.get()) != good.size() || std::fflush(file_.get()) != 0))
    fail(path_);
}

Cells::Cells(const Merged& merged, bool quick, const std::atomic<bool>& stop, bench::RunsOn on)
    : quick_(quick), on_(std::move(on)), stop_(stop), merged_(merged), known_(merged.cells) {}

int Cells::cores() const { return merged_ ? merged_->cores() : bench::cores(); }

/// The share that measures the next cell or group of cells.
int Cells::next_share() {
  const int shares = share_ ? share_->n : merged_ ? merged_->shares : 1;
  return requests_++ % shares + 1;
}

void Cells::measure_together(const std::function<void()>& measure) {
  group_share_ = next_share();
  try {
    if (!share_ || group_share_ == share_->i) measure();
  } catch (const Missing&) {
  }
  group_share_ = 0;
}

Json Cells::operator()(const std::string& key, const std::function<Json()>& make) {
  const auto [turn, fresh] = shares_.insert({key, group_share_});
  if (fresh && group_share_ == 0) turn->second = next_share();
  const int share = turn->second;
  if (share_ && share != share_->i) return nullptr;
  if (progress_) progress_(key, kept_ + made_, planned_);
  if (const auto found = known_.find(key); found != known_.end()) {
    ++kept_;
    return found->second;
  }
  check_interrupt();
  if (merged_) {
    missing_[share].push_back(key);
    if (group_share_ > 0) throw Missing{};
    return nullptr;
  }
  const Json value = make();
  const std::string line = Json{{"key", key}, {"value", value}}.dump() + "\n";
  // A line is written in one piece: if this process is killed, the file has complete lines and perhaps a torn last one.
  if (std::fwrite(line.data(), 1, line.size(), file_.get()) != line.size() || std::fflush(file_.get()) != 0)
    fail(path_);
  ++made_;
  // The value is parsed again, so that a resumed study computes with the same numbers (NaN is null in JSON).
  return known_[key] = Json::parse(line)["value"];
}

}  // namespace malha::study
