// SPDX-License-Identifier: Apache-2.0
#include "tools/view/session.h"

#include <algorithm>
#include <cmath>

#include "host/base/stopwatch.h"
#include "malha/text.h"

namespace malha::view {

namespace {

constexpr double kMeasureShare = 0.1;  // largest share of the time for the measures of graphs

std::optional<std::array<double, 2>> apart(const std::vector<SideShown>& sides) {
  if (sides.size() != 2 || sides[0].frame->x.size() != sides[1].frame->x.size()) return std::nullopt;
  double sum = 0, most = 0;
  const std::vector<Point3f>&a = sides[0].frame->x, &b = sides[1].frame->x;
  for (std::size_t i = 0; i < a.size(); ++i) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += (double(a[i][k]) - b[i][k]) * (double(a[i][k]) - b[i][k]);
    sum += square, most = std::max(most, square);
  }
  return std::array{std::sqrt(sum / double(std::max<std::size_t>(a.size(), 1))), std::sqrt(most)};
}

}  // namespace

Session::Session(const SimulationOptions& options, std::size_t history_bytes)
    : options_(options), history_(history_bytes), thread_([this] { work(); }) {
  options_.progress = [this](const char* what, double part) {
    const std::lock_guard lock(mutex_);
    snapshot_.doing = what;
    if (part >= 0) snapshot_.doing += ", " + std::to_string(std::lround(100 * part)) + " %";
  };
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  asked_.notify_one();
  thread_.join();
}

void Session::submit(Work work) {
  enqueue([this, work = std::move(work)] {
    substeps_.clear();
    work();
  });
}

void Session::enqueue(Work work) {
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(work));
  }
  asked_.notify_one();
}

void Session::wait_until_done() {
  std::unique_lock lock(mutex_);
  settled_.wait(lock, [this] { return queue_.empty() && !busy_; });
}

Snapshot Session::snapshot() {
  const std::lock_guard lock(mutex_);
  snapshot_taken_ = true;
  return snapshot_;
}

void Session::say(const std::string& message, bool is_error) {
  const std::lock_guard lock(mutex_);
  snapshot_.message = printable(message), snapshot_.is_error = is_error, ++snapshot_.version;
}

constexpr double kSoon = 0.05;  // s, after which a snapshot is published between requests

void Session::work() {
  for (;;) {
    std::deque<Work> todo;
    {
      std::unique_lock lock(mutex_);
      const auto ready = [this] { return quit_ || !queue_.empty(); };
      if (!running_)
        asked_.wait(lock, ready);
      else if (is_paced())
        asked_.wait_until(lock, due_, ready);
      if (quit_) return;
      todo.swap(queue_), busy_ = true;
    }
    for (std::size_t k = 0; k < todo.size(); ++k) {
      const double took = seconds([&] { attempt(todo[k]); });
      if (took > kSoon && k + 1 < todo.size()) publish();
    }
    const bool due = running_ && (!is_paced() || Clock::now() >= due_);
    if (due) attempt([this] { advance(); }, true);
    bool wanted = !todo.empty() || (due && !running_);  // the run has just ended
    {
      const std::lock_guard lock(mutex_);
      wanted = wanted || (due && snapshot_taken_);
    }
    if (wanted) publish();
    {
      const std::lock_guard lock(mutex_);
      busy_ = false;
    }
    settled_.notify_all();
  }
}

/// Does the work and reports a failure, which leaves the session as it was.
void Session::attempt(const Work& work, bool ends_the_run) {
  try {
    work();
  } catch (const std::exception& error) {
    if (ends_the_run) running_ = false;
    say(error.what(), true);
  }
  const std::lock_guard lock(mutex_);
  snapshot_.doing.clear();
}

double Session::earliest() const {
  double time = INFINITY;
  for (const auto& side : sides_) time = std::min(time, side->time());
  return time;
}
double Session::largest_dt() const {
  double dt = 0;
  for (const auto& side : sides_) dt = std::max(dt, side->dt());
  return dt;
}

/// Advances all sides to the same time, by the longest step of any.
void Session::advance(bool by_substeps) {
  if (sides_.empty()) return;
  restore_shown_moment();
  std::vector<std::vector<std::shared_ptr<const Frame>>> parts(sides_.size());
  const double target = earliest() + largest_dt();
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    try {
      while (sides_[s]->time() + 0.5 * sides_[s]->dt() < target && diverged_[s] < 0) {
        if (!by_substeps) {
          sides_[s]->step();
          continue;
        }
        parts[s].push_back(sides_[s]->frame(false));
        for (const auto& part : sides_[s]->step_by_substeps()) parts[s].push_back(part);
      }
    } catch (const Diverged& error) {
      diverged_[s] = sides_[s]->diverged_particle(), running_ = false;
      say(std::string("diverged at ") + error.what() + "; the particle blinks; reset, or show an earlier moment", true);
    }
  }
  if (by_substeps) merge_substeps(parts);
  const Clock::time_point now = Clock::now();
  if (is_paced()) {
    // The wait for a step is at most a day, because larger durations overflow the clock.
    const double wait = std::min(largest_dt() / pace_, 86'400.0);
    due_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait));
    if (due_ + std::chrono::milliseconds(250) < now) due_ = now;  // if the solver is too slow, the delay is not made up
  }
  const double passed = std::chrono::duration<double>(now - share_since_).count();
  if (passed > 0.5) share_ = (earliest() - share_from_) / passed, share_since_ = now, share_from_ = earliest();
  if (std::all_of(diverged_.begin(), diverged_.end(), [](int one) { return one < 0; }) && history_.is_due(earliest()))
    store_moment();
}

