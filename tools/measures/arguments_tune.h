// SPDX-License-Identifier: Apache-2.0
// The words and options after "malha tune".
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
  std::optional<double> seconds;  // simulated
  std::string json;               // empty: no such file
};

void add_tune(CLI::App& app, Arguments& arguments);

}  // namespace malha
