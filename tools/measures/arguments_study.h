// SPDX-License-Identifier: Apache-2.0
// Command line of "malha study".
#pragma once
#include <string>

#include "tools/study/script.h"

namespace CLI {
class App;
}

namespace malha {

void add_study(CLI::App& app, StudyOptions& options);

/// Returns the message that refuses `word` (null: none) as the name of a study; empty if it is one, or asks for help.
std::string refused_study(const char* word);

}  // namespace malha
