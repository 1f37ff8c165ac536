// SPDX-License-Identifier: Apache-2.0
#include "tools/view/session.h"

#include <algorithm>
#include <cmath>

#include "host/base/stopwatch.h"
#include "malha/text.h"

namespace malha::view {

namespace {

constexpr double kMeasureShare = 0.1;  // of the time, at most, that goes into what graphs show

std::optional<std::array<double, 2>> apart(const std::vector<SideShown>& sides) {
  if (sides.size() != 2 || sides[0].frame->x.size() != sides[1].frame->x.size()) return std::nullopt;
  double sum = 0, most = 0;
  const std::vector<Place>&a = sides[0].frame->x, &b = sides[1].frame->x;
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

void Session::ask(Work work) {
  put([this, work = std::move(work)] {
    parts_.clear();
    work();
  });
}

void Session::put(Work work) {
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(work));
  }
  asked_.notify_one();
}

void Session::settle() {
  std::unique_lock lock(mutex_);
  settled_.wait(lock, [this] { return queue_.empty() && !busy_; });
}

Snapshot Session::look() {
  const std::lock_guard lock(mutex_);
  looked_ = true;
  return snapshot_;
}

void Session::say(const std::string& message, bool trouble) {
  const std::lock_guard lock(mutex_);
  snapshot_.message = printable(message), snapshot_.trouble = trouble, ++snapshot_.version;
}

constexpr double kSoon = 0.05;  // s, after which what was done is shown

void Session::work() {
  for (;;) {
    std::deque<Work> todo;
    {
      std::unique_lock lock(mutex_);
      const auto ready = [this] { return quit_ || !queue_.empty(); };
      if (!running_)
        asked_.wait(lock, ready);
      else if (paces())
        asked_.wait_until(lock, due_, ready);
      if (quit_) return;
      todo.swap(queue_), busy_ = true;
    }
    for (std::size_t k = 0; k < todo.size(); ++k) {
      const double took = seconds([&] { attempt(todo[k]); });
      if (took > kSoon && k + 1 < todo.size()) publish();
    }
    const bool due = running_ && (!paces() || Clock::now() >= due_);
    if (due) attempt([this] { advance(); }, true);
    bool wanted = !todo.empty() || (due && !running_);  // it has just ended by itself
    {
      const std::lock_guard lock(mutex_);
      wanted = wanted || (due && looked_);
    }
    if (wanted) publish();
    {
      const std::lock_guard lock(mutex_);
      busy_ = false;
    }
    settled_.notify_all();
  }
}

/// What cannot be done is said, and leaves things as they were.
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

/// The sides in step: each goes as far as the one with the longest steps.
void Session::advance(bool in_parts) {
  if (sides_.empty()) return;
  go_on_from_shown();
  std::vector<std::vector<std::shared_ptr<const Frame>>> parts(sides_.size());
  const double target = earliest() + largest_dt();
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    try {
      while (sides_[s]->time() + 0.5 * sides_[s]->dt() < target && lost_[s] < 0) {
        if (!in_parts) {
          sides_[s]->step();
          continue;
        }
        parts[s].push_back(sides_[s]->frame(false));
        for (const auto& part : sides_[s]->step_in_parts()) parts[s].push_back(part);
      }
    } catch (const Diverged& error) {
      lost_[s] = sides_[s]->lost(), running_ = false;
      say(std::string("diverged at ") + error.what() + "; the particle blinks; reset, or go back", true);
    }
  }
  if (in_parts) take_in_parts(parts);
  const Clock::time_point now = Clock::now();
  if (paces()) {
    // No step is waited for longer than a day: a clock cannot tell much more.
    const double wait = std::min(largest_dt() / pace_, 86'400.0);
    due_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait));
    if (due_ + std::chrono::milliseconds(250) < now) due_ = now;  // too slow: what was missed is not made up for
  }
  const double passed = std::chrono::duration<double>(now - share_since_).count();
  if (passed > 0.5) share_ = (earliest() - share_from_) / passed, share_since_ = now, share_from_ = earliest();
  if (std::all_of(lost_.begin(), lost_.end(), [](int one) { return one < 0; }) && history_.wants(earliest())) keep();
}

