// SPDX-License-Identifier: Apache-2.0
// Text and bytes read with their place in mind, so that a refusal can name it.
#pragma once
#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace malha {

/// Text, a line at a time, a word at a time. Lines end in \n, \r\n or \r; words are separated by blanks.
class TextScanner {
 public:
  /// `comment` starts a comment that runs to the end of its line; '\0': the format has none.
  /// `continues`: a line whose last character is a backslash goes on with the next.
  TextScanner(const std::string& file, std::string_view text, char comment = '\0', bool continues = false);

  /// Moves on to the next line that is not blank; false at the end of the text.
  bool next_line();
  bool has_word();                                        ///< on this line, or on those that continue it
  bool find_word() { return has_word() || next_line(); }  ///< on this line or a later one, in formats without lines
  std::string_view word(const char* wanted);              ///< refuses the end of the line
  double real(const char* wanted);                        ///< a finite number, or refused
  long long integer(const char* wanted);                  ///< a whole number, or refused
  void require_end_of_line(const std::string& what);      ///< refuses further words; `what` says what the line may hold
  /// A number of items; refused where the text ahead has no room for them, so that it is safe to allocate.
  long long count(const char* wanted, long long bytes_each);

  std::size_t line() const { return line_; }    ///< the number of this line, from 1
  std::size_t offset() const { return next_; }  ///< byte at which the next line starts
  /// Takes the next line from there, behind what is no text. No lines are counted from then on: places are bytes.
  void go_on_at(std::size_t byte);
  std::size_t bytes_left() const { return text_.size() - next_; }
  std::string place() const;  ///< "line 3, column 7" or "byte 70": of the last word, or of the line's end
  [[noreturn]] void refuse_word(std::string_view word, const std::string& allowed) const;
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const;
  /// Refuses the end of the file: `wanted` says what should have come, e.g. "vertex 3 (0-based) of 8".
  [[noreturn]] void refuse_end(const std::string& wanted) const;

 private:
  void take_line();

  std::string file_;
  std::string_view text_;
  char comment_;
  bool continues_, goes_on_ = false, in_bytes_ = false;
  std::size_t line_ = 0, line_start_ = 0, line_end_ = 0, next_ = 0;
  std::size_t word_start_ = 0, word_end_ = 0;
};

/// The whole of `word` as a number; false where it is not one.
bool to_integer(std::string_view word, long long& value);

/// Bytes from front to back. The caller sees to it that enough are left.
class ByteScanner {
 public:
  ByteScanner(const std::string& file, std::string_view data, std::size_t start, std::endian order);

  std::size_t bytes_left() const { return data_.size() - next_; }
  std::size_t offset() const { return next_; }
  void skip(std::size_t bytes) { next_ += bytes; }

  template <class T>
  T get() {
    char raw[sizeof(T)];
    std::memcpy(raw, data_.data() + next_, sizeof(T));
    if (swap_) std::reverse(raw, raw + sizeof(T));
    next_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  /// Refuses the end of the file, as above.
  [[noreturn]] void refuse_end(const std::string& wanted) const;

 private:
  std::string file_;
  std::string_view data_;
  std::size_t next_;
  bool swap_;
};

}  // namespace malha
