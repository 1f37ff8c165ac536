// SPDX-License-Identifier: Apache-2.0
// Chart of `malha bench self`: the time of a step of falling layers over their number of particles.
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace malha::bench {

/// Tells whether the rows have layers of two sizes or more.
bool has_layers_chart(const nlohmann::ordered_json& rows);
/// Draws FOLDER/self.svg and .png of them. Returns why it could not; empty if it could.
std::string draw_layers_chart(const nlohmann::ordered_json& rows, const std::filesystem::path& folder);

}  // namespace malha::bench
