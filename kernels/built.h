// What a build may be made without. A whole build has everything; tools/without compares it with one that lacks what a
// scene does not use.
#pragma once

#ifndef MALHA_WITHOUT
#define MALHA_WITHOUT ""  // CMake's option of this name: what is left out, with spaces between
#endif

namespace malha {

/// Whether `word` is one of `words`, which have spaces between.
constexpr bool has_word(const char* words, const char* word) {
  for (bool starts = true; *words; starts = *words++ == ' ') {
    int same = 0;
    while (word[same] && words[same] == word[same]) ++same;
    if (starts && !word[same] && (!words[same] || words[same] == ' ')) return true;
  }
  return false;
}

/// Whether this build has it: a constraint by its name in scenes, or a part of the solvers
/// (host/solver/optional_part.h).
constexpr bool built(const char* what) { return !has_word(MALHA_WITHOUT, what); }

}  // namespace malha
