// SPDX-License-Identifier: Apache-2.0
// Command line of "malha tune".
#pragma once
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace malha {

struct Arguments;

struct TuneArguments {
  double error = 0;               // m
  std::optional<double> seconds;  // simulated time
  std::string json;               // path of the JSON output; empty: none
};

void add_tune(CLI::App& app, Arguments& arguments);

}  // namespace malha
