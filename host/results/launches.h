// What a step launches: the trace that shows that a scene pays for nothing that it does not name.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "kernels/compute.h"

namespace malha {

struct Launches {
  std::string kernel;  // "Visit<float>"
  std::int64_t launches = 0, items = 0;
  bool operator==(const Launches&) const = default;
};

/// Notes what this thread launches as long as it lives; what others launch meanwhile it does not see.
class LaunchTrace final : LaunchWatch {
 public:
  LaunchTrace() : before_(launch_watch) { launch_watch = this; }
  ~LaunchTrace() { launch_watch = before_; }
  LaunchTrace(const LaunchTrace&) = delete;
  LaunchTrace& operator=(const LaunchTrace&) = delete;

  /// An entry a kernel, in the order in which they were first launched.
  std::vector<Launches> list() const;

 private:
  struct Entry {
    const char* signature;
    std::int64_t launches, items;
  };
  void launched(const char* signature, int items) override;

  LaunchWatch* before_;
  std::vector<Entry> entries_;
};

}  // namespace malha
