// SPDX-License-Identifier: Apache-2.0
#include "host/report/launches.h"

#include <algorithm>
#include <cstring>

#include "kernels/parallel/compute.h"

namespace malha {

namespace {

/// Returns the kernel's name as in the source: "SolvePatch<float>" from "... [with Kernel = malha::SolvePatch<float>]".
std::string name_of(const std::string& signature) {
  const std::string before = "Kernel = ";
  const std::size_t start = signature.find(before) + before.size();
  std::string name = signature.substr(start, signature.rfind(']') - start);
  for (const std::string part : {"malha::", "(anonymous namespace)::", "{anonymous}::"})
    for (std::size_t at = 0; (at = name.find(part)) != std::string::npos;) name.erase(at, part.size());
  return name;
}

}  // namespace

struct LaunchTrace::Watch final : LaunchObserver {
  struct Entry {
    const char* signature;
    std::int64_t launches, items;
  };
  void launched(const char* signature, int items) override {
    if (before) before->launched(signature, items);
    const auto known = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
      return entry.signature == signature || std::strcmp(entry.signature, signature) == 0;
    });
    if (known == entries.end())
      entries.push_back({signature, 1, items});
    else
      ++known->launches, known->items += items;
  }

  LaunchObserver* before = launch_observer;
  std::vector<Entry> entries;
};

LaunchTrace::LaunchTrace() : watch_(std::make_unique<Watch>()) { launch_observer = watch_.get(); }
LaunchTrace::~LaunchTrace() { launch_observer = watch_->before; }

std::vector<Launches> LaunchTrace::list() const {
  std::vector<Launches> all;
  for (const auto& [signature, launches, items] : watch_->entries) all.push_back({name_of(signature), launches, items});
  return all;
}

}  // namespace malha
