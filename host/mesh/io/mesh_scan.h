// SPDX-License-Identifier: Apache-2.0
// Scanners of text and bytes that know their position, so that errors can name it.
#pragma once
#include <algorithm>
#include <bit>
#include <cstring>
#include <string>
#include <string_view>

namespace malha {

/// Scans text by lines and words. Lines end in \n, \r\n or \r; words are separated by blanks.
class TextScanner {
 public:
  /// `comment` is the character that starts a comment up to the end of the line; '\0': the format has none. With
  /// `continues`, a line whose last character is a backslash continues on the next line.
  TextScanner(const std::string& file, std::string_view text, char comment = '\0', bool continues = false);

  /// Advances to the next line that is not blank. Returns false at the end of the text.
  bool next_line();
  bool has_word();                                        ///< true if a word follows on this line or its continuation
  bool find_word() { return has_word() || next_line(); }  ///< on this or a later line, for formats without lines
  std::string_view word(const char* wanted);              ///< the next word; throws at the end of the line
  std::string_view rest_of_line();                        ///< all words that are left on this line, as they are
  double real(const char* wanted);                        ///< the next word as a finite number
  long long integer(const char* wanted);                  ///< the next word as an integer
  void require_end_of_line(const std::string& what);  ///< throws if words follow; `what` is what the line may contain
  /// The next word as a number of items; throws if the rest of the text cannot hold them, so that it is safe to
  /// allocate.
  long long count(const char* wanted, long long bytes_each);

  std::size_t line() const { return line_; }    ///< number of this line, from 1
  std::size_t offset() const { return next_; }  ///< byte at which the next line starts
  /// Continues at a byte offset, after binary data. From then on places are bytes, since lines are not counted.
  void seek(std::size_t byte);
  std::size_t bytes_left() const { return text_.size() - next_; }
  std::string place() const;  ///< "line 3, column 7" or "byte 70": of the last word, or of the line's end
  [[noreturn]] void refuse_word(std::string_view word, const std::string& allowed) const;
  [[noreturn]] void refuse_here(const std::string& found, const std::string& allowed) const;
  /// Throws for the end of the file; `wanted` is what should follow, such as "vertex 3 (0-based) of 8".
  [[noreturn]] void refuse_end(const std::string& wanted) const;

 private:
  void read_line();

  std::string file_;
  std::string_view text_;
  char comment_;
  bool continues_, continued_ = false, in_bytes_ = false;
  std::size_t line_ = 0, line_start_ = 0, line_end_ = 0, next_ = 0;
  std::size_t word_start_ = 0, word_end_ = 0;
};

/// Parses the whole word as an integer. Returns false if it is not one.
bool to_integer(std::string_view word, long long& value);

/// Scans bytes.
class ByteScanner {
 public:
  ByteScanner(const std::string& file, std::string_view data, std::size_t start, std::endian order);

  std::size_t bytes_left() const { return data_.size() - next_; }
  std::size_t offset() const { return next_; }
  void skip(std::size_t bytes) { next_ += bytes; }

  /// Begins a value of so many bytes; throws if fewer are left. `wanted()` names the value.
  template <class Wanted>
  void begin_value(std::size_t bytes, const Wanted& wanted) {
    value_at_ = next_;
    if (bytes_left() < bytes) refuse_end(wanted());
  }

  /// The caller must check that enough bytes are left.
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

  /// Throws for the end of the file; `wanted` is what should follow.
  [[noreturn]] void refuse_end(const std::string& wanted) const;
  /// Throws for the last value that was begun.
  [[noreturn]] void refuse_value(const std::string& found, const std::string& allowed) const;

 private:
  std::string file_;
  std::string_view data_;
  std::size_t next_, value_at_;
  bool swap_;
};

}  // namespace malha