/// In the order of their times. A side shows the last of its own that is not later.
void Session::take_in_parts(const std::vector<std::vector<std::shared_ptr<const Frame>>>& of_sides) {
  std::vector<double> times;
  for (const auto& side : of_sides)
    for (const auto& part : side) times.push_back(part->time);
  std::sort(times.begin(), times.end());
  const double same = 1e-6 * largest_dt();  // s
  times.erase(std::unique(times.begin(), times.end(), [&](double a, double b) { return b - a < same; }), times.end());
  if (!times.empty()) times.erase(times.begin());  // what was shown before the step
  for (const double time : times) {
    std::vector<std::shared_ptr<const Frame>> shown;
    for (const auto& side : of_sides) {
      const auto later = [&](const auto& part) { return part->time > time + same; };
      const auto end = std::find_if(side.begin(), side.end(), later);
      if (end != side.begin()) shown.push_back(*std::prev(end));
    }
    if (shown.size() == of_sides.size()) parts_.push_back(std::move(shown));
  }
}

/// Of single steps, all.
void Session::keep_the_last() {
  if (!sides_.empty() && history_.moments().back()->frames.front()->time < earliest()) keep();
}

void Session::keep() {
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

/// A step after a look back goes on from what was shown.
void Session::go_on_from_shown() {
  const auto& moments = history_.moments();
  const bool lost = std::any_of(lost_.begin(), lost_.end(), [](int one) { return one >= 0; });
  if (moments.empty() || (moment_ + 1 >= moments.size() && !lost)) return;
  const Moment& then = *moments[moment_];
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    if (then.scenes[s] != sides_[s]->shared_scene()) sides_[s]->change_back(then.scenes[s]);
    sides_[s]->restore_state(then.states[s]), lost_[s] = -1;
  }
  history_.cut_after(moment_);
  share_from_ = earliest(), share_since_ = Clock::now();
}

void Session::publish() {
  std::vector<SideShown> shown;
  const auto& moments = history_.moments();
  const bool back = moment_ + 1 < moments.size();
  const auto shown_of = [&](std::size_t s) {
    if (!parts_.empty()) return parts_.front()[s];
    return back || lost_[s] >= 0 ? moments[moment_]->frames[s] : sides_[s]->frame(false);
  };
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const Side& side = *sides_[s];
    shown.push_back({shown_of(s), back ? moments[moment_]->scenes[s] : side.shared_scene(), sides_[s]->looks(look_),
                     side.warnings(), side.grips(), side.set_up_ms(), lost_[s]});
  }
  const auto distance = apart(shown);
  const std::lock_guard lock(mutex_);
  snapshot_.sides = std::move(shown), snapshot_.running = running_, snapshot_.pace = pace_;
  snapshot_.share = running_ ? share_ : 0, snapshot_.moment = moment_, snapshot_.moments = moments;
  snapshot_.apart = distance;
  looked_ = false, ++snapshot_.version;
}

/// After a scene was laid out: at its start, or where it was.
void Session::start_anew() {
  lost_.assign(sides_.size(), -1);
  history_.clear();
  measure_seconds_ = 0, started_ = Clock::now();
  keep();
  due_ = share_since_ = Clock::now(), share_from_ = earliest(), share_ = 0;
}

void Session::open(const std::string& path) {
  ask([this, path] { begin(load_scene(path)); });
}
void Session::open_made(const Scene& scene) {
  ask([this, scene] { begin(scene); });
}

void Session::begin(const Scene& scene) {
  auto side = std::make_unique<Side>(scene, options_);
  sides_.clear();
  sides_.push_back(std::move(side));
  running_ = false;
  start_anew();
  say(scene.file + ": set up in " + shown(std::round(sides_[0]->set_up_ms())) + " ms");
}

void Session::compare(std::optional<Scene> other) {
  ask([this, other] {
    if (sides_.empty()) return;
    if (other) {
      auto side = std::make_unique<Side>(*other, options_);
      sides_[0]->change(sides_[0]->scene(), true);
      sides_.resize(1);
      sides_.push_back(std::move(side));
    } else {
      sides_.resize(1);
    }
    start_anew();
  });
}

