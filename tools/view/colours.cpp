// SPDX-License-Identifier: Apache-2.0
#include "tools/view/colours.h"

#include <algorithm>
#include <cmath>

#include "host/mesh/vectors.h"
#include "host/render/picture.h"
#include "malha/text.h"

namespace malha::view {

namespace {

constexpr Colour kNoValue{205, 208, 214}, kContact{225, 60, 50};

Colour bytes_of(const std::array<float, 3>& colour) {
  Colour bytes{};
  for (int c = 0; c < 3; ++c) bytes[c] = static_cast<unsigned char>(std::lround(255 * colour[c]));
  return bytes;
}

std::vector<Vec3> places(const Frame& frame) {
  std::vector<Vec3> x;
  for (const Point3f& a : frame.x) x.push_back({a[0], a[1], a[2]});
  return x;
}

void by_body(const Frame& frame, Coloured& to) {
  const std::vector<int>& begin = frame.body->mesh.body_begin;
  for (std::size_t b = 0; b + 1 < begin.size(); ++b)
    std::fill(to.colours.begin() + begin[b], to.colours.begin() + begin[b + 1], bytes_of(body_colour(int(b))));
}

void by_value(const std::vector<float>& values, const std::string& what, Coloured& to) {
  to.most = values.empty() ? 0 : double(*std::max_element(values.begin(), values.end()));
  to.legend = what;
  for (std::size_t i = 0; i < values.size(); ++i) to.colours[i] = turbo(*to.most > 0 ? values[i] / *to.most : 0);
}

void by_number(const std::vector<int>& numbers, int count, const std::string& what, Coloured& to) {
  for (std::size_t i = 0; i < numbers.size(); ++i) to.colours[i] = numbers[i] < 0 ? kNoValue : distinct(numbers[i]);
  to.legend = std::to_string(count) + " " + what;
}

/// Adds constraints as lines in the colours of their batches.
void by_batch(const Frame& frame, const Structure& structure, Coloured& to) {
  std::fill(to.colours.begin(), to.colours.end(), kNoValue);
  for (std::size_t l = 0; l < structure.lines.size(); ++l)
    for (const int end : structure.lines[l]) {
      to.marks.lines.push_back(frame.x[end]);
      to.marks.line_colours.push_back(distinct(structure.batch[l]));
    }
  to.legend = "at most " + counted(structure.batches, "batch", "batches") + " a patch";
}

/// Highlights a particle and adds a line.
void mark(int particle, const Point3f& from, const Vec3& to, Coloured& picture) {
  picture.colours[particle] = kContact;
  picture.marks.lines.insert(picture.marks.lines.end(), {from, to_point3f(to)});
  picture.marks.line_colours.insert(picture.marks.line_colours.end(), {kContact, kContact});
}

/// Highlights particles in contact and adds their contact normals.
void by_contact(const Frame& frame, const Contacts& contacts, Coloured& to) {
  std::fill(to.colours.begin(), to.colours.end(), kNoValue);
  const std::vector<ContactPoint> touches = contacts(places(frame), *frame.environment, frame.time);
  for (const ContactPoint& touch : touches) {
    Vec3 end = touch.at;
    for (std::size_t k = 0; k < 3; ++k) end[k] += 2 * frame.body->spacing * touch.normal[k];
    mark(touch.particle, to_point3f(touch.at), end, to);
  }
  to.legend = counted(touches.size(), "particle touches", "particles touch");
}

/// Returns the diagonal of the bounding box, m.
double diagonal(const std::vector<Vec3>& x) {
  Vec3 low = x[0], high = x[0];
  for (const Vec3& a : x)
    for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], a[k]), high[k] = std::max(high[k], a[k]);
  return norm(minus(high, low));
}

/// Adds the forces on pins as lines; the largest is as long as a sixth of the bodies.
void by_force(const Frame& frame, const PinForces& forces, Coloured& to) {
  std::fill(to.colours.begin(), to.colours.end(), kNoValue);
  const std::vector<Vec3> x = places(frame);
  const std::vector<PinForce> all = forces(x, frame.time);
  Vec3 sum{};
  double largest = 0;
  for (const PinForce& one : all) {
    largest = std::max(largest, norm(one.force));
    for (std::size_t k = 0; k < 3; ++k) sum[k] += one.force[k];
  }
  const double metres = largest > 0 ? diagonal(x) / 6 / largest : 0;  // m per newton
  for (const PinForce& one : all) {
    Vec3 end = x[one.particle];
    for (std::size_t k = 0; k < 3; ++k) end[k] += metres * one.force[k];
    mark(one.particle, frame.x[one.particle], end, to);
  }
  if (!forces.any())
    to.legend = "no force is known: constraints at pins have no compliance, or are too stiff for the substeps";
  else
    to.legend = "at most " + shown(largest) + " N a pin, all together " + shown(norm(sum)) + " N";
  if (forces.any() && forces.left_out() > 0)
    to.legend += ", without " + counted(forces.left_out(), "constraint") + " that are too stiff";
}

}  // namespace

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

Colour distinct(int number) {
  const double turn =
      6 * std::fmod(0.61803398875 * number, 1.0);  // the golden ratio keeps a few consecutive hues apart
  const double light = number % 2 == 0 ? 0.95 : 0.72;
  Colour colour{};
  for (int c = 0; c < 3; ++c) {
    const double away = std::abs(std::fmod(turn + 2 * c, 6.0) - 3);
    colour[c] = static_cast<unsigned char>(255 * light * (0.3 + 0.7 * std::clamp(away - 1, 0.0, 1.0)));
  }
  return colour;
}

Coloured coloured(const Frame& frame, const VisualFields& fields, VisualField field) {
  Coloured to;
  to.colours.resize(frame.x.size());
  by_body(frame, to);
  const bool same = fields.body == frame.body;
  if (field == VisualField::Speed)
    by_value(frame.speed, "m/s", to);
  else if (field == VisualField::Strain && same && fields.strains)
    by_value((*fields.strains)(places(frame)), "largest strain of a particle's constraints", to);
  else if (field == VisualField::Residual && same && fields.residuals)
    by_value((*fields.residuals)(places(frame)), "m, largest residual of a particle's constraints", to);
  else if (field == VisualField::Contact && same && fields.contacts)
    by_contact(frame, *fields.contacts, to);
  else if (field == VisualField::Force && same && fields.forces)
    by_force(frame, *fields.forces, to);
  else if (field == VisualField::Patch && same && fields.structure)
    by_number(fields.structure->patch, fields.structure->patches, "patches", to);
  else if (field == VisualField::PatchColour && same && fields.structure)
    by_number(fields.structure->colour, fields.structure->colours, "colours", to);
  else if (field == VisualField::Batch && same && fields.structure)
    by_batch(frame, *fields.structure, to);
  return to;
}

}  // namespace malha::view
