// SPDX-License-Identifier: Apache-2.0
// Completion of command lines. The scripts of the shells (tools/package/completion) ask the program itself, which has
// all commands, options and values in its parser.
#pragma once
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace malha {

/// The first argument of a program that is asked for completions; the command line follows.
inline constexpr const char* kCompleteWord = "__complete";

/// Returns what may stand in place of the last of `words`, which are the words of a command line after the name of
/// `app`. Each line is a word, and after a tab what it means. A folder ends with '/'.
std::vector<std::string> completions(CLI::App& app, std::vector<std::string> words);

/// Prints them.
void print_completions(CLI::App& app, const std::vector<std::string>& words);

}  // namespace malha
