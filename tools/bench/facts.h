// SPDX-License-Identifier: Apache-2.0
// Description of the machine that ran a benchmark, with its measured bandwidths.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/bench/runs_on.h"

namespace malha::bench {

/// Version and flags of the build, CPU and number of cores.
nlohmann::ordered_json build_facts();

/// build_facts() and the triad's bandwidth from memory on each number of threads; for a device its name and bandwidth.
nlohmann::ordered_json machine_facts(const std::vector<int>& threads, const RunsOn& on = {});

/// Memory bandwidth for a row, in GB/s: a device's from the facts, the host's by a triad that runs now.
double memory_gb_per_s(const nlohmann::ordered_json& facts, bool on_device, std::size_t bytes, int threads);

/// A line of build and CPU, and one of the bandwidths. `peer`: name and version, as "Bullet 3.24"; empty: no peer.
std::string machine_lines(const nlohmann::ordered_json& facts, const std::string& peer);

/// An entry {threads, gb_per_s} for each number of threads.
nlohmann::ordered_json bandwidths(const std::vector<int>& threads, double (*gb_per_s)(std::size_t bytes, int threads));

/// "triad from memory: 12 GB/s on 1 thread, 25 GB/s on 2 threads\n" from the entries of facts[key].
std::string bandwidth_line(const nlohmann::ordered_json& facts, const std::string& key, const std::string& name);

}  // namespace malha::bench
