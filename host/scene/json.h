// SPDX-License-Identifier: Apache-2.0
// Strict parser of JSON text: no comments, no duplicate keys, no trailing text.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace malha {

using Json = nlohmann::ordered_json;  // keeps the order of keys

/// Parses JSON text (UTF-8). Throws InputError, which names `file`, the line and the column (in bytes, from 1).
Json parse_json(const std::string& text, const std::string& file);

/// The JSON pointer (RFC 6901) of a key or index below `pointer`.
std::string json_pointer(const std::string& pointer, const std::string& key);

/// A short description of a value for messages: its own text if that is short.
std::string describe(const Json& value);

}  // namespace malha
