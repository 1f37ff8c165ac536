// SPDX-License-Identifier: Apache-2.0
// Formatting of words and numbers in messages.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

namespace malha {

/// A word from a file in quotes: at most 40 characters, those that are not printable ASCII as '?'.
inline std::string quoted(std::string_view word) {
  std::string text = "\"";
  for (const char letter : word.substr(0, 40)) text += letter >= ' ' && letter <= '~' ? letter : '?';
  return text + (word.size() > 40 ? "...\"" : "\"");
}

/// A character of a UTF-8 text: its number of bytes, 0 where they are not well-formed, and its code point.
struct Utf8Character {
  std::size_t length;
  unsigned code;
};
inline Utf8Character utf8_character(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0u; };
  const unsigned lead = byte(0);
  const std::size_t length = lead < 0x80 ? 1 : lead >> 5 == 0x6 ? 2 : lead >> 4 == 0xe ? 3 : lead >> 3 == 0x1e ? 4 : 0;
  unsigned code = length < 2 ? lead : lead & (0x7fu >> length);
  bool good = length > 0;
  for (std::size_t i = 1; i < length; ++i) good = good && byte(i) >> 6 == 0x2, code = code << 6 | (byte(i) & 0x3f);
  constexpr unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};  // overlong forms could hide a character
  good = good && code >= least[length] && code <= 0x10ffff && !(code >= 0xd800 && code < 0xe000);
  return {good ? length : 0, code};
}

/// A text as one line for terminals. Bytes that are not well-formed UTF-8, control characters and characters that
/// change the direction of writing become '?'.
inline std::string printable(std::string_view text) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const auto [length, code] = utf8_character(text, at);
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0) || (code >= 0x2028 && code < 0x202f) ||
                         (code >= 0x2066 && code < 0x206a) || code == 0xfeff;  // line breaks, changes of direction
    shown += length > 0 && !control ? std::string(text.substr(at, length)) : "?";
    at += length > 0 ? length : 1;
  }
  return shown;
}

/// printable() of each line of a text.
inline std::string printable_lines(std::string_view text) {
  std::string lines;
  for (std::size_t at = 0, end; at < text.size(); at = end + 1) {
    end = std::min(text.find('\n', at), text.size());
    lines += printable(text.substr(at, end - at)) + (end < text.size() ? "\n" : "");
  }
  return lines;
}

/// A number as 16 hexadecimal digits.
inline std::string hex(std::uint64_t value) {
  std::string text(16, '0');
  for (int digit = 15; digit >= 0; --digit, value /= 16) text[digit] = "0123456789abcdef"[value % 16];
  return text;
}

/// A number with this many significant digits.
inline std::string shown(double value, int digits = 6) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

/// A number > 0 rounded to two significant digits.
inline double two_digits(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

/// A count with its noun: "1 body", "2 bodies". If `several` is empty, the plural is `one` with an s.
template <class Count>
std::string counted(Count count, const std::string& one, const std::string& several = "") {
  return std::to_string(count) + " " + (count == 1 ? one : several.empty() ? one + "s" : several);
}

}  // namespace malha
