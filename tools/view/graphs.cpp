// SPDX-License-Identifier: Apache-2.0
#include "tools/view/graphs.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace malha::view {

namespace {

constexpr std::array<ImU32, 8> kColours{IM_COL32(90, 160, 255, 255),  IM_COL32(255, 140, 90, 255),
                                        IM_COL32(90, 210, 150, 255),  IM_COL32(245, 200, 80, 255),
                                        IM_COL32(190, 140, 240, 255), IM_COL32(160, 210, 90, 255),
                                        IM_COL32(240, 130, 180, 255), IM_COL32(200, 170, 130, 255)};

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

}  // namespace

void graph(const std::string& title, const std::string& unit, const std::vector<Series>& series) {
  double low = 0, high = 0, first = INFINITY, last = -INFINITY;
  for (const Series& one : series)
    for (std::size_t k = 0; k < one.times.size(); ++k) {
      if (std::isfinite(one.values[k])) low = std::min(low, one.values[k]), high = std::max(high, one.values[k]);
      first = std::min(first, one.times[k]), last = std::max(last, one.times[k]);
    }
  if (!(first < last)) return;
  ImGui::Text("%s%s%s", title.c_str(), unit.empty() ? "" : ", ", unit.c_str());
  const float room = ImGui::GetContentRegionAvail().x;
  float names = 0;
  for (std::size_t s = 0; s < series.size() && series.size() > 1; ++s) {
    const float own = ImGui::CalcTextSize(series[s].name.c_str()).x + ImGui::GetStyle().ItemSpacing.x;
    if (s > 0 && names + own < room) ImGui::SameLine();
    names = s > 0 && names + own < room ? names + own : own;
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(kColours[s % kColours.size()]), "%s", series[s].name.c_str());
  }
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float line = ImGui::GetTextLineHeight(), left = 4 * line, width = room - left - 4, height = 5.4f * line;
  if (width < 20) return;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const ImU32 grey = IM_COL32(150, 150, 150, 255);
  const auto at = [&](double time, double value) {
    return ImVec2(corner.x + left + float((time - first) / (last - first)) * width,
                  corner.y + height - float((value - low) / (high > low ? high - low : 1)) * height);
  };
  draw->AddRect({corner.x + left, corner.y}, {corner.x + left + width, corner.y + height}, IM_COL32(90, 90, 90, 255));
  draw->AddText({corner.x, corner.y}, grey, text_of(high).c_str());
  draw->AddText({corner.x, corner.y + height - line}, grey, text_of(low).c_str());
  draw->AddText({corner.x + left, corner.y + height}, grey, (text_of(first) + " s").c_str());
  const std::string end = text_of(last) + " s";
  draw->AddText({corner.x + left + width - ImGui::CalcTextSize(end.c_str()).x, corner.y + height}, grey, end.c_str());
  for (std::size_t s = 0; s < series.size(); ++s) {
    std::vector<ImVec2> points;
    for (std::size_t k = 0; k < series[s].times.size(); ++k)
      if (std::isfinite(series[s].values[k])) points.push_back(at(series[s].times[k], series[s].values[k]));
    draw->AddPolyline(points.data(), int(points.size()), kColours[s % kColours.size()], 0, 1.5f);
  }
  ImGui::Dummy({width + left, height + line + 6});
}

}  // namespace malha::view
