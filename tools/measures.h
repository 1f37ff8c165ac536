// SPDX-License-Identifier: Apache-2.0
// What measures malha: tune, bench and study. They take as long to compile as all the rest, so they are a program of
// their own, malha_measures, which the command becomes when one of them is asked for. Both programs share all files
// but those with these functions: tools/hand_over.cpp has the command's, tools/measures/ the other one's.
#pragma once
#include <atomic>
#include <optional>

namespace CLI {
class App;
}

namespace malha {

struct Arguments;

inline constexpr const char* kTuneHelp = "Find the cheapest method and settings that reach an error here";
inline constexpr const char* kBenchHelp = "Time malha beside other libraries and the machine's limits";
inline constexpr const char* kStudyHelp = "Measure and chart methods: error against cost, stability, scaling";

/// Of the command: becomes the program that does what argv asks for, malha_measures or malha_view; gives the exit
/// status where that cannot be. Of malha_measures: gives it where the words after bench or study name none. One line on
/// standard error says why.
std::optional<int> hand_over_or_refuse(int argc, char** argv);

/// Adds the three to what is understood, and to the help.
void add_measures(CLI::App& app, Arguments& arguments);

/// Runs the one that was asked for; gives the exit status. Throws study::Interrupted where `stop` is set.
int measure(const Arguments& arguments, const std::atomic<bool>& stop);

}  // namespace malha
