#include "tools/view/colours.h"

#include <algorithm>
#include <cmath>

#include "host/results/picture.h"

namespace malha::view {

Colour turbo(double part) {
  static constexpr std::array<Colour, 7> kStops{
      {{48, 18, 59}, {70, 134, 251}, {26, 228, 182}, {164, 252, 60}, {251, 185, 56}, {228, 70, 10}, {122, 4, 3}}};
  const double where = std::clamp(std::isfinite(part) ? part : 1.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto k = std::min<std::size_t>(std::size_t(where), kStops.size() - 2);
  Colour colour{};
  for (int c = 0; c < 3; ++c)
    colour[c] = static_cast<unsigned char>(kStops[k][c] + (where - double(k)) * (kStops[k + 1][c] - kStops[k][c]));
  return colour;
}

std::vector<float> mean_strains(const Frame& frame) {
  std::vector<float> sum(frame.x.size(), 0);
  std::vector<int> count(frame.x.size(), 0);
  const std::vector<Vec3>& start = frame.body->look.points;
  for (const auto& [a, b] : frame.body->edges) {
    const double rest = std::hypot(start[a][0] - start[b][0], start[a][1] - start[b][1], start[a][2] - start[b][2]);
    const double now = std::hypot(double(frame.x[a][0]) - frame.x[b][0], double(frame.x[a][1]) - frame.x[b][1],
                                  double(frame.x[a][2]) - frame.x[b][2]);
    const float strain = rest > 0 ? float(std::abs(now - rest) / rest) : 0.0f;
    for (const unsigned i : {a, b}) sum[i] += strain, ++count[i];
  }
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] /= float(std::max(count[i], 1));
  return sum;
}

Coloured coloured(const Frame& frame, Look look, double most) {
  Coloured result;
  result.colours.resize(frame.x.size());
  if (look == Look::Bodies) {
    const std::vector<int>& begin = frame.body->look.body_begin;
    for (std::size_t b = 0; b + 1 < begin.size(); ++b) {
      const std::array<float, 3> colour = body_colour(static_cast<int>(b));
      Colour bytes{};
      for (int c = 0; c < 3; ++c) bytes[c] = static_cast<unsigned char>(255 * colour[c]);
      std::fill(result.colours.begin() + begin[b], result.colours.begin() + begin[b + 1], bytes);
    }
    return result;
  }
  const std::vector<float> values = look == Look::Strain ? mean_strains(frame) : frame.speed;
  result.most = most > 0 ? most : values.empty() ? 0 : double(*std::max_element(values.begin(), values.end()));
  result.unit = look == Look::Strain ? "" : "m/s";
  for (std::size_t i = 0; i < values.size(); ++i)
    result.colours[i] = turbo(*result.most > 0 ? values[i] / *result.most : 0);
  return result;
}

}  // namespace malha::view
