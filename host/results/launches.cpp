#include "host/results/launches.h"

#include <algorithm>
#include <cstring>

namespace malha {

namespace {

/// As the source has it: "Visit<float>" of "... [with Kernel = malha::Visit<float>]".
std::string name_of(const std::string& signature) {
  const std::string before = "Kernel = ";
  const std::size_t start = signature.find(before) + before.size();
  std::string name = signature.substr(start, signature.rfind(']') - start);
  for (const std::string part : {"malha::", "(anonymous namespace)::", "{anonymous}::"})
    for (std::size_t at = 0; (at = name.find(part)) != std::string::npos;) name.erase(at, part.size());
  return name;
}

}  // namespace

void LaunchTrace::launched(const char* signature, int items) {
  const auto known = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.signature == signature || std::strcmp(entry.signature, signature) == 0;
  });
  if (known == entries_.end())
    entries_.push_back({signature, 1, items});
  else
    ++known->launches, known->items += items;
}

std::vector<Launches> LaunchTrace::list() const {
  std::vector<Launches> all;
  for (const Entry& entry : entries_) all.push_back({name_of(entry.signature), entry.launches, entry.items});
  return all;
}

}  // namespace malha
