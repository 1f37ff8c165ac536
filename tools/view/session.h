// SPDX-License-Identifier: Apache-2.0
// The solver's thread of the window. The window asks for things and goes on; what it shows is the last Snapshot.
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

/// Of one side.
struct SideShown {
  std::shared_ptr<const Frame> frame;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Looks> looks;
  std::vector<std::string> warnings;
  std::map<int, Grip> grips;
  double set_up_ms = 0;
  int lost = -1;  // the particle that diverged; -1: none did
};

struct Snapshot {
  std::int64_t version = 0;      // another one after each change
  std::vector<SideShown> sides;  // none while the first scene is set up
  bool running = false;
  std::string doing;       // "" or what takes long now
  std::string message;     // the last word: what was refused, what diverged, what was saved
  bool trouble = false;    // whether that is bad news
  int refused = 0;         // how many settings were so far
  double pace = 1;         // of simulated to clock time that is wanted; 0: as fast as it goes
  double share = 0;        // of simulated to clock time that is reached
  std::size_t moment = 0;  // the one shown
  Moments moments;
  /// Between the sides, m: root mean square and largest over their particles; none where these are not as many.
  std::optional<std::array<double, 2>> apart;
};

class Session {
 public:
  Session(const SimulationOptions& options, std::size_t history_bytes = std::size_t{512} << 20);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Each of these is done between two steps, in the order asked for. What cannot be done is said in `message`.
  void open(const std::string& path);  // a scene; as the only side
  void open_made(const Scene& scene);
  void compare(std::optional<Scene> other);           // a second side, from the start; none: one side again
  void change(std::size_t side, const Scene& scene);  // goes on with other settings
  void run(bool on);
  void toggle_run();
  void step();
  void substep();  // shows the next substep; where none is left, takes the next step
  void reset();
  void set_pace(double pace);
  void set_look(Look look);
  void show(std::size_t moment);  // pauses; what runs next goes on from there
  void show_back();               // the moment before the one shown
  /// On all of these sides, or where one refuses on none.
  void grip(const std::vector<std::size_t>& sides, int particle, const Vec3& to, bool firm);
  void release(const std::vector<std::size_t>& sides, int particle);
  void cut(std::size_t side, const std::vector<Edge>& edges);
  void save(std::size_t side, const std::string& scene_path, const std::string& checkpoint_path);
  void say(const std::string& message, bool trouble = false);

  Snapshot look();
  /// Waits until everything that was asked for is done.
  void settle();

 private:
  using Clock = std::chrono::steady_clock;
  using Work = std::function<void()>;

  void ask(Work work);  // what forgets the substeps that are still to be shown
  void put(Work work);
  void work();
  void begin(const Scene& scene);
  void advance(bool in_parts = false);
  void take_in_parts(const std::vector<std::vector<std::shared_ptr<const Frame>>>& of_sides);
  void set_running(bool on);
  void go_on_from_shown();
  void keep();
  void keep_the_last();
  void publish();
  void start_anew();
  bool paces() const { return running_ && pace_ > 0; }
  double earliest() const;
  double largest_dt() const;
  void attempt(const Work& work, bool ends_the_run = false);

  SimulationOptions options_;
  std::vector<std::unique_ptr<Side>> sides_;
  std::vector<int> lost_;
  History history_;
  bool running_ = false;
  double pace_ = 1, measure_seconds_ = 0, share_ = 0;
  std::size_t moment_ = 0;
  std::deque<std::vector<std::shared_ptr<const Frame>>> parts_;  // of the last step, still to be shown: of every side
  Look look_ = Look::Bodies;
  Clock::time_point due_ = Clock::now(), share_since_ = Clock::now(), started_ = Clock::now();
  double share_from_ = 0;

  std::mutex mutex_;
  std::condition_variable asked_, settled_;
  std::deque<Work> queue_;
  bool busy_ = false, quit_ = false, looked_ = true;
  Snapshot snapshot_;
  std::thread thread_;
};

}  // namespace malha::view
