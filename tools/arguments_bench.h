// The words and options after "malha bench".
#pragma once
#include <string>

#include "tools/bench/projection.h"

namespace CLI {
class App;
}

namespace malha {

void add_bench(CLI::App& app, bench::ProjectionOptions& options);

/// The line that refuses `word` where a benchmark should be named; empty where it is one (or asks for help).
std::string refused_benchmark(const std::string& word);

}  // namespace malha
