// SPDX-License-Identifier: Apache-2.0
// A scene that uses every key and every alternative of the format, to be parsed and refused by tests; it need not run.
#pragma once
#include <string>

namespace malha {

std::string full_scene();

/// The full scene with another value (JSON text) at a JSON pointer; the value "remove" takes the key away.
std::string changed_scene(const std::string& pointer, const std::string& value);

/// The refusal of parse_scene (file "s.json", no folder); "" where it accepts.
std::string scene_refusal(const std::string& text);

}  // namespace malha
