// SPDX-License-Identifier: Apache-2.0
// Trace of kernel launches. It shows that a scene launches only the passes that it names.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace malha {

struct Launches {
  std::string kernel;  // "SolvePatch<float>"
  std::int64_t launches = 0, items = 0;
  bool operator==(const Launches&) const = default;
};

/// Records the launches of the thread that made it, as long as it lives; launches of other threads are not recorded. A
/// trace within another one records for both.
class LaunchTrace {
 public:
  LaunchTrace();
  ~LaunchTrace();

  /// Returns one entry a kernel, in the order of their first launches.
  std::vector<Launches> list() const;

 private:
  struct Watch;
  std::unique_ptr<Watch> watch_;
};

}  // namespace malha
