// SPDX-License-Identifier: Apache-2.0
// Result files of a study.
#pragma once
#include <filesystem>
#include <string>

#include "tools/study/study.h"

namespace malha::study {

/// Rows as comma-separated values with a header line: every key of any row is a column, in order of first appearance.
/// Text with commas, quotes or line ends is quoted (RFC 4180); missing values and null are empty.
std::string csv(const Json& rows);

/// NAME.json: {study, what, quick, command, build, machines, rows, sections}. A section's chart is its file name
/// without extension, empty if it was not drawn. `machines` is present if there are several.
Json to_json(const Study& study, const Findings& findings, bool quick, const std::string& command,
             const std::vector<Json>& builds);

/// The line below each chart, from NAME.json: malha, compiler and optimisation, machine or machines, command.
std::string caption(const Json& json);

/// Writes the files and draws the charts. Returns the reason why charts are missing, or an empty string. Throws
/// std::runtime_error.
std::string write_results(const std::filesystem::path& folder, const Study& study, const Findings& findings, Json json);

}  // namespace malha::study
