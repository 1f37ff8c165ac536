// SPDX-License-Identifier: Apache-2.0
// A scene with every key and every alternative of the format, for tests of the parser; it need not run.
#pragma once
#include <string>

namespace malha {

std::string full_scene();

/// The full scene with another value (JSON text) at a JSON pointer; the value "remove" removes the key.
std::string changed_scene(const std::string& pointer, const std::string& value);

/// The refusal of parse_scene (file "s.json", no folder); "" if it accepts the text.
std::string scene_refusal(const std::string& text);

}  // namespace malha
