// SPDX-License-Identifier: Apache-2.0
// What was measured on, and how fast that is.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/bench/runs_on.h"

namespace malha::bench {

/// Build, CPU and cores.
nlohmann::ordered_json build_facts();

/// The same, and the triad from memory on each number of threads; of a device its name and bandwidth.
nlohmann::ordered_json machine_facts(const std::vector<int>& threads, const RunsOn& on = {});

/// What a row's memory can do: of a device as the facts have it, of the host by the triad, now.
double memory_gb_per_s(const nlohmann::ordered_json& facts, bool on_device, std::size_t bytes, int threads);

/// Build and CPU, and then a line of those bandwidths. `peer`: "Bullet 3.24", or nothing.
std::string machine_lines(const nlohmann::ordered_json& facts, const std::string& peer);

/// An entry {threads, gb_per_s} for each number of threads.
nlohmann::ordered_json bandwidths(const std::vector<int>& threads, double (*gb_per_s)(std::size_t bytes, int threads));

/// "triad from memory: 12 GB/s on 1 thread, 25 GB/s on 2 threads\n" from the entries of facts[key].
std::string bandwidth_line(const nlohmann::ordered_json& facts, const std::string& key, const std::string& name);

}  // namespace malha::bench