/// Merges the substeps of all sides in the order of their times. Each side shows its last substep that is not later.
void Session::merge_substeps(const std::vector<std::vector<std::shared_ptr<const Frame>>>& of_sides) {
  std::vector<double> times;
  for (const auto& side : of_sides)
    for (const auto& part : side) times.push_back(part->time);
  std::sort(times.begin(), times.end());
  const double same = 1e-6 * largest_dt();  // s
  times.erase(std::unique(times.begin(), times.end(), [&](double a, double b) { return b - a < same; }), times.end());
  if (!times.empty()) times.erase(times.begin());  // the state before the step is already shown
  for (const double time : times) {
    std::vector<std::shared_ptr<const Frame>> shown;
    for (const auto& side : of_sides) {
      const auto later = [&](const auto& part) { return part->time > time + same; };
      const auto end = std::find_if(side.begin(), side.end(), later);
      if (end != side.begin()) shown.push_back(*std::prev(end));
    }
    if (shown.size() == of_sides.size()) substeps_.push_back(std::move(shown));
  }
}

/// Stores a moment after every single step.
void Session::store_last_moment() {
  if (!sides_.empty() && history_.moments().back()->frames.front()->time < earliest()) store_moment();
}

void Session::store_moment() {
  Moment moment;
  const double elapsed = std::chrono::duration<double>(Clock::now() - started_).count();
  const bool measured = history_.moments().empty() || measure_seconds_ < kMeasureShare * elapsed;
  const double took = seconds([&] {
    for (const auto& side : sides_) moment.frames.push_back(side->frame(measured));
  });
  if (measured) measure_seconds_ += took;
  for (const auto& side : sides_)
    moment.states.push_back(side->save_state()), moment.scenes.push_back(side->shared_scene());
  history_.add(std::move(moment), earliest());
  moment_ = history_.moments().size() - 1;
}

/// Restores the shown moment, so that the next step continues from there.
void Session::restore_shown_moment() {
  const auto& moments = history_.moments();
  const bool any_diverged = std::any_of(diverged_.begin(), diverged_.end(), [](int one) { return one >= 0; });
  if (moments.empty() || (moment_ + 1 >= moments.size() && !any_diverged)) return;
  const Moment& then = *moments[moment_];
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    if (then.scenes[s] != sides_[s]->shared_scene()) sides_[s]->restore_scene(then.scenes[s]);
    sides_[s]->restore_state(then.states[s]), diverged_[s] = -1;
  }
  history_.cut_after(moment_);
  share_from_ = earliest(), share_since_ = Clock::now();
}

void Session::publish() {
  std::vector<SideShown> shown;
  const auto& moments = history_.moments();
  const bool back = moment_ + 1 < moments.size();
  const auto shown_of = [&](std::size_t s) {
    if (!substeps_.empty()) return substeps_.front()[s];
    return back || diverged_[s] >= 0 ? moments[moment_]->frames[s] : sides_[s]->frame(false);
  };
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const Side& side = *sides_[s];
    shown.push_back({shown_of(s), back ? moments[moment_]->scenes[s] : side.shared_scene(), sides_[s]->fields(field_),
                     side.warnings(), side.handles(), side.set_up_ms(), diverged_[s]});
  }
  const auto distance = apart(shown);
  const std::lock_guard lock(mutex_);
  snapshot_.sides = std::move(shown), snapshot_.running = running_, snapshot_.pace = pace_;
  snapshot_.share = running_ ? share_ : 0, snapshot_.moment = moment_, snapshot_.moments = moments;
  snapshot_.apart = distance;
  snapshot_taken_ = false, ++snapshot_.version;
}

/// Starts a new history after a scene was set up.
void Session::restart_history() {
  diverged_.assign(sides_.size(), -1);
  history_.clear();
  measure_seconds_ = 0, started_ = Clock::now();
  store_moment();
  due_ = share_since_ = Clock::now(), share_from_ = earliest(), share_ = 0;
}

void Session::open(const std::string& path) {
  submit([this, path] { begin(load_scene(path)); });
}
void Session::open_made(const Scene& scene) {
  submit([this, scene] { begin(scene); });
}

