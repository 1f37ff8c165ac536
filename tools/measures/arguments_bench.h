// SPDX-License-Identifier: Apache-2.0
// The words and options after "malha bench".
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
  std::function<void()> run;  // the benchmark that was named
  bench::ConstraintOptions of_constraints;
  bench::ProjectionOptions of_projection;
  bench::FilterOptions of_filter;
  bench::SelfOptions of_self;
  bench::ContactOptions of_contact;
};

void add_bench(CLI::App& app, BenchArguments& arguments);

/// The line that refuses `word` (null: none) where a benchmark should be named; empty where it is one, or asks for
/// help.
std::string refused_benchmark(const char* word);

}  // namespace malha
