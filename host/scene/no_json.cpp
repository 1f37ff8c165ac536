// SPDX-License-Identifier: Apache-2.0
// Takes the place of json.cpp in a build without MALHA_JSON.
#include "host/scene/json.h"
#include "malha/error.h"

namespace malha {

JsonValue parse_json(const std::string&, const std::string& file) {
  refuse(file, "", "JSON, and this malha was built with MALHA_JSON=OFF", "scenes that a program makes (malha/scene.h)");
}

}  // namespace malha
