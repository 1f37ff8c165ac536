// SPDX-License-Identifier: Apache-2.0
// The solver's thread of the window. The window submits requests without waiting, and shows the last Snapshot.
#pragma once
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "tools/view/history.h"
#include "tools/view/side.h"

namespace malha::view {

/// State of one side.
struct SideShown {
  std::shared_ptr<const Frame> frame;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const VisualFields> fields;
  std::vector<std::string> warnings;
  std::map<int, Handle> handles;
  double set_up_ms = 0;
  int diverged_particle = -1;  // -1: none
};

struct Snapshot {
  std::int64_t version = 0;      // increased by each change
  std::vector<SideShown> sides;  // empty while the first scene is set up
  bool running = false;
  std::string doing;       // a long activity in progress, or ""
  std::string message;     // the last message: a refusal, a divergence, a saved file
  bool is_error = false;   // whether the message is an error
  int refused = 0;         // number of refused changes of settings so far
  double pace = 1;         // requested ratio of simulated to clock time; 0: unlimited
  double share = 0;        // reached ratio of simulated to clock time
  std::size_t moment = 0;  // index of the one shown
  Moments moments;
  /// Distance of the sides, m: root mean square and maximum over their particles; none if their numbers differ.
  std::optional<std::array<double, 2>> apart;
};

class Session {
 public:
  Session(const SimulationOptions& options, std::size_t history_bytes = std::size_t{512} << 20);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// These requests are done between steps, in the order of the calls. Failures are reported in `message`.
  void open(const std::string& path);  // opens a scene as the only side
  void open_made(const Scene& scene);
  void compare(std::optional<Scene> other);           // adds a second side, both from the start; none: removes it
  void change(std::size_t side, const Scene& scene);  // continues with other settings
  void run(bool on);
  void toggle_run();
  void step();
  void substep();  // shows the next substep; takes a step if none is left
  void reset();
  void set_pace(double pace);
  void set_visual_field(VisualField field);
  void show(std::size_t moment);  // pauses; the next step continues from there
  void show_back();               // shows the previous moment
  /// Sets a handle on all of these sides, or on none if one of them refuses.
  void set_handle(const std::vector<std::size_t>& sides, int particle, const Vec3& to, bool is_held);
  void release(const std::vector<std::size_t>& sides, int particle);
  void cut(std::size_t side, const std::vector<Edge>& edges);
  void save(std::size_t side, const std::string& scene_path, const std::string& checkpoint_path);
  void say(const std::string& message, bool is_error = false);

  Snapshot snapshot();
  /// Waits until all requests are done.
  void wait_until_done();

 private:
  using Clock = std::chrono::steady_clock;
  using Work = std::function<void()>;

  void submit(Work work);  // enqueues work that discards the substeps still to be shown
  void enqueue(Work work);
  void work();
  void begin(const Scene& scene);
  void advance(bool by_substeps = false);
  void merge_substeps(const std::vector<std::vector<std::shared_ptr<const Frame>>>& of_sides);
  void set_running(bool on);
  void restore_shown_moment();
  void store_moment();
  void store_last_moment();
  void publish();
  void restart_history();
  bool is_paced() const { return running_ && pace_ > 0; }
  double earliest() const;
  double largest_dt() const;
  void attempt(const Work& work, bool ends_the_run = false);

  SimulationOptions options_;
  std::vector<std::unique_ptr<Side>> sides_;
  std::vector<int> diverged_;
  History history_;
  bool running_ = false;
  double pace_ = 1, measure_seconds_ = 0, share_ = 0;
  std::size_t moment_ = 0;
  std::deque<std::vector<std::shared_ptr<const Frame>>>
      substeps_;  // frames of all sides of the substeps of the last step, still to be shown
  VisualField field_ = VisualField::Bodies;
  Clock::time_point due_ = Clock::now(), share_since_ = Clock::now(), started_ = Clock::now();
  double share_from_ = 0;

  std::mutex mutex_;
  std::condition_variable asked_, settled_;
  std::deque<Work> queue_;
  bool busy_ = false, quit_ = false, snapshot_taken_ = true;
  Snapshot snapshot_;
  std::thread thread_;
};

}  // namespace malha::view
