// SPDX-License-Identifier: Apache-2.0
// index.html: all studies of a folder on one page that needs no other file.
#pragma once
#include <filesystem>
#include <string>

namespace malha::study {

/// The page, from each study's NAME.json in the registry's order, with the charts that it names embedded.
std::string page(const std::filesystem::path& folder);

/// A chart of gnuplot's as part of a page: without the lines before <svg>, as wide as the page, and with ids that start
/// with `name`, so that several charts on a page do not share ids.
std::string inline_svg(const std::string& file, const std::string& name);

}  // namespace malha::study
