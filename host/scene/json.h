// SPDX-License-Identifier: Apache-2.0
// Strict parser of JSON text to a tree of values: no comments, no duplicate keys, no trailing text. The parsing library
// is included in json.cpp only, because it compiles slowly.
#pragma once
#include <string>
#include <vector>

namespace malha {

struct JsonValue {
  enum class Type { Null, Boolean, Number, Text, List, Object };
  Type type = Type::Null;
  bool boolean = false;
  double number = 0;  // finite
  std::string text;
  std::vector<std::string> keys;  // of an object, unique, in the order of the file
  std::vector<JsonValue> items;   // items of a list, or the value of each key of an object

  /// The value of a key of an object, or nullptr.
  const JsonValue* find(const std::string& key) const;
};

/// Parses JSON text (UTF-8). Throws InputError, which names `file`, the line and the column (in bytes, from 1).
JsonValue parse_json(const std::string& text, const std::string& file);

/// The JSON pointer (RFC 6901) of a key or index below `pointer`.
std::string json_pointer(const std::string& pointer, const std::string& key);

/// A short description of a value for messages: its own text if that is short.
std::string describe(const JsonValue& value);

}  // namespace malha
