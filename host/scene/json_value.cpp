// SPDX-License-Identifier: Apache-2.0
#include "host/scene/json_value.h"

#include <charconv>
#include <cmath>

#include "malha/text.h"

namespace malha {
namespace {

/// The shortest text that is read back as the same number, with a point or an exponent.
std::string text_of(double number) {
  if (!std::isfinite(number)) return "null";
  const double size = std::abs(number);
  const bool fixed = size == 0 || (size >= 1e-4 && size < 1e15);
  char digits[32];
  const auto format = fixed ? std::chars_format::fixed : std::chars_format::scientific;
  std::string text(digits, std::to_chars(digits, digits + sizeof digits, number, format).ptr);
  return text + (text.find_first_of(".e") == std::string::npos ? ".0" : "");
}

/// A string with its quotes.
std::string text_of(const std::string& string) {
  std::string text = "\"";
  for (std::size_t at = 0; at < string.size();) {
    const std::size_t length = utf8_character(string, at).length;
    const char c = string[at];
    if (length == 0)
      text += "\xef\xbf\xbd";
    else if (length > 1)
      text += string.substr(at, length);
    else if (c == '"' || c == '\\')
      text += {'\\', c};
    else if (const std::size_t k = std::string_view("\b\f\n\r\t").find(c); k != std::string_view::npos)
      text += {'\\', "bfnrt"[k]};
    else if (static_cast<unsigned char>(c) < ' ')
      text += "\\u" + hex(static_cast<unsigned char>(c)).substr(12);
    else
      text += c;
    at += length == 0 ? 1 : length;
  }
  return text + "\"";
}

}  // namespace

JsonValue JsonValue::array() {
  JsonValue list;
  list.value_.emplace<List>();
  return list;
}

JsonValue JsonValue::object() {
  JsonValue object;
  object.value_.emplace<Members>();
  return object;
}

std::size_t JsonValue::size() const { return is_array() ? items().size() : is_object() ? members().size() : 0; }

const JsonValue* JsonValue::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  for (const Member& member : members())
    if (member.key == key) return &member.value;
  return nullptr;
}

JsonValue& JsonValue::operator[](std::string_view key) {
  if (const JsonValue* found = find(key)) return const_cast<JsonValue&>(*found);
  if (!is_object()) value_.emplace<Members>();
  return std::get<Members>(value_).emplace_back(Member{std::string(key), {}}).value;
}

JsonValue& JsonValue::push_back(JsonValue item) {
  if (!is_array()) value_.emplace<List>();
  return std::get<List>(value_).emplace_back(std::move(item));
}

void JsonValue::update(const JsonValue& other) {
  for (const Member& member : other.members()) (*this)[member.key] = member.value;
}

void JsonValue::write(std::string& text, std::optional<std::size_t> depth) const {
  const std::optional<std::size_t> inner = depth ? std::optional(*depth + 1) : std::nullopt;
  const auto new_line = [&](std::optional<std::size_t> at) {
    if (at) text += "\n" + std::string(2 * *at, ' ');
  };
  const auto write_all = [&](const auto& all, char open, char close, const auto& write_one) {
    text += open;
    for (const auto& one : all) {
      if (&one != &all.front()) text += ',';
      new_line(inner);
      write_one(one);
    }
    if (!all.empty()) new_line(depth);
    text += close;
  };
  if (is_array())
    write_all(items(), '[', ']', [&](const JsonValue& item) { item.write(text, inner); });
  else if (is_object())
    write_all(members(), '{', '}', [&](const Member& member) {
      text += text_of(member.key) + (depth ? ": " : ":");
      member.value.write(text, inner);
    });
  else if (is_string())
    text += text_of(this->text());
  else if (is_boolean())
    text += boolean() ? "true" : "false";
  else if (is_integer())
    text += std::to_string(std::get<std::int64_t>(value_));
  else if (is_number())
    text += text_of(number());
  else
    text += "null";
}

std::string JsonValue::line() const {
  std::string text;
  write(text, std::nullopt);
  return text;
}

std::string JsonValue::indented() const {
  std::string text;
  write(text, 0);
  return text;
}

std::string json_pointer(const std::string& pointer, const std::string& key) {
  std::string escaped;
  for (const char c : key) {
    if (c == '~') {
      escaped += "~0";
    } else if (c == '/') {
      escaped += "~1";
    } else {
      escaped += c;
    }
  }
  return pointer + "/" + escaped;
}

std::string describe(const JsonValue& value) {
  constexpr std::size_t longest = 60;
  if (value.is_object()) return "an object";
  if (value.is_array()) return "a list of " + std::to_string(value.size());
  if (value.is_number()) {
    const double x = value.number();
    if (x == std::floor(x) && std::abs(x) < 1e15) return std::to_string(static_cast<long long>(x));  // not 1e+05
    char digits[32];
    return std::string(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
  }
  const std::size_t size = value.is_string() ? value.text().size() : 0;
  return size > longest ? "a string of " + std::to_string(size) + " bytes" : value.line();
}

}  // namespace malha
