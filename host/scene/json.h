// SPDX-License-Identifier: Apache-2.0
// Strict parser of JSON text: no comments, no duplicate keys, no trailing text.
#pragma once
#include <string>

#include "host/scene/json_value.h"

namespace malha {

/// Parses JSON text (UTF-8). Throws InputError, which names `file`, the line and the column (in bytes, from 1). In a
/// build without MALHA_JSON it refuses any text.
JsonValue parse_json(const std::string& text, const std::string& file);

}  // namespace malha
