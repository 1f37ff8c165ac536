// SPDX-License-Identifier: Apache-2.0
#include "host/output/page_pack.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace malha {

namespace {

constexpr double kSteps = 65535;  // of a coordinate in the bounding box
constexpr double kValueSteps = 255, kWaySteps = 127;

}  // namespace

std::string packed(std::span<const std::uint32_t> numbers, std::size_t stride, int bytes) {
  const std::size_t n = numbers.size();
  std::vector<unsigned char> planes(n * static_cast<std::size_t>(bytes));
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t step = numbers[i] - (i < stride ? 0 : numbers[i - stride]);
    for (int b = 0; b < bytes; ++b) planes[static_cast<std::size_t>(b) * n + i] = (step >> (8 * b)) & 0xff;
  }
  uLongf size = compressBound(static_cast<uLong>(planes.size()));
  std::string deflated(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(deflated.data()), &size, planes.data(), static_cast<uLong>(planes.size()),
                Z_DEFAULT_COMPRESSION) != Z_OK)
    throw std::runtime_error("a page: zlib cannot deflate " + std::to_string(planes.size()) + " bytes");
  deflated.resize(size);
  return deflated;
}

double PackedPoints::rounding() const { return *std::max_element(side.begin(), side.end()) / kSteps / 2; }

PackedPoints packed(const std::vector<Vec3>& points) {
  PackedPoints all;
  if (points.empty()) return all;
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(), [k](const Vec3& a, const Vec3& b) { return a[k] < b[k]; });
    all.low[k] = (*low)[k], all.side[k] = (*high)[k] - (*low)[k];
  }
  std::vector<std::uint32_t> steps;
  steps.reserve(3 * points.size());
  for (const Vec3& point : points)
    for (int k = 0; k < 3; ++k) {
      const double part = all.side[k] > 0 ? (point[k] - all.low[k]) / all.side[k] : 0;
      steps.push_back(static_cast<std::uint32_t>(std::lround(std::clamp(part, 0.0, 1.0) * kSteps)));
    }
  all.data = packed(steps, 3, 2);
  return all;
}

PackedValues packed(const std::vector<float>& values) {
  PackedValues all;
  const auto bounded = [](float value) { return std::min(value, std::numeric_limits<float>::max()); };
  for (const float value : values) all.most = std::max<double>(all.most, bounded(value));
  std::vector<std::uint32_t> steps;
  steps.reserve(values.size());
  for (const float value : values)
    steps.push_back(
        static_cast<std::uint32_t>(all.most > 0 ? std::lround(kValueSteps * bounded(value) / all.most) : 0));
  all.data = packed(steps, steps.size(), 1);
  return all;
}

PackedContacts packed(const std::vector<ContactPoint>& touches) {
  PackedContacts all{touches.size(), 0, {}, {}};
  for (const ContactPoint& touch : touches) all.far = std::max(all.far, std::abs(touch.distance));
  std::vector<std::uint32_t> particles, ways;
  const auto step = [](double part) { return static_cast<std::uint32_t>(std::lround(kWaySteps * (1 + part))); };
  for (const ContactPoint& touch : touches) {
    particles.push_back(static_cast<std::uint32_t>(touch.particle));
    for (const double part : touch.normal) ways.push_back(step(part));
    ways.push_back(step(all.far > 0 ? touch.distance / all.far : 0));
  }
  all.particles = packed(particles, 1, 4), all.ways = packed(ways, 4, 1);
  return all;
}

PackedForces packed(const std::vector<PinForce>& all) {
  std::vector<std::uint32_t> particles;
  std::vector<Vec3> forces;
  for (const PinForce& one : all) {
    particles.push_back(static_cast<std::uint32_t>(one.particle));
    Vec3& force = forces.emplace_back(one.force);
    for (double& part : force) part = std::isnan(part) ? 0 : std::clamp(part, -1e30, 1e30);
  }
  return {all.size(), packed(particles, 1, 4), packed(forces)};
}

std::string base64(const std::string& bytes) {
  static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? letters[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace malha
