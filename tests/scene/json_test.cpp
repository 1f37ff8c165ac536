// SPDX-License-Identifier: Apache-2.0
#include "host/scene/json.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "host/base/spelling_suggestion.h"
#include "host/scene/scene_fields.h"
#include "tests/refusal.h"

namespace malha {
namespace {

std::string refusal_of_text(const std::string& text) {
  return refusal([&] { parse_json(text, "a.json"); });
}

// The refusal when `read` reads `text` as a value.
template <class Read>
std::string refusal_of_value(const std::string& text, Read&& read) {
  const JsonValue value = parse_json(text, "a.json");
  return refusal([&] { read(JsonReader(value, "a.json", "/x")); });
}

TEST(ParseJson, ReadsEveryKindOfValue) {
  const std::string text = R"({"bé/~":{"c":"\"x\\"},"a":[1,-2.5,1000.0,true,null],"o":{},"l":[]})";
  EXPECT_EQ(parse_json(text, "a.json").line(), text) << "keys keep their order";
}

TEST(ParseJson, NamesLineAndColumnOfASyntaxError) {
  EXPECT_EQ(refusal_of_text("{\n  \"a\": 1,\n}"),
            "a.json: line 3, column 1: found unexpected '}'; allowed: string literal; strict JSON has no comma after "
            "the last item");
  EXPECT_EQ(refusal_of_text("[1 2]"), "a.json: line 1, column 4: found unexpected number literal; allowed: ']'");
}

TEST(ParseJson, NamesTheEndOfATruncatedText) {
  EXPECT_EQ(refusal_of_text("[1,\n 2").find("a.json: line 2, column 3: found unexpected end of input"), 0u);
  EXPECT_EQ(refusal_of_text("").find("a.json: line 1, column 1: found unexpected end of input"), 0u);
}

TEST(ParseJson, RefusesTextAfterTheEnd) {
  EXPECT_EQ(refusal_of_text("{} x").find("a.json: line 1, column 4: found invalid literal"), 0u);
}

TEST(ParseJson, RefusesComments) {
  EXPECT_EQ(refusal_of_text("// a\n{}").find("a.json: line 1, column 1: found invalid literal"), 0u);
}

TEST(ParseJson, RefusesNonFiniteNumbers) {
  EXPECT_EQ(refusal_of_text("[1e999]"),
            "a.json: line 1, column 6: found number overflow parsing '1e999'; allowed: JSON with finite numbers");
  EXPECT_NE(refusal_of_text("[-1e999]").find("number overflow"), std::string::npos);
  EXPECT_NE(refusal_of_text("[NaN]").find("invalid literal"), std::string::npos);
  EXPECT_NE(refusal_of_text("[Infinity]").find("invalid literal"), std::string::npos);
}

TEST(ParseJson, RefusesDuplicateKeysAndNamesTheSecond) {
  EXPECT_EQ(refusal_of_text("{\"a\": 1,\n \"b\": {\"a\": 2},\n  \"a\": 3}"),
            "a.json: line 3, column 3: found the key 'a' a second time in one object; allowed: each key once");
}

TEST(ParseJson, FindsThePlaceOfADuplicateKeyWithEscapedQuotes) {
  EXPECT_EQ(refusal_of_text(R"({"a\"\\": 1, "a\u0022\\": 2})").find("a.json: line 1, column 14: found the key"), 0u);
}

TEST(ParseJson, RefusesKeysThatWouldBreakTheLineOfAMessage) {
  EXPECT_EQ(refusal_of_text("{\"a\\nb\": 1}"),
            "a.json: line 1, column 2: found a key with a control character; allowed: keys of one line");
}

TEST(ParseJson, RefusesDeepNestingInsteadOfOverflowingTheStack) {
  EXPECT_EQ(refusal_of_text(std::string(1000000, '[')),
            "a.json: line 1, column 65: found more than 64 levels of brackets; allowed: 64 levels");
  EXPECT_EQ(refusal_of_text(std::string(64, '[') + std::string(64, ']')), "");
}

TEST(ParseJson, RefusesIllFormedUtf8) {
  EXPECT_NE(refusal_of_text("[\"\xff\"]").find("ill-formed UTF-8"), std::string::npos);
}

