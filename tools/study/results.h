// SPDX-License-Identifier: Apache-2.0
// What a study leaves in its folder.
#pragma once
#include <filesystem>
#include <string>

#include "tools/study/study.h"

namespace malha::study {

/// Rows as comma-separated values with a head line: every key of any row is a column, in order of first appearance.
/// Text with commas, quotes or line ends is quoted (RFC 4180); what a row does not have, and null, is empty.
std::string csv(const Json& rows);

/// NAME.json: {study, what, quick, command, build, machines, rows, sections}; a section's chart is the name of its file
/// without ending, empty where it was not drawn. `machines` is there where there are several.
Json to_json(const Study& study, const Findings& findings, bool quick, const std::string& command,
             const std::vector<Json>& builds);

/// The line below each chart, of NAME.json: malha, compiler and optimisation, machine or machines, command.
std::string caption(const Json& json);

/// Writes the files and draws the charts. Gives back why there are no charts, or nothing. Throws std::runtime_error.
std::string write_results(const std::filesystem::path& folder, const Study& study, const Findings& findings, Json json);

}  // namespace malha::study
