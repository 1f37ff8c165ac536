// SPDX-License-Identifier: Apache-2.0
// Reads one JSON value at a known place, strictly: everything that it refuses names the file and the JSON pointer.
#pragma once
#include <array>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "host/scene/faults.h"
#include "host/scene/json.h"
#include "malha/mesh.h"

namespace malha {

/// The numbers that are allowed at a place, and their unit for the message.
struct Interval {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_included = true;
  std::string unit;  // "" for a ratio
};
Interval any(const std::string& unit);
Interval above(double min, const std::string& unit);
Interval at_least(double min, const std::string& unit);
Interval between(double min, double max, const std::string& unit);

/// No number in a scene may be larger than this, nor a number that must be > 0 smaller than its inverse: squares and
/// reciprocals must stay finite in single precision.
constexpr double largest_number = 1e18;

/// A view of a value in a tree that must outlive it. Every function throws InputError where the value does not fit.
class JsonReader {
 public:
  /// `faults`, which must outlive it too, collects what object(), one_of() and each() refuse, for all faults at once.
  JsonReader(const JsonValue& value, const std::string& file, const std::string& pointer = "",
             Faults* faults = nullptr);

  /// A key that an object may have, and what to do with its value where it has it.
  struct Field {
    std::string key;
    std::function<void(const JsonReader&)> read;
    bool required = false;
  };
  /// Reads an object with these keys and no others. Unknown keys are refused before missing ones, so that a misspelt
  /// key is named; then the fields are read in the order given. Where faults are collected it goes on behind one, and
  /// ends the part that it reads at the last.
  void object(const std::vector<Field>& fields) const;
  /// Reads an object that has exactly one of these keys, and perhaps some of `also`.
  void one_of(const std::vector<Field>& fields, const std::vector<Field>& also = {}) const;

  bool has(const std::string& key) const;
  /// The value of a key that the object must have, ahead of object(): where it decides what other keys are allowed.
  JsonReader at(const std::string& key) const;

  bool boolean() const;
  double number(const Interval& range) const;
  int integer(int min, int max) const;
  std::string text() const;  // not empty, one line
  std::string word(const std::string& what, const std::vector<std::string>& allowed) const;
  std::vector<std::string> words(const std::string& what, const std::vector<std::string>& allowed) const;  // each once

  /// The items of a list of any length.
  std::vector<JsonReader> list() const;
  /// Reads the items of a list of any length; where faults are collected, those behind a fault too.
  void each(const std::function<void(const JsonReader&)>& read) const;
  /// A list of exactly N numbers.
  template <std::size_t N>
  std::array<double, N> numbers(const Interval& range) const {
    std::array<double, N> values{};
    const std::vector<JsonReader> items = list_of(N, describe_range(range));
    for (std::size_t i = 0; i < N; ++i) values[i] = items[i].number(range);
    return values;
  }
  template <std::size_t N>
  std::array<int, N> integers(int min, int max) const {
    std::array<int, N> values{};
    const std::vector<JsonReader> items = list_of(N, describe_integers(min, max));
    for (std::size_t i = 0; i < N; ++i) values[i] = items[i].integer(min, max);
    return values;
  }
  Vec3 vec3(const Interval& range) const { return numbers<3>(range); }

  /// Throws InputError with this place.
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const;
  /// The same; found is the value itself.
  [[noreturn]] void refuse_value(const std::string& allowed) const;

  const JsonValue& value() const { return *value_; }

 private:
  /// Whether there are none; without a collection of faults it refuses the first.
  bool has_only(const std::vector<Field>& fields) const;
  /// Refuses what `read` refuses, or collects it.
  void collect(const std::function<void()>& read) const;
  JsonReader below(std::size_t item) const;
  std::vector<JsonReader> list_of(std::size_t length, const std::string& what) const;
  static std::string describe_range(const Interval& range);
  static std::string describe_integers(int min, int max);

  const JsonValue* value_;
  std::string file_;
  std::string pointer_;
  Faults* faults_;
};

}  // namespace malha
