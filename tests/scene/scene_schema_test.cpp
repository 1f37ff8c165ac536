// SPDX-License-Identifier: Apache-2.0
// Keeps scenes/schema.json consistent with the parser: walks the schema along the full scene, and at every pointer
// compares it with what the parser accepts.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "host/scene/constraint_schema.h"
#include "malha/scene.h"
#include "tests/full_scene.h"

namespace malha {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Words = std::set<std::string>;

const fs::path scenes = fs::path(MALHA_SOURCE_DIR) / "scenes";

Json read(const fs::path& path) {
  std::ifstream in(path);
  return Json::parse(in);
}

// The words after "allowed: " in a refusal.
Words allowed_in(const std::string& refusal) {
  const std::string mark = "; allowed: ";
  const std::size_t at = refusal.find(mark);
  std::istringstream list(at == std::string::npos ? "" : refusal.substr(at + mark.size()));
  Words words;
  for (std::string word; std::getline(list, word, ',');) words.insert(word.substr(word.find_first_not_of(' ')));
  return words;
}

Words keys_of(const Json& object) {
  Words keys;
  for (const auto& item : object.items()) keys.insert(item.key());
  return keys;
}

// Every node of the schema that describes an object with keys.
void collect_objects(const Json& node, std::set<const Json*>& found) {
  if (node.is_object() && node.contains("properties") && node["properties"].is_object()) found.insert(&node);
  if (node.is_structured()) {
    for (const auto& child : node) collect_objects(child, found);
  }
}

class SceneSchema : public testing::Test {
 protected:
  const Json schema_ = read(scenes / "schema.json");
  Json scene_ = Json::parse(full_scene());
  std::set<const Json*> visited_;  // schema nodes that some pointer of the full scene has led to

  const Json& resolve(const Json& node) const {
    if (!node.contains("$ref")) return node;
    const std::string ref = node["$ref"];
    return resolve(schema_.at(Json::json_pointer(ref.substr(1))));
  }

  // The alternative for a value: constraints by their type, others by being a number, a list or an object.
  const Json& choose(const Json& node, const Json& value) const {
    for (const Json& option : node["oneOf"]) {
      const Json& alternative = resolve(option);
      const std::string type = alternative["type"];
      if (value.is_object() && type == "object") {
        const auto kind = alternative["properties"].find("type");
        if (kind == alternative["properties"].end() || (*kind)["const"] == value.value("type", "")) return alternative;
      }
      if (value.is_number() && (type == "number" || type == "integer")) return alternative;
      if (value.is_array() && type == "array") return alternative;
    }
    throw std::runtime_error("the schema has no alternative for " + value.dump());
  }

  template <class Visit>
  void walk(const Json& unresolved, const std::string& pointer, Visit&& visit) {
    const Json& value = scene_.at(Json::json_pointer(pointer));
    const Json* node = &resolve(unresolved);
    if (node->contains("oneOf") && !node->contains("properties")) node = &choose(*node, value);
    visited_.insert(node);
    visit(*node, pointer);
    if (value.is_object()) {
      for (const auto& item : value.items()) {
        // A key of the scene that the schema lacks fails here, by name.
        walk(node->at("properties").at(item.key()), pointer + "/" + item.key(), visit);
      }
    } else if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) walk(node->at("items"), pointer + "/" + std::to_string(i), visit);
    }
  }
  template <class Visit>
  void walk(Visit&& visit) {
    walk(schema_, "", visit);
  }

  static void expect_refused_at(const std::string& pointer, const std::string& value) {
    const std::string refusal = scene_refusal(changed_scene(pointer, value));
    EXPECT_EQ(refusal.find("s.json: " + pointer), 0u) << pointer << " = " << value << ": " << refusal;
    EXPECT_NE(refusal.find("; allowed: "), std::string::npos) << pointer << " = " << value << ": " << refusal;
  }
};

TEST_F(SceneSchema, AcceptsTheFullSceneAsTheParserDoes) { EXPECT_EQ(scene_refusal(full_scene()), ""); }

TEST_F(SceneSchema, HasTheKeysThatTheParserAllows) {
  walk([](const Json& node, const std::string& pointer) {
    if (!node.contains("properties")) return;
    EXPECT_EQ(node.value("additionalProperties", true), false) << pointer;
    const std::string refusal = scene_refusal(changed_scene(pointer + "/no_such_key_here", "1"));
    EXPECT_EQ(refusal.find("s.json: " + pointer + "/no_such_key_here: found unknown key"), 0u) << refusal;
    EXPECT_EQ(allowed_in(refusal), keys_of(node["properties"])) << pointer;
  });
}

TEST_F(SceneSchema, HasNoObjectThatTheFullSceneDoesNotReach) {
  walk([](const Json&, const std::string&) {});
  scene_["solver"] = {{"type", "pbd"}};  // the keys of the other method are compared below
  walk([](const Json&, const std::string&) {});
  std::set<const Json*> objects;
  collect_objects(schema_, objects);
  EXPECT_GT(objects.size(), 20u);
  for (const Json* object : objects) {
    EXPECT_TRUE(visited_.count(object)) << "never asked: the object with " << Json(keys_of((*object)["properties"]));
  }
}

TEST_F(SceneSchema, HasTheSolverKeysThatTheParserAllowsOfPbd) {
  const Json& pbd = choose(schema_["definitions"]["solver"], {{"type", "pbd"}});
  const std::string refusal = scene_refusal(changed_scene("/solver", R"({"type": "pbd", "no_such_key_here": 1})"));
  EXPECT_EQ(allowed_in(refusal), keys_of(pbd["properties"]));
}

