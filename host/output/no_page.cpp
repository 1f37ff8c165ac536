// SPDX-License-Identifier: Apache-2.0
// Takes the place of page.cpp and page_pack.cpp in a build without MALHA_PAGES. A scene that names a page is refused
// before its run (host/model/model.cpp), so that only the constructor and write_comparison() can be reached.
#include "host/output/page.h"
#include "malha/error.h"

namespace malha {

namespace {

[[noreturn]] void refuse_page(const std::string& file) {
  refuse(file, "", "a page, and this malha was built with MALHA_PAGES=OFF", "no page");
}

}  // namespace

Page::Page(const Simulation& simulation) : simulation_(simulation), max_bytes_(0), first_(0), every_(1) {
  refuse_page("page");
}
void Page::add_frame(double) {}
void Page::finish() {}
std::string Page::kept() const { return ""; }
void Page::write(const std::filesystem::path&, const std::string&, const std::vector<std::string>&) const {}

void write_comparison(const std::filesystem::path&, const std::filesystem::path&, const std::filesystem::path& path) {
  refuse_page(path.string());
}

}  // namespace malha
