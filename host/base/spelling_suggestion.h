// SPDX-License-Identifier: Apache-2.0
// Spelling suggestions ("did you mean"): the allowed word that is closest to a misspelt one.
#pragma once
#include <string>
#include <vector>

namespace malha {

/// The word of `allowed` that takes the fewest edits (insert, delete, replace, swap neighbours; case is ignored) to
/// reach from `word`, where that is close enough to be a slip of the keys; else "".
std::string near_miss(const std::string& word, const std::vector<std::string>& allowed);

/// " (did you mean 'X'?)" where a word of `allowed` is what the field calls by this other word, or where there is a
/// near miss, else "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& allowed);

/// `word` in lower case (ASCII).
std::string lower(std::string word);

/// The words separated by commas: "a, b, c".
std::string join(const std::vector<std::string>& words);

}  // namespace malha