TEST_F(SceneSchema, RequiresTheKeysThatTheParserRequires) {
  walk([&](const Json& node, const std::string& pointer) {
    if (!node.contains("properties") || node.contains("minProperties")) return;  // exactly one of: no single key
    Words required, one_of;
    for (const Json& key : node.value("required", Json::array())) required.insert(key);
    for (const Json& option : node.value("oneOf", Json::array())) one_of.insert(option["required"][0]);
    for (const Json& needs : node.value("dependencies", Json::object()))
      for (const Json& key : needs) one_of.insert(key);  // of keys that the scene has
    for (const std::string& key : keys_of(scene_.at(Json::json_pointer(pointer)))) {
      const std::string refusal = scene_refusal(changed_scene(pointer + "/" + key, "remove"));
      EXPECT_EQ(refusal.empty(), !required.count(key) && !one_of.count(key)) << pointer << " " << key << refusal;
      if (required.count(key)) {
        EXPECT_NE(refusal.find("'" + key + "'"), std::string::npos) << pointer << ": " << refusal;
      }
    }
  });
}

TEST_F(SceneSchema, HasTheWordsThatTheParserAllows) {
  walk([&](const Json& node, const std::string& pointer) {
    if (!node.contains("enum")) return;
    const std::string refusal = scene_refusal(changed_scene(pointer, "\"no such word\""));
    EXPECT_EQ(refusal.find("s.json: " + pointer + ": found unknown"), 0u) << refusal;
    EXPECT_EQ(allowed_in(refusal), node["enum"].get<Words>()) << pointer;
  });
}

TEST_F(SceneSchema, HasTheBoundsOfTheParser) {
  int asked = 0;
  walk([&](const Json& node, const std::string& pointer) {
    const bool integer = node.value("type", "") == "integer";
    // One step outside a bound: 1 for integers, a part of the bound or of 1 for others.
    const auto beyond = [&](double bound) { return integer ? 1 : std::max(std::abs(bound), 1.0) / 1024; };
    if (node.contains("exclusiveMinimum")) expect_refused_at(pointer, node["exclusiveMinimum"].dump());
    for (const auto& [key, sign] : {std::pair("minimum", -1), std::pair("maximum", 1)}) {
      if (!node.contains(key)) continue;
      const double bound = node[key];
      expect_refused_at(pointer, Json(bound + sign * beyond(bound)).dump());
      // On the bound itself another rule may refuse (a box with min above max), but not this one.
      const std::string refusal = scene_refusal(changed_scene(pointer, node[key].dump()));
      EXPECT_EQ(refusal.find("allowed: a number in"), std::string::npos) << refusal;
      EXPECT_EQ(refusal.find("allowed: an integer in"), std::string::npos) << refusal;
      EXPECT_EQ(refusal.find("of a magnitude between"), std::string::npos) << refusal;
      ++asked;
    }
  });
  EXPECT_GT(asked, 100);
}

TEST_F(SceneSchema, HasTheLengthsOfListsThatTheParserWants) {
  walk([&](const Json& node, const std::string& pointer) {
    if (node.value("minItems", 0) > 0) expect_refused_at(pointer, "[]");
    if (!node.contains("maxItems")) return;
    Json longer = scene_.at(Json::json_pointer(pointer));
    EXPECT_LE(node["minItems"], longer.size()) << pointer;  // which the parser took
    EXPECT_GE(node["maxItems"], longer.size()) << pointer;
    while (longer.size() < node["maxItems"]) longer.push_back(longer.back());
    EXPECT_EQ(scene_refusal(changed_scene(pointer, longer.dump())), "") << pointer;
    while (longer.size() > node["minItems"]) longer.erase(longer.size() - 1);
    EXPECT_EQ(scene_refusal(changed_scene(pointer, longer.dump())), "") << pointer;
    Json shorter = longer;
    shorter.erase(shorter.size() - 1);
    expect_refused_at(pointer, shorter.dump());
    while (longer.size() <= node["maxItems"]) longer.push_back(longer.back());
    expect_refused_at(pointer, longer.dump());
  });
}

TEST_F(SceneSchema, HasTheTypesThatTheParserWants) {
  walk([&](const Json& node, const std::string& pointer) {
    if (pointer.empty()) return;
    const bool flag = node.contains("type") && node["type"] == "boolean";
    expect_refused_at(pointer, flag ? "1" : "true");
    expect_refused_at(pointer, "null");
  });
}

TEST_F(SceneSchema, HasTheConstraintsOfTheRegistry) {
  Words in_schema, registered;
  for (const Json& option : schema_["definitions"]["constraint"]["oneOf"]) {
    const Json& properties = option["properties"];
    const std::string name = properties["type"]["const"];
    in_schema.insert(name);
    for (const ConstraintSchema& kind : constraint_kinds()) {
      if (kind.name != name) continue;
      EXPECT_TRUE(properties.contains(kind.parameter)) << name;
      const Json& parameter = resolve(properties[kind.parameter]);
      EXPECT_EQ(parameter.value(kind.min_included ? "minimum" : "exclusiveMinimum", -1.0), kind.parameter_min) << name;
      if (!kind.modulus.empty()) {
        EXPECT_TRUE(properties.contains(kind.modulus)) << name;
        const Json required = option["required"];
        EXPECT_EQ(std::count(required.begin(), required.end(), kind.modulus), kind.accepts_stiffness ? 0 : 1) << name;
      }
    }
  }
  for (const ConstraintSchema& kind : constraint_kinds()) registered.insert(kind.name);
  EXPECT_EQ(in_schema, registered);
}

TEST(ShippedScenes, AreAccepted) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(scenes)) {
    if (entry.path().extension() != ".json" || entry.path().filename() == "schema.json") continue;
    EXPECT_NO_THROW(load_scene(entry.path().string())) << entry.path();
    EXPECT_EQ(load_scene(entry.path().string()).name, entry.path().stem().string());
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace malha
