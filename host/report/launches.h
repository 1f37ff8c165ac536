// SPDX-License-Identifier: Apache-2.0
// What a step launches: the trace that shows that a scene pays for nothing that it does not name.
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

/// Notes what this thread launches as long as it lives; what others launch meanwhile it does not see.
class LaunchTrace {
 public:
  LaunchTrace();
  ~LaunchTrace();

  /// An entry a kernel, in the order in which they were first launched.
  std::vector<Launches> list() const;

 private:
  struct Watch;
  std::unique_ptr<Watch> watch_;
};

}  // namespace malha
