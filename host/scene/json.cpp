// SPDX-License-Identifier: Apache-2.0
#include "host/scene/json.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>

#include "malha/error.h"

namespace malha {
namespace {

constexpr std::size_t max_depth =
    64;  // the tree is destroyed recursively, so that its depth bounds the use of the stack

std::string line_and_column(const std::string& text, std::size_t offset) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size()));
  const auto line = 1 + std::count(text.begin(), end, '\n');
  const auto line_start = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  return "line " + std::to_string(line) + ", column " + std::to_string(1 + (end - line_start));
}

// Iterator over the text that stores its position for the parse events, which have none.
class TrackedText {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TrackedText(const char* at, const char** place) : at_(at), place_(place) {}
  reference operator*() const { return *at_; }
  TrackedText& operator++() {
    *place_ = ++at_;
    return *this;
  }
  bool operator==(const TrackedText& other) const { return at_ == other.at_; }
  bool operator!=(const TrackedText& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** place_;
};

// Builds the tree from nlohmann's parse events. open_ is the path from the root to the container that is being filled.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(const std::string& text, const std::string& file) : text_(text), file_(file), place_(text.data()) {}

  const char** place() { return &place_; }
  JsonValue take() { return std::move(root_); }

  bool null() override { return add({}); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override {
    return value <= INT64_MAX ? add(value) : add(static_cast<double>(value));
  }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }  // never in JSON text

  bool start_object(std::size_t) override { return open(JsonValue::object()); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(JsonValue::array()); }
  bool end_array() override { return close(); }

  bool key(string_t& key) override {
    if (open_.back()->contains(key)) {
      refuse(file_, line_and_column(text_, start_of_string()), "the key '" + key + "' a second time in one object",
             "each key once");
    }
    if (std::any_of(key.begin(), key.end(), [](unsigned char c) { return c < ' '; })) {
      refuse(file_, line_and_column(text_, start_of_string()), "a key with a control character", "keys of one line");
    }
    key_ = std::move(key);
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    // The message of the library is "[...] ... - FOUND; expected EXPECTED"; the last part may be missing.
    std::string found = error.what();
    const std::size_t dash = found.find(" - ");
    found = found.substr(dash != std::string::npos ? dash + 3 : found.find("] ") + 2);
    std::string allowed = "JSON with finite numbers";
    const std::string separator = "; expected ";
    if (const std::size_t cut = found.rfind(separator); cut != std::string::npos) {
      allowed = found.substr(cut + separator.size());
      found.resize(cut);
    }
    constexpr std::size_t max_length = 120;  // the library repeats the whole string in which the error is
    if (found.size() > max_length) found = found.substr(0, max_length) + "...";
    const std::size_t at = position == 0 ? 0 : position - 1;
    refuse(file_, line_and_column(text_, at), found, allowed + dialect_hint(at));
  }

 private:
  /// A hint about syntax of other JSON dialects.
  std::string dialect_hint(std::size_t at) const {
    if (at >= text_.size()) return "";
    if (text_[at] == '/' || text_[at] == '#') return "; strict JSON has no comments";
    if (text_[at] != '}' && text_[at] != ']') return "";
    const std::size_t before = at == 0 ? std::string::npos : text_.find_last_not_of(" \t\r\n", at - 1);
    const bool trailing_comma = before != std::string::npos && text_[before] == ',';
    return trailing_comma ? "; strict JSON has no comma after the last item" : "";
  }
  bool add(JsonValue value) {
    if (open_.empty())
      last_ = &(root_ = std::move(value));
    else if (open_.back()->is_array())
      last_ = &open_.back()->push_back(std::move(value));
    else
      last_ = &((*open_.back())[key_] = std::move(value));
    return true;
  }
  bool open(JsonValue container) {
    if (open_.size() >= max_depth) {
      refuse(file_, line_and_column(text_, static_cast<std::size_t>(place_ - text_.data()) - 1),
             "more than " + std::to_string(max_depth) + " levels of brackets", std::to_string(max_depth) + " levels");
    }
    add(std::move(container));
    open_.push_back(last_);  // it stays valid, because only the last item of an open container grows
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }
  // The position of the opening quote of the string that was just read, whose closing quote is the last character
  // consumed.
  std::size_t start_of_string() const {
    std::size_t i = static_cast<std::size_t>(place_ - text_.data()) - 1;
    while (true) {
      i = text_.rfind('"', i - 1);
      std::size_t backslashes = 0;
      while (text_[i - 1 - backslashes] == '\\') ++backslashes;
      if (backslashes % 2 == 0) return i;
    }
  }

  const std::string& text_;
  const std::string& file_;
  const char* place_;
  JsonValue root_;
  JsonValue* last_ = nullptr;  // the value that was added last
  std::string key_;            // of the next value of an object
  std::vector<JsonValue*> open_;
};

}  // namespace

JsonValue parse_json(const std::string& text, const std::string& file) {
  TreeBuilder builder(text, file);
  const char* begin = text.data();
  nlohmann::json::sax_parse(TrackedText(begin, builder.place()), TrackedText(begin + text.size(), builder.place()),
                            &builder);
  return builder.take();
}

}  // namespace malha