void Session::change(std::size_t side, const Scene& scene) {
  ask([this, side, scene] {
    if (side >= sides_.size()) return;
    try {
      go_on_from_shown();
      sides_[side]->change(scene, false);
    } catch (const InputError&) {
      const std::lock_guard lock(mutex_);
      ++snapshot_.refused;
      throw;
    }
    say("laid out anew in " + shown(std::round(10 * sides_[side]->set_up_ms()) / 10) + " ms");
    keep();
    due_ = Clock::now();
  });
}

void Session::run(bool on) {
  ask([this, on] { set_running(on); });
}
void Session::toggle_run() {
  ask([this] { set_running(!running_); });
}

void Session::set_running(bool on) {
  running_ = on && !sides_.empty();
  due_ = share_since_ = Clock::now();
  if (running_) go_on_from_shown(), share_from_ = earliest();
}

void Session::step() {
  ask([this] {
    running_ = false;
    advance();
    keep_the_last();
  });
}

void Session::substep() {
  put([this] {
    running_ = false;
    if (!parts_.empty()) return parts_.pop_front();
    std::size_t bytes = 0;
    for (const auto& side : sides_) bytes += side->bytes_of_parts();
    if (bytes > history_.room())
      throw InputError("substep: found a step whose parts take " + std::to_string(bytes >> 20) +
                       " MB; allowed: " + std::to_string(history_.room() >> 20) + " MB");
    advance(true);
    keep_the_last();
  });
}

void Session::reset() {
  ask([this] {
    if (sides_.empty()) return;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      if (history_.moments().front()->scenes[s] != sides_[s]->shared_scene())
        sides_[s]->change(sides_[s]->scene(), true);
      else
        sides_[s]->restore_state(history_.moments().front()->states[s]);
    }
    start_anew();
  });
}

void Session::set_pace(double pace) {
  put([this, pace] { pace_ = pace, due_ = Clock::now(); });
}

void Session::set_look(Look look) {
  put([this, look] { look_ = look; });
}

void Session::show(std::size_t moment) {
  ask([this, moment] {
    running_ = false;
    if (!history_.moments().empty()) moment_ = std::min(moment, history_.moments().size() - 1);
  });
}

void Session::show_back() {
  ask([this] {
    running_ = false;
    if (moment_ > 0) --moment_;
  });
}

void Session::grip(const std::vector<std::size_t>& sides, int particle, const Vec3& to, bool firm) {
  ask([=, this] {
    if (std::any_of(sides.begin(), sides.end(), [this](std::size_t s) { return s >= sides_.size(); })) return;
    go_on_from_shown();
    std::vector<std::size_t> taken;
    try {
      for (const std::size_t s : sides) {
        const bool before = sides_[s]->grips().contains(particle);
        sides_[s]->grip(particle, to, firm);
        if (!before) taken.push_back(s);
      }
    } catch (const InputError&) {
      for (const std::size_t s : taken) sides_[s]->release(particle);
      throw;
    }
  });
}

void Session::release(const std::vector<std::size_t>& sides, int particle) {
  ask([=, this] {
    for (const std::size_t s : sides)
      if (s < sides_.size()) sides_[s]->release(particle);
  });
}

void Session::cut(std::size_t side, const std::vector<Edge>& edges) {
  ask([=, this] {
    if (side >= sides_.size()) return;
    go_on_from_shown();
    say("cut: " + counted(sides_[side]->cut(edges), "vertex", "vertices") + " parted");
  });
}

/// What is shown: of a run that diverged the last moment before.
void Session::save(std::size_t side, const std::string& scene_path, const std::string& checkpoint_path) {
  put([=, this] {
    if (side >= sides_.size()) return;
    const auto& moments = history_.moments();
    if (moment_ + 1 < moments.size() || lost_[side] >= 0)
      save_state(*moments[moment_]->scenes[side], moments[moment_]->states[side], options_, scene_path,
                 checkpoint_path);
    else
      sides_[side]->save(scene_path, checkpoint_path);
    say("saved " + scene_path + " and " + checkpoint_path);
  });
}

}  // namespace malha::view
