// SPDX-License-Identifier: Apache-2.0
// index.html: all studies that a folder holds, on one page that needs no other file.
#pragma once
#include <filesystem>
#include <string>

namespace malha::study {

/// From each study's NAME.json, in the registry's order, and the charts that it names, which become part of the page.
std::string page(const std::filesystem::path& folder);

/// A chart of gnuplot's as a part of a page: without the lines before <svg>, as wide as there is room, and with names
/// that start with `name`, so that several charts on a page do not take each other's marks.
std::string inline_svg(const std::string& file, const std::string& name);

}  // namespace malha::study