/// What the value writes is what nlohmann's writer makes of the same text.
TEST(JsonValue, IsWrittenWithALineForEachItem) {
  const std::string text =
      R"({"a":[1,[],{}],"b":{"c":null,"d":[true,false]},"e":"tab\tquote\"back\\slash\u0001é","f":-0.0,"g":1e+300})";
  const JsonValue value = parse_json(text, "a.json");
  EXPECT_EQ(value.line(), text);
  EXPECT_EQ(value.indented(), nlohmann::ordered_json::parse(text).dump(2));
}

TEST(JsonValue, WritesNumbersThatAreReadBackWithTheSameBits) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20000; ++i) {
    double number = 0;
    const std::uint64_t bits = random();
    std::memcpy(&number, &bits, sizeof number);
    if (!std::isfinite(number)) continue;
    const std::string text = JsonValue(number).line();
    ASSERT_EQ(parse_json(text, "a.json").number(), number) << text;
    ASSERT_NE(text.find_first_of(".e"), std::string::npos) << "a number, not an integer: " << text;
  }
  EXPECT_EQ(JsonValue(0.1).line(), "0.1");
  EXPECT_EQ(JsonValue(100000.0).line(), "100000.0");
  EXPECT_EQ(JsonValue(1e15).line(), "1e+15");
  EXPECT_EQ(JsonValue(std::numeric_limits<double>::infinity()).line(), "null");
  EXPECT_EQ(JsonValue(true).line(), "true");
  EXPECT_EQ(JsonValue(std::size_t{3}).line(), "3");
  EXPECT_EQ(JsonValue(std::array{1.5, 2.0}).line(), "[1.5,2.0]");
}

TEST(JsonValue, ReplacesBytesThatAreNotUtf8) {
  EXPECT_EQ(JsonValue("a\xff\xc3(z").line(), "\"a\xef\xbf\xbd\xef\xbf\xbd(z\"");
}

TEST(JsonValue, KeepsTheOrderOfKeysAndReplacesTheirValues) {
  JsonValue value;
  value["b"] = 1, value["a"]["c"] = "x", value["b"] = 2;
  value["list"].push_back(1), value["list"].push_back("two");
  JsonValue more;
  more["a"] = 3, more["d"] = std::vector<std::string>{};
  value.update(more);
  EXPECT_EQ(value.line(), R"({"b":2,"a":3,"list":[1,"two"],"d":[]})");
  EXPECT_EQ(value.find("e"), nullptr);
}

TEST(JsonPointer, EscapesSlashAndTilde) { EXPECT_EQ(json_pointer("/a", "b/c~d"), "/a/b~1c~0d"); }

TEST(SpellingSuggestion, FindsATypo) {
  const std::vector<std::string> words{"distance", "distance_limit", "bending", "mass"};
  EXPECT_EQ(near_miss("distanse", words), "distance");
  EXPECT_EQ(near_miss("distance_limt", words), "distance_limit");
  EXPECT_EQ(near_miss("Bneding", words), "bending");
  EXPECT_EQ(near_miss("mas", words), "mass");
}

TEST(SpellingSuggestion, FindsNothingInAnotherWord) {
  EXPECT_EQ(near_miss("volume", {"distance", "mass"}), "");
  EXPECT_EQ(near_miss("", {"a"}), "");
  EXPECT_EQ(near_miss("x", {"y"}), "");  // one edit, but no letter of the word is left
}

TEST(JsonReader, RefusesAnUnknownKeyBeforeAMissingOne) {
  const auto read = [](const JsonReader& at) {
    at.object({{"mass", [](const JsonReader&) {}, true}, {"name", [](const JsonReader&) {}}});
  };
  EXPECT_EQ(refusal_of_value(R"({"mas": 1})", read),
            "a.json: /x/mas: found unknown key 'mas' (did you mean 'mass'?); allowed: mass, name");
  EXPECT_EQ(refusal_of_value("{}", read), "a.json: /x: found no key 'mass'; allowed: an object with the key 'mass'");
  EXPECT_EQ(refusal_of_value("3", read), "a.json: /x: found 3; allowed: an object with the keys mass, name");
}