void Session::begin(const Scene& scene) {
  auto side = std::make_unique<Side>(scene, options_);
  sides_.clear();
  sides_.push_back(std::move(side));
  running_ = false;
  restart_history();
  say(scene.file + ": set up in " + shown(std::round(sides_[0]->set_up_ms())) + " ms");
}

void Session::compare(std::optional<Scene> other) {
  submit([this, other] {
    if (sides_.empty()) return;
    if (other) {
      auto side = std::make_unique<Side>(*other, options_);
      sides_[0]->change(sides_[0]->scene(), true);
      sides_.resize(1);
      sides_.push_back(std::move(side));
    } else {
      sides_.resize(1);
    }
    restart_history();
  });
}

void Session::change(std::size_t side, const Scene& scene) {
  submit([this, side, scene] {
    if (side >= sides_.size()) return;
    try {
      restore_shown_moment();
      sides_[side]->change(scene, false);
    } catch (const InputError&) {
      const std::lock_guard lock(mutex_);
      ++snapshot_.refused;
      throw;
    }
    say("set up again in " + shown(std::round(10 * sides_[side]->set_up_ms()) / 10) + " ms");
    store_moment();
    due_ = Clock::now();
  });
}

void Session::run(bool on) {
  submit([this, on] { set_running(on); });
}
void Session::toggle_run() {
  submit([this] { set_running(!running_); });
}

void Session::set_running(bool on) {
  running_ = on && !sides_.empty();
  due_ = share_since_ = Clock::now();
  if (running_) restore_shown_moment(), share_from_ = earliest();
}

void Session::step() {
  submit([this] {
    running_ = false;
    advance();
    store_last_moment();
  });
}

void Session::substep() {
  enqueue([this] {
    running_ = false;
    if (!substeps_.empty()) return substeps_.pop_front();
    std::size_t bytes = 0;
    for (const auto& side : sides_) bytes += side->bytes_of_substeps();
    if (bytes > history_.room())
      throw InputError("substep: found a step whose substeps take " + std::to_string(bytes >> 20) +
                       " MB; allowed: " + std::to_string(history_.room() >> 20) + " MB");
    advance(true);
    store_last_moment();
  });
}

void Session::reset() {
  submit([this] {
    if (sides_.empty()) return;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      if (history_.moments().front()->scenes[s] != sides_[s]->shared_scene())
        sides_[s]->change(sides_[s]->scene(), true);
      else
        sides_[s]->restore_state(history_.moments().front()->states[s]);
    }
    restart_history();
  });
}

void Session::set_pace(double pace) {
  enqueue([this, pace] { pace_ = pace, due_ = Clock::now(); });
}

void Session::set_visual_field(VisualField field) {
  enqueue([this, field] { field_ = field; });
}

void Session::show(std::size_t moment) {
  submit([this, moment] {
    running_ = false;
    if (!history_.moments().empty()) moment_ = std::min(moment, history_.moments().size() - 1);
  });
}

void Session::show_back() {
  submit([this] {
    running_ = false;
    if (moment_ > 0) --moment_;
  });
}

void Session::set_handle(const std::vector<std::size_t>& sides, int particle, const Vec3& to, bool is_held) {
  submit([=, this] {
    if (std::any_of(sides.begin(), sides.end(), [this](std::size_t s) { return s >= sides_.size(); })) return;
    restore_shown_moment();
    std::vector<std::size_t> taken;
    try {
      for (const std::size_t s : sides) {
        const bool before = sides_[s]->handles().contains(particle);
        sides_[s]->set_handle(particle, to, is_held);
        if (!before) taken.push_back(s);
      }
    } catch (const InputError&) {
      for (const std::size_t s : taken) sides_[s]->release(particle);
      throw;
    }
  });
}

void Session::release(const std::vector<std::size_t>& sides, int particle) {
  submit([=, this] {
    for (const std::size_t s : sides)
      if (s < sides_.size()) sides_[s]->release(particle);
  });
}

void Session::cut(std::size_t side, const std::vector<Edge>& edges) {
  submit([=, this] {
    if (side >= sides_.size()) return;
    restore_shown_moment();
    say("cut: " + counted(sides_[side]->cut(edges), "vertex", "vertices") + " parted");
  });
}

/// Saves the shown moment; after a divergence, the last moment before.
void Session::save(std::size_t side, const std::string& scene_path, const std::string& checkpoint_path) {
  enqueue([=, this] {
    if (side >= sides_.size()) return;
    const auto& moments = history_.moments();
    if (moment_ + 1 < moments.size() || diverged_[side] >= 0)
      save_state(*moments[moment_]->scenes[side], moments[moment_]->states[side], options_, scene_path,
                 checkpoint_path);
    else
      sides_[side]->save(scene_path, checkpoint_path);
    say("saved " + scene_path + " and " + checkpoint_path);
  });
}

}  // namespace malha::view
