// SPDX-License-Identifier: Apache-2.0
// The subcommands tune, bench and study. They take as long to compile as all the rest, so they are in a program of
// their own, malha_measures, which the command executes for them. Both programs share all files except the
// implementations of these functions: tools/hand_over.cpp is the command's, tools/measures/ the other program's.
#pragma once
#include <atomic>
#include <optional>

namespace CLI {
class App;
}

namespace malha {

struct Arguments;

inline constexpr const char* kTuneHelp = "Find the cheapest method and settings for an error given in metres";
inline constexpr const char* kBenchHelp =
    "Time malha, compared with other libraries and with the limits of this machine";
inline constexpr const char* kStudyHelp = "Measure methods and draw charts: error over cost, stability, scaling";

/// In the command: executes the program that implements the subcommand, malha_measures or malha_view, and returns an
/// exit status only if that fails. In malha_measures: returns an exit status if the words after bench or study name
/// none. In both cases one line on standard error says why.
std::optional<int> exec_or_refuse(int argc, char** argv);

/// Adds the three subcommands to the parser and to its help.
void add_measures(CLI::App& app, Arguments& arguments);

/// Runs the subcommand and returns the exit status. Throws study::Interrupted once `stop` is set.
int measure(const Arguments& arguments, const std::atomic<bool>& stop);

}  // namespace malha
