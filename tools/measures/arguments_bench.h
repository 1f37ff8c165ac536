// SPDX-License-Identifier: Apache-2.0
// Command line of "malha bench".
#pragma once
#include <functional>
#include <string>

#include "tools/bench/constraints.h"
#include "tools/bench/contact.h"
#include "tools/bench/filter/filter.h"
#include "tools/bench/projection/projection.h"
#include "tools/bench/self/self.h"

namespace CLI {
class App;
}

namespace malha {

struct BenchArguments {
  std::function<void()> run;  // runs the named benchmark
  bench::ConstraintOptions of_constraints;
  bench::ProjectionOptions of_projection;
  bench::FilterOptions of_filter;
  bench::SelfOptions of_self;
  bench::ContactOptions of_contact;
};

void add_bench(CLI::App& app, BenchArguments& arguments);

/// Returns the message that refuses `word` (null: none) as the name of a benchmark; empty if it is one, or asks for
/// help.
std::string refused_benchmark(const char* word);

}  // namespace malha
