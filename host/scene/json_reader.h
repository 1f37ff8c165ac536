// SPDX-License-Identifier: Apache-2.0
// Reader of JSON values with checks of types, ranges and keys. Its errors name the file and the JSON pointer.
#pragma once
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host/scene/error_list.h"
#include "host/scene/json_value.h"

namespace malha {

/// The range of a number, and its unit for messages.
struct Interval {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_included = true;
  std::string unit;  // "" for a ratio
};
/// The range of an integer.
struct Integers {
  int min, max;
};
/// Descriptions of ranges for messages: "a number >= 0 (m)", "an integer in [1, 10]".
std::string describe(const Interval& range);
std::string describe(const Integers& range);
/// Ranges of all numbers, > min, >= min, and [min, max].
Interval any(const std::string& unit);
Interval above(double min, const std::string& unit);
Interval at_least(double min, const std::string& unit);
Interval between(double min, double max, const std::string& unit);

/// The largest magnitude of a number in a scene; numbers that must be > 0 must not be smaller than its inverse. Squares
/// and reciprocals thus stay finite in single precision.
constexpr double largest_number = 1e18;

/// A view of a value in a tree, which must outlive it. Every function throws InputError if the value does not fit.
class JsonReader {
 public:
  /// `errors`, which must outlive the reader too, collects the errors in object(), one_of() and for_each(), so that all
  /// are reported together.
  JsonReader(const JsonValue& value, const std::string& file, const std::string& pointer = "",
             ErrorList* errors = nullptr);

  /// A key that an object may have, the function that reads its value, and the one that writes it into an object.
  struct Field {
    std::string key;
    std::function<void(const JsonReader&)> read;
    bool required = false;
    std::function<void(JsonValue&)> write = {};  // empty: the key is not written
  };
  /// Reads an object with these keys and no others. Unknown keys are refused before missing ones, so that a misspelt
  /// key is named; then the fields are read in the given order. If errors are collected, it reads all fields and then
  /// ends the part if there was an error.
  void object(const std::vector<Field>& fields) const;
  /// Reads an object that has exactly one of these keys, and any of the `optional` ones.
  void one_of(const std::vector<Field>& fields, const std::vector<Field>& optional = {}) const;

  bool has(const std::string& key) const;
  /// The value of a key that the object must have, to be read before object() if it decides which other keys are
  /// allowed.
  JsonReader at(const std::string& key) const;

  bool boolean() const;
  double number(const Interval& range) const;
  int integer(const Integers& range) const;
  /// A non-empty string of one line.
  std::string text() const;
  /// A string that is one of `allowed`; `what` names its meaning in messages.
  std::string choice(const std::string& what, const std::vector<std::string>& allowed) const;
  /// A non-empty list of different strings, each one of `allowed`.
  std::vector<std::string> choices(const std::string& what, const std::vector<std::string>& allowed) const;

  /// The items of a list of any length.
  std::vector<JsonReader> list() const;
  /// Reads the items of a list of any length. If errors are collected, it reads all items.
  void for_each(const std::function<void(const JsonReader&)>& read) const;
  /// The items of a list of this length; `each` describes one.
  std::vector<JsonReader> list_of(std::size_t length, const std::string& each) const;

  /// Throws InputError with the JSON pointer of the value.
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const;
  /// Throws InputError with a description of the value.
  [[noreturn]] void refuse_value(const std::string& allowed) const;

  const JsonValue& value() const { return *value_; }

 private:
  /// Returns false if there are other keys, which are recorded. Without a list of errors it throws for the first one.
  bool has_only(const std::vector<Field>& fields) const;
  /// Calls read(), and records its error if errors are collected.
  void collect(const std::function<void()>& read) const;
  /// The reader of an item of a list or object.
  JsonReader child(const JsonValue& item, const std::string& key) const;

  const JsonValue* value_;
  std::string file_;
  std::string pointer_;
  ErrorList* errors_;
};

}  // namespace malha
