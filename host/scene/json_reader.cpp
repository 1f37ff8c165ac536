// SPDX-License-Identifier: Apache-2.0
#include "host/scene/json_reader.h"

#include <algorithm>
#include <cmath>

#include "host/base/spelling_suggestion.h"
#include "malha/error.h"

namespace malha {
namespace {

std::string digits(double number) { return describe(JsonValue(number)); }

std::vector<std::string> keys_of(const std::vector<JsonReader::Field>& fields) {
  std::vector<std::string> keys;
  for (const auto& field : fields) keys.push_back(field.key);
  return keys;
}

}  // namespace

Interval any(const std::string& unit) { return {.unit = unit}; }
Interval above(double min, const std::string& unit) { return {.min = min, .min_included = false, .unit = unit}; }
Interval at_least(double min, const std::string& unit) { return {.min = min, .unit = unit}; }
Interval between(double min, double max, const std::string& unit) { return {.min = min, .max = max, .unit = unit}; }

std::string describe(const Interval& range) {
  std::string text = "a number";
  if (std::isfinite(range.min) && std::isfinite(range.max)) {
    text += std::string(" in ") + (range.min_included ? "[" : "(") + digits(range.min) + ", " + digits(range.max) + "]";
  } else if (std::isfinite(range.min)) {
    text += (range.min_included ? " >= " : " > ") + digits(range.min);
  }
  return text + (range.unit.empty() ? "" : " (" + range.unit + ")");
}

std::string describe(const Integers& range) {
  return "an integer in [" + std::to_string(range.min) + ", " + std::to_string(range.max) + "]";
}

JsonReader::JsonReader(const JsonValue& value, const std::string& file, const std::string& pointer, ErrorList* errors)
    : value_(&value), file_(file), pointer_(pointer), errors_(errors) {}

void JsonReader::refuse(const std::string& found, const std::string& allowed) const {
  malha::refuse(file_, pointer_, found, allowed);
}

void JsonReader::refuse_value(const std::string& allowed) const { refuse(describe(*value_), allowed); }

bool JsonReader::has(const std::string& key) const { return value_->contains(key); }

JsonReader JsonReader::child(const JsonValue& item, const std::string& key) const {
  return JsonReader(item, file_, json_pointer(pointer_, key), errors_);
}

JsonReader JsonReader::at(const std::string& key) const {
  if (!value_->is_object()) refuse_value("an object with the key '" + key + "'");
  const JsonValue* found = value_->find(key);
  if (found == nullptr) refuse("no key '" + key + "'", "an object with the key '" + key + "'");
  return child(*found, key);
}

void JsonReader::collect(const std::function<void()>& read) const {
  if (errors_ == nullptr)
    read();
  else
    errors_->collect(read);
}

bool JsonReader::has_only(const std::vector<Field>& fields) const {
  const std::vector<std::string> allowed = keys_of(fields);
  if (!value_->is_object()) refuse_value("an object with the keys " + join(allowed));
  bool all = true;
  for (const JsonValue::Member& member : value_->members()) {
    const std::string& key = member.key;
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    all = false;
    collect([&] { at(key).refuse("unknown key '" + key + "'" + did_you_mean(key, allowed), join(allowed)); });
  }
  return all;
}

void JsonReader::object(const std::vector<Field>& fields) const {
  const std::size_t before = errors_ == nullptr ? 0 : errors_->count();
  const bool known = has_only(fields);
  for (const Field& field : fields)
    if (has(field.key) || (field.required && known))  // a missing key may be a misspelt one, which is already reported
      collect([&] { field.read(at(field.key)); });
  if (errors_ != nullptr && errors_->count() > before) ErrorList::end_part();
}

void JsonReader::for_each(const std::function<void(const JsonReader&)>& read) const {
  const std::size_t before = errors_ == nullptr ? 0 : errors_->count();
  for (const JsonReader& item : list()) collect([&] { read(item); });
  if (errors_ != nullptr && errors_->count() > before) ErrorList::end_part();
}

void JsonReader::one_of(const std::vector<Field>& fields, const std::vector<Field>& optional) const {
  std::vector<Field> all = fields;
  all.insert(all.end(), optional.begin(), optional.end());
  if (!has_only(all)) ErrorList::end_part();
  std::vector<std::string> found;
  for (const JsonValue::Member& member : value_->members())
    if (std::any_of(fields.begin(), fields.end(), [&](const Field& field) { return field.key == member.key; }))
      found.push_back(member.key);
  if (found.size() != 1) {
    const std::string none = value_->empty() ? "an empty object" : "none of these keys";
    refuse(found.empty() ? none : join(found), "exactly one of " + join(keys_of(fields)));
  }
  object(all);
}

double JsonReader::number(const Interval& range) const {
  if (!value_->is_number()) refuse_value(describe(range));
  const double x = value_->number();
  const bool fits = range.min_included ? x >= range.min : x > range.min;
  if (!fits || x > range.max) refuse_value(describe(range));
  const bool too_small = !range.min_included && range.min == 0 && x < 1 / largest_number;
  if (std::abs(x) > largest_number || too_small) {
    refuse_value(describe(range) + ", of a magnitude between " + digits(1 / largest_number) + " and " +
                 digits(largest_number));
  }
  return x;
}

int JsonReader::integer(const Integers& range) const {
  const double x = value_->is_number() ? value_->number() : range.min - 0.5;
  const bool fits = x == std::floor(x) && x >= range.min && x <= range.max;
  if (!fits) refuse_value(describe(range));
  return static_cast<int>(x);
}

std::string JsonReader::text() const {
  const std::string t = value_->is_string() ? value_->text() : "";
  const bool one_line = std::none_of(t.begin(), t.end(), [](unsigned char c) { return c < ' ' || c == 127; });
  if (t.empty() || !one_line) refuse_value("a non-empty string of one line");
  return t;
}

bool JsonReader::boolean() const {
  if (!value_->is_boolean()) refuse_value("true or false");
  return value_->boolean();
}

std::string JsonReader::choice(const std::string& what, const std::vector<std::string>& allowed) const {
  const std::string found = value_->is_string() ? value_->text() : "";
  if (std::find(allowed.begin(), allowed.end(), found) != allowed.end()) return found;
  if (!value_->is_string()) refuse_value("one of " + join(allowed));
  refuse("unknown " + what + " " + describe(*value_) + did_you_mean(found, allowed), join(allowed));
}

std::vector<std::string> JsonReader::choices(const std::string& what, const std::vector<std::string>& allowed) const {
  std::vector<std::string> found;
  if (!value_->is_array() || value_->empty()) refuse_value("a list of " + join(allowed));
  for (const JsonReader& item : list()) {
    found.push_back(item.choice(what, allowed));
    if (std::count(found.begin(), found.end(), found.back()) > 1) {
      item.refuse("'" + found.back() + "' a second time", "each once");
    }
  }
  return found;
}

std::vector<JsonReader> JsonReader::list() const {
  if (!value_->is_array()) refuse_value("a list");
  std::vector<JsonReader> items;
  for (const JsonValue& item : value_->items()) items.push_back(child(item, std::to_string(items.size())));
  return items;
}

std::vector<JsonReader> JsonReader::list_of(std::size_t length, const std::string& each) const {
  if (!value_->is_array() || value_->size() != length) {
    refuse_value("a list of " + std::to_string(length) + ", each " + each);
  }
  return list();
}

}  // namespace malha
