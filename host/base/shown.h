// Words and numbers as messages show them.
#pragma once
#include <cstdint>
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

/// 16 hexadecimal digits.
inline std::string hex(std::uint64_t value) {
  std::string text(16, '0');
  for (int digit = 15; digit >= 0; --digit, value /= 16) text[digit] = "0123456789abcdef"[value % 16];
  return text;
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
