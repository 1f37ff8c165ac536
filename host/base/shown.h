// Words and numbers as messages show them.
#pragma once
#include <sstream>
#include <string>
#include <string_view>

namespace malha {

/// A word from a file: in quotes, at most 40 characters, all printable.
inline std::string quoted(std::string_view word) {
  std::string text = "\"";
  for (const char letter : word.substr(0, 40)) text += letter >= ' ' && letter <= '~' ? letter : '?';
  return text + (word.size() > 40 ? "...\"" : "\"");
}

/// A number to six digits.
inline std::string shown(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// "1 body", "2 bodies"; `several` is `one` with an s where it is not given.
template <class Count>
std::string counted(Count count, const std::string& one, const std::string& several = "") {
  return std::to_string(count) + " " + (count == 1 ? one : several.empty() ? one + "s" : several);
}

}  // namespace malha
