// The words and options after "malha tune".
#pragma once
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace malha {

struct TuneArguments {
  double error = 0;               // m
  std::optional<double> seconds;  // simulated
  std::string json;               // empty: no such file
};

/// Without SCENE, --threads and --out, which other commands have too.
CLI::App* add_tune(CLI::App& app, TuneArguments& tune);

}  // namespace malha
