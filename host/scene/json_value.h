// SPDX-License-Identifier: Apache-2.0
// JSON values in memory. Scenes are checked and written by way of them, also in a build without a parser of JSON text.
#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace malha {

/// A key and its value. It is a template because the value's class needs it before that class is complete.
template <class Value>
struct JsonMember {
  std::string key;
  Value value;
};

/// Null, true or false, a number, a string, a list, or an object whose keys keep their order.
class JsonValue {
 public:
  using Member = JsonMember<JsonValue>;

  JsonValue() = default;
  JsonValue(std::same_as<bool> auto value) : value_(value) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) JsonValue(T value) : value_(static_cast<std::int64_t>(value)) {}
  JsonValue(std::floating_point auto value) : value_(static_cast<double>(value)) {}
  JsonValue(std::string value) : value_(std::move(value)) {}
  JsonValue(const char* value) : value_(std::string(value)) {}
  template <class T>
  JsonValue(const std::vector<T>& items) : value_(list_of(items)) {}
  template <class T, std::size_t N>
  JsonValue(const std::array<T, N>& items) : value_(list_of(items)) {}

  /// An empty list, and an empty object.
  static JsonValue array();
  static JsonValue object();

  bool is_boolean() const { return std::holds_alternative<bool>(value_); }
  bool is_integer() const { return std::holds_alternative<std::int64_t>(value_); }
  bool is_number() const { return is_integer() || std::holds_alternative<double>(value_); }
  bool is_string() const { return std::holds_alternative<std::string>(value_); }
  bool is_array() const { return std::holds_alternative<List>(value_); }
  bool is_object() const { return std::holds_alternative<Members>(value_); }

  /// The value as a C++ type. Throws std::bad_variant_access if it has another one.
  bool boolean() const { return std::get<bool>(value_); }
  double number() const {
    return is_integer() ? static_cast<double>(std::get<std::int64_t>(value_)) : std::get<double>(value_);
  }
  const std::string& text() const { return std::get<std::string>(value_); }
  const std::vector<JsonValue>& items() const { return std::get<List>(value_); }
  const std::vector<Member>& members() const { return std::get<Members>(value_); }

  /// The number of items or members; 0 of any other value.
  std::size_t size() const;
  bool empty() const { return size() == 0; }

  /// The value of a key, or null if it is not an object with that key.
  const JsonValue* find(std::string_view key) const;
  bool contains(std::string_view key) const { return find(key) != nullptr; }
  /// The value of a key, which is added if the object lacks it. Null becomes an object.
  JsonValue& operator[](std::string_view key);
  /// Adds an item to a list, and returns it. Null becomes a list.
  JsonValue& push_back(JsonValue item);
  /// Sets all members of another object.
  void update(const JsonValue& other);

  /// The value as JSON text of one line, or with a line for each item and member, indented by two blanks a level.
  /// Numbers that are not finite are written as null, bytes that are not UTF-8 as U+FFFD.
  std::string line() const;
  std::string indented() const;

 private:
  using List = std::vector<JsonValue>;
  using Members = std::vector<Member>;

  template <class Items>
  static List list_of(const Items& items) {
    List list;
    list.reserve(items.size());
    for (const auto& item : items) list.emplace_back(item);
    return list;
  }
  /// Appends the text. `depth`: of the indentation; none: one line.
  void write(std::string& text, std::optional<std::size_t> depth) const;

  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Members> value_;
};

/// The JSON pointer (RFC 6901) of a key or index below `pointer`.
std::string json_pointer(const std::string& pointer, const std::string& key);

/// A short description of a value for messages: its own text if that is short.
std::string describe(const JsonValue& value);

}  // namespace malha
