// SPDX-License-Identifier: Apache-2.0
#include "host/mesh/io/mesh_scan.h"

#include <charconv>
#include <cmath>

#include "malha/error.h"
#include "malha/text.h"

namespace malha {
namespace {

bool is_blank(char letter) { return letter == ' ' || letter == '\t' || letter == '\v' || letter == '\f'; }

std::string_view without_plus(std::string_view word) {
  return word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
}

// Parses the whole word as a number. Returns false if it is not one.
template <class Number>
bool parse(std::string_view word, Number& value) {
  word = without_plus(word);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  return error == std::errc{} && stop == end;
}

}  // namespace

bool to_integer(std::string_view word, long long& value) { return parse(word, value); }

TextScanner::TextScanner(const std::string& file, std::string_view text, char comment, bool continues)
    : file_(file), text_(text), comment_(comment), continues_(continues) {
  if (text_.starts_with("\xEF\xBB\xBF")) next_ = 3;  // skip a byte order mark
}

void TextScanner::read_line() {
  ++line_;
  line_start_ = word_start_ = word_end_ = line_end_ = next_;
  while (next_ < text_.size() && text_[next_] != '\n' && text_[next_] != '\r') ++next_;
  line_end_ = next_;
  if (text_.substr(next_, 2) == "\r\n") {
    next_ += 2;
  } else if (next_ < text_.size()) {
    ++next_;
  }
  if (comment_ != '\0') {
    const std::size_t cut = text_.substr(line_start_, line_end_ - line_start_).find(comment_);
    if (cut != std::string_view::npos) line_end_ = line_start_ + cut;
  }
  continued_ = continues_ && line_end_ > line_start_ && text_[line_end_ - 1] == '\\';
  if (continued_) --line_end_;
}

bool TextScanner::next_line() {
  // Skip the unread rest of a continued line.
  while (continued_ && next_ < text_.size()) read_line();
  while (next_ < text_.size()) {
    read_line();
    if (has_word()) return true;
  }
  return false;
}

void TextScanner::refuse_end(const std::string& wanted) const {
  refuse(file_, in_bytes_ ? "byte " + std::to_string(text_.size()) : "line " + std::to_string(line_),
         "the end of the file", wanted);
}

bool TextScanner::has_word() {
  for (;;) {
    std::size_t at = word_end_;
    while (at < line_end_ && is_blank(text_[at])) ++at;
    if (at < line_end_) return true;
    if (!continued_ || next_ >= text_.size()) return false;
    read_line();
  }
}

std::string_view TextScanner::word(const char* wanted) {
  has_word();
  word_start_ = word_end_;
  while (word_start_ < line_end_ && is_blank(text_[word_start_])) ++word_start_;
  word_end_ = word_start_;
  while (word_end_ < line_end_ && !is_blank(text_[word_end_])) ++word_end_;
  if (word_start_ == word_end_) refuse_here("the end of the line", wanted);
  return text_.substr(word_start_, word_end_ - word_start_);
}

std::string_view TextScanner::rest_of_line() {
  while (word_end_ < line_end_ && is_blank(text_[word_end_])) ++word_end_;
  std::size_t end = line_end_;
  while (end > word_end_ && is_blank(text_[end - 1])) --end;
  word_start_ = word_end_, word_end_ = line_end_;
  return text_.substr(word_start_, end - word_start_);
}

double TextScanner::real(const char* wanted) {
  const std::string_view text = word(wanted);
  double value = 0;
  if (!parse(text, value) || !std::isfinite(value))
    refuse_word(text, std::string(wanted) + ", a finite number in the range of double");
  return value;
}

long long TextScanner::integer(const char* wanted) {
  const std::string_view text = word(wanted);
  long long value = 0;
  if (!to_integer(text, value)) refuse_word(text, std::string(wanted) + ", an integer");
  return value;
}

long long TextScanner::count(const char* wanted, long long bytes_each) {
  const long long count = integer(wanted);
  const long long most = (static_cast<long long>(text_.size() - word_end_) + 1) / bytes_each;
  if (count < 0 || count > most) {
    refuse_here(std::to_string(count) + " as " + wanted,
                "0 to " + std::to_string(most) + ", as many as the rest of the file can hold");
  }
  return count;
}

void TextScanner::require_end_of_line(const std::string& what) {
  if (has_word()) refuse_word(word(""), what + " and then the end of the line");
}

void TextScanner::seek(std::size_t byte) {
  next_ = line_start_ = line_end_ = word_start_ = word_end_ = byte;
  continued_ = false, in_bytes_ = true;
}

std::string TextScanner::place() const {
  if (in_bytes_) return "byte " + std::to_string(word_start_);
  return "line " + std::to_string(line_) + ", column " + std::to_string(word_start_ - line_start_ + 1);
}

void TextScanner::refuse_word(std::string_view word, const std::string& allowed) const {
  refuse_here(quoted(word), allowed);
}

void TextScanner::refuse_here(const std::string& found, const std::string& allowed) const {
  refuse(file_, place(), found, allowed);
}

ByteScanner::ByteScanner(const std::string& file, std::string_view data, std::size_t start, std::endian order)
    : file_(file), data_(data), next_(start), value_at_(start), swap_(order != std::endian::native) {}

void ByteScanner::refuse_end(const std::string& wanted) const {
  refuse(file_, "byte " + std::to_string(next_), "the end of the file after " + std::to_string(bytes_left()) + " bytes",
         wanted);
}

void ByteScanner::refuse_value(const std::string& found, const std::string& allowed) const {
  refuse(file_, "byte " + std::to_string(value_at_), found, allowed);
}

}  // namespace malha
