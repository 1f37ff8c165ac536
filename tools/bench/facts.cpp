// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/facts.h"

#include <nlohmann/json.hpp>

#include "malha/simulation.h"
#include "malha/text.h"
#include "tools/bench/cloth.h"
#include "tools/bench/counts.h"
#include "tools/bench/machine.h"
#include "tools/bench/output.h"

namespace malha::bench {

using Json = nlohmann::ordered_json;

Json build_facts() {
  const Json report = Json::parse(Simulation(hanging_cloth(grid_case(3), {})).report("benchmark"));
  Json facts;
  for (const char* key : {"malha_version", "compiler", "flags", "instructions", "cpu"}) facts[key] = report.at(key);
  facts["cores"] = cores();
  return facts;
}

Json machine_facts(const std::vector<int>& threads, const RunsOn& on) {
  Json facts = build_facts();
  if (on.is_device()) {
    const DeviceStats device = cuda_device();
    facts["device"] = device.name, facts["device_gb_per_s"] = device.bytes_per_second * 1e-9;
  }
  facts["triad_bytes"] = kMemoryBytes;
  facts["triad_gb_per_s"] = bandwidths(threads, triad_gb_per_s);
  return facts;
}

double memory_gb_per_s(const Json& facts, bool on_device, std::size_t bytes, int threads) {
  return on_device ? facts.at("device_gb_per_s").get<double>() : triad_gb_per_s(bytes, threads);
}

Json bandwidths(const std::vector<int>& threads, double (*gb_per_s)(std::size_t, int)) {
  Json all;
  for (const int t : threads) all.push_back({{"threads", t}, {"gb_per_s", gb_per_s(kMemoryBytes, t)}});
  return all;
}

std::string bandwidth_line(const Json& facts, const std::string& key, const std::string& name) {
  std::string line = name + ":";
  for (const Json& entry : facts.at(key))
    line += formatted(" %.1f GB/s on ", entry.at("gb_per_s").get<double>()) +
            counted(entry.at("threads").get<int>(), "thread") + ",";
  line.back() = '\n';
  return line;
}

std::string machine_lines(const Json& facts, const std::string& peer) {
  const auto fact = [&facts](const char* key) { return facts.at(key).get<std::string>(); };
  return "malha " + fact("malha_version") + ", " + fact("compiler") + ", " + fact("instructions") + "; " +
         (peer.empty() ? "" : peer + "; ") + fact("cpu") + "\n" +
         bandwidth_line(facts, "triad_gb_per_s", "triad from memory") +
         (facts.contains("device")
              ? "on " + fact("device") +
                    formatted(", which copies at %.0f GB/s\n", facts.at("device_gb_per_s").get<double>())
              : "");
}

}  // namespace malha::bench
