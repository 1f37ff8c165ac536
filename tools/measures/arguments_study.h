// SPDX-License-Identifier: Apache-2.0
// The words and options after "malha study".
#pragma once
#include <string>

#include "tools/study/run.h"

namespace CLI {
class App;
}

namespace malha {

void add_study(CLI::App& app, study::Options& options);

/// The line that refuses `word` (null: none) where a study should be named; empty where it is one, or asks for help.
std::string refused_study(const char* word);

}  // namespace malha