TEST(JsonReader, RefusesMoreOrLessThanOneAlternative) {
  const auto read = [](const JsonReader& at) {
    at.one_of({{"a", [](const JsonReader&) {}}, {"b", [](const JsonReader&) {}}});
  };
  EXPECT_EQ(refusal_of_value("{}", read), "a.json: /x: found an empty object; allowed: exactly one of a, b");
  EXPECT_EQ(refusal_of_value(R"({"a": 1, "b": 2})", read), "a.json: /x: found a, b; allowed: exactly one of a, b");
  EXPECT_EQ(refusal_of_value(R"({"b": 2})", read), "");
}

TEST(JsonReader, RefusesNumbersOutOfRange) {
  const auto positive = [](const JsonReader& at) { at.number(above(0, "kg")); };
  EXPECT_EQ(refusal_of_value("0", positive), "a.json: /x: found 0; allowed: a number > 0 (kg)");
  EXPECT_EQ(refusal_of_value("1e-300", positive),
            "a.json: /x: found 1e-300; allowed: a number > 0 (kg), of a magnitude between 1e-18 and 1e+18");
  EXPECT_EQ(refusal_of_value("\"1\"", positive), "a.json: /x: found \"1\"; allowed: a number > 0 (kg)");
  const auto ratio = [](const JsonReader& at) { at.number(between(0, 1, "")); };
  EXPECT_EQ(refusal_of_value("1.5", ratio), "a.json: /x: found 1.5; allowed: a number in [0, 1]");
  EXPECT_EQ(refusal_of_value("1", ratio), "");
  const auto length = [](const JsonReader& at) { at.number(any("m")); };
  EXPECT_EQ(refusal_of_value("-1e39", length),
            "a.json: /x: found -1e+39; allowed: a number (m), of a magnitude between 1e-18 and 1e+18");
  EXPECT_EQ(refusal_of_value("0", length), "");
}

TEST(JsonReader, RefusesFractionsAsIntegers) {
  const auto count = [](const JsonReader& at) { at.integer({1, 10}); };
  EXPECT_EQ(refusal_of_value("2.5", count), "a.json: /x: found 2.5; allowed: an integer in [1, 10]");
  EXPECT_EQ(refusal_of_value("11", count), "a.json: /x: found 11; allowed: an integer in [1, 10]");
  EXPECT_EQ(refusal_of_value("true", count), "a.json: /x: found true; allowed: an integer in [1, 10]");
  EXPECT_EQ(refusal_of_value("10.0", count), "");
}

TEST(JsonReader, RefusesListsOfAnotherLength) {
  const auto vector = [](const JsonReader& at) {
    Vec3 point;
    read_into(point, at, any("m"));
  };
  EXPECT_EQ(refusal_of_value("[1, 2]", vector),
            "a.json: /x: found a list of 2; allowed: a list of 3, each a number (m)");
  EXPECT_EQ(refusal_of_value("[1, 2, null]", vector), "a.json: /x/2: found null; allowed: a number (m)");
}

TEST(JsonReader, RefusesUnknownAndRepeatedWords) {
  const auto words = [](const JsonReader& at) { at.choices("colour", {"red", "green"}); };
  EXPECT_EQ(refusal_of_value("[\"gren\"]", words),
            "a.json: /x/0: found unknown colour \"gren\" (did you mean 'green'?); allowed: red, green");
  EXPECT_EQ(refusal_of_value("[\"red\", \"red\"]", words),
            "a.json: /x/1: found 'red' a second time; allowed: each once");
  EXPECT_EQ(refusal_of_value("[]", words), "a.json: /x: found a list of 0; allowed: a list of red, green");
  EXPECT_EQ(refusal_of_value("[1]", words), "a.json: /x/0: found 1; allowed: one of red, green");
}

TEST(JsonReader, KeepsEveryMessageOnOneLine) {
  const auto text = [](const JsonReader& at) { at.text(); };
  EXPECT_EQ(refusal_of_value("\"a\\nb\"", text),
            "a.json: /x: found \"a\\nb\"; allowed: a non-empty string of one line");
  EXPECT_EQ(refusal_of_value("\"\"", text), "a.json: /x: found \"\"; allowed: a non-empty string of one line");
}

}  // namespace
}  // namespace malha
