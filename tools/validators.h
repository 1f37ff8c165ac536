// SPDX-License-Identifier: Apache-2.0
// Validators of options, whose messages say what was found and what is allowed.
#pragma once
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host/base/spelling_suggestion.h"
#include "host/model/machine.h"
#include "malha/simulation.h"
#include "malha/text.h"

namespace malha {

/// Parses a text; returns whether all of it is a number of this type.
template <class T>
bool reads(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// "found TEXT; allowed: ALLOWED"
inline std::string found(const std::string& text, const std::string& allowed) {
  return "found " + malha::quoted(text) + "; allowed: " + allowed;
}

/// A whole number in [low, high].
inline CLI::Validator whole_number(std::int64_t low, std::int64_t high) {
  return {[low, high](const std::string& text) {
            std::int64_t value = 0;
            if (reads(text, value) && low <= value && value <= high) return std::string();
            return found(text, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
          },
          ""};
}

/// A finite number > 0.
inline CLI::Validator above_zero(const std::string& unit) {
  return {[unit](const std::string& text) {
            double value = 0;
            return reads(text, value) && std::isfinite(value) && value > 0 ? ""
                                                                           : found(text, "a number > 0 (" + unit + ")");
          },
          ""};
}

/// A finite number >= 0.
inline CLI::Validator at_least_zero(const std::string& unit) {
  return {[unit](const std::string& text) {
            double value = 0;
            return reads(text, value) && std::isfinite(value) && value >= 0
                       ? ""
                       : found(text, "a number >= 0 (" + unit + ")");
          },
          ""};
}

/// A duration in seconds, > 0.
inline CLI::Validator duration() { return above_zero("s"); }

/// A path of a file or folder that may not exist yet.
inline CLI::Validator some_path() {
  return {[](const std::string& text) { return text.empty() ? found(text, "a path, not empty") : ""; }, ""};
}

/// One of `words`, which have no blanks. The name of the validator lists them, for tools/completion.h.
inline CLI::Validator one_of(const std::vector<std::string>& words) {
  std::string name;
  for (const std::string& word : words) name += word + " ";
  return {[words](const std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            return "found " + malha::quoted(text) + did_you_mean(text, words) + "; allowed: " + join(words);
          },
          "", name};
}

/// Returns the message that refuses `word`, or its absence, if it is not one of `words`; empty if it is. `what`: what
/// the words name, as "benchmark".
inline std::string refused_word(const std::string& command, const char* word, const std::string& what,
                                const std::vector<std::string>& words) {
  if (word && std::find(words.begin(), words.end(), word) != words.end()) return "";
  return command + ": found " + (word ? quoted(word) + did_you_mean(word, words) : "no " + what) +
         "; allowed: " + join(words);
}

/// Adds an option with a validator. `type`: the name of its value in the help.
template <class T>
CLI::Option* add_checked(CLI::App& command, const std::string& name, T& value, const CLI::Validator& check,
                         const std::string& type, const std::string& help) {
  return command.add_option(name, value, help)->check(check)->type_name(type);
}

/// Adds an option of several values, separated by commas.
template <class T>
void add_list(CLI::App& command, const std::string& name, std::vector<T>& values, const CLI::Validator& check,
              const std::string& help) {
  add_checked(command, name, values, check, "LIST", help)->delimiter(',')->allow_extra_args(false);
}

/// Adds the options of backend and machine.
inline void add_backend(CLI::App& command, std::string& backend, std::string& machine) {
  add_checked(command, "--backend", backend, one_of(kBackends), "NAME",
              "openmp (default), serial, or cuda: a device, in builds that have it");
  add_checked(command, "--for", machine, one_of(machine_names()), "MACHINE",
              "The machine that patches are cut for: cpu (default), a100, h100 or h200");
}

inline void add_threads(CLI::App& command, int& threads,
                        const std::string& help = "Threads; as many as there are cores if not given") {
  add_checked(command, "--threads", threads, whole_number(1, 1024), "N", help);
}

}  // namespace malha
