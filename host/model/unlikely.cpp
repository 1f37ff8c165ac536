// SPDX-License-Identifier: Apache-2.0
#include "host/model/unlikely.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "host/base/median.h"
#include "host/mesh/bounding_box.h"
#include "host/mesh/vectors.h"
#include "host/mesh/weld.h"
#include "host/model/self_surface.h"
#include "malha/text.h"

namespace malha {

namespace {

constexpr double kThickness = 0.005;  // m
constexpr double kThicknessOfEdge = 0.2;

// Beyond these bounds a setting is probably a mistake.
constexpr double kOtherUnits = 100;      // ratio of sizes
constexpr double kOtherUnitsLarge = 10;  // ratio of sizes for a body larger than kLarge
constexpr double kLarge = 50;            // m
constexpr double kThickSelf = 2;         // edge lengths: 650 pairs per particle
constexpr double kThick = 1;             // edge lengths
constexpr double kThin = 1e-4;           // edge lengths
constexpr double kFarFromRest = 1.5;     // length of an edge at the start over that at rest, or the inverse
constexpr double kEase = 0.03;           // of lengths at both sides of a seam
constexpr double kMaxFriction = 3;       // a slope of 72 degrees; rubber on rubber has some 1.2

/// The median length of the edges at rest (m); 0 without edges.
double median_edge(const Body& body) {
  std::vector<double> lengths;
  lengths.reserve(body.edges.size());
  const RestShape shape = body.shape();
  for (const auto& [a, b] : body.edges) lengths.push_back(shape.length(a, b));
  return median(std::move(lengths));
}

/// The diagonal of the bounding box, m.
double size_of(const std::vector<Vec3>& points) {
  const auto [low, high] = bounds_of(points);
  return distance(low, high);
}

std::string length(double metres) { return shown(two_digits(metres)) + " m"; }
std::string times(double ratio) { return shown(two_digits(ratio)) + " times"; }

class UnlikelyFinder {
 public:
  UnlikelyFinder(const Model& model, const std::vector<Body>& bodies)
      : model_(model), scene_(model.scene), bodies_(bodies) {
    for (const Body& body : bodies) edges_.push_back(median_edge(body));
  }

  std::vector<std::string> find() {
    check_sizes();
    for (std::size_t b = 0; b < bodies_.size(); ++b) check_constraints(b), check_rest(b);
    check_contacts();
    check_self_collision();
    return std::move(lines_);
  }

 private:
  std::string name(std::size_t b) const { return "body '" + scene_.bodies[b].name + "'"; }

  /// Warns about files in other units, such as a body in centimetres among others in metres.
  void check_sizes() {
    double largest = 0, least = std::numeric_limits<double>::infinity();
    std::size_t large = 0, small = 0;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (edges_[b] == 0) continue;
      const double size = size_of(bodies_[b].mesh.points);
      if (size > largest) largest = size, large = b;
      if (size < least) least = size, small = b;
    }
    if (largest == 0) return;
    double object = 0;
    std::string of_object;
    for (const EnvironmentMesh& mesh : model_.environment)
      if (const double size = size_of(mesh.mesh.points); size > object) object = size, of_object = mesh.spec.name;
    const auto say = [&](double size, double other, const std::string& than) {
      lines_.push_back(name(large) + " measures " + length(size) + ", " + times(size / other) + " as much as " + than +
                       ", which measures " + length(other) +
                       ": are its numbers centimetres or millimetres? Then take \"scale\": 0.01 or 0.001 in its "
                       "\"transform\"");
    };
    const double most = largest > kLarge ? kOtherUnitsLarge : kOtherUnits;
    if (object > 0 && largest > most * object)
      say(largest, object, "the largest object, '" + of_object + "'");
    else if (largest > most * least)
      say(largest, least, name(small));
  }

  void check_constraints(std::size_t b) {
    const BodySpec& spec = scene_.bodies[b];
    const std::vector<bool>& pinned = bodies_[b].boundary.pinned;
    if (const auto free = std::ranges::count(pinned, false); spec.constraints.empty() && edges_[b] > 0 && free > 0)
      lines_.push_back(name(b) + " names no \"constraints\": each of its " + counted(free, "particle") +
                       " moves by itself; take {\"type\": \"distance\"} to keep its edges' lengths");
    for (std::size_t c = 0; c < spec.constraints.size(); ++c)
      for (std::size_t d = 0; d < c; ++d)
        if (are_same(spec.constraints[c], spec.constraints[d])) {
          lines_.push_back(name(b) + " names \"" + spec.constraints[c].type + "\" 2 times for the same elements, as " +
                           "constraints " + std::to_string(d) + " and " + std::to_string(c) +
                           " (0-based): both act, and together they are stiffer; leave one out");
          return;
        }
  }

  /// Warns about a start that is far from the rest shape, and about sides of a seam of different lengths.
  void check_rest(std::size_t b) {
    if (!bodies_[b].rest) return;
    const RestShape shape = bodies_[b].shape();
    const std::vector<Vec3>& x = bodies_[b].mesh.points;
    const auto edge = [&](const Edge& at) {
      const auto vertex = [&](int point) { return std::to_string(vertex_of(bodies_[b].mesh.vertices, point)); };
      return "the edge from vertex " + vertex(at[0]) + " to " + vertex(at[1]);
    };
    double most = 0, ratio = 1;
    Edge worst{};
    for (const Edge& e : bodies_[b].edges)
      if (const double now = distance(x[e[0]], x[e[1]]) / shape.length(e[0], e[1]); std::abs(std::log(now)) > most)
        most = std::abs(std::log(now)), ratio = now, worst = e;
    if (most > std::log(kFarFromRest))
      lines_.push_back(
          name(b) + ": at the start " + edge(worst) + " is " + times(ratio) +
          " as long as in its \"rest\", whose lengths are in metres and which \"transform\" does not scale");
    if (const Ease ease = largest_ease(shape); ease.most > kEase)
      lines_.push_back(name(b) + ": in its \"rest\", " + edge(ease.at) + " is " + shown(two_digits(100 * ease.most)) +
                       " % longer on one side of a seam than on the other; it rests at the mean of both");
  }

  static bool are_same(const ConstraintSpec& a, const ConstraintSpec& b) {
    const auto shared = [&b](const std::string& element) {
      return std::ranges::find(b.elements, element) != b.elements.end();
    };
    return a.type == b.type && (a.elements.empty() || std::ranges::any_of(a.elements, shared));
  }

  void check_contacts() {
    const double edge = finest_edge(bodies_);
    for (const EnvironmentSpec& object : scene_.environment) {
      const std::string of = "object '" + object.name + "': ";
      if (std::isfinite(edge) && object.thickness > kThick * edge)
        lines_.push_back(of + "a thickness of " + length(object.thickness) + " is " + times(object.thickness / edge) +
                         " the edges of a body, " + length(edge) + ", which will float; take " +
                         length(default_thickness(edge)) + ", or leave it out");
      say_friction(of, object.friction);
    }
  }

  void check_self_collision() {
    if (!scene_.self_collision) return;
    const SelfCollision& self = *scene_.self_collision;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      if (!self_collides(scene_, scene_.bodies[b].name) || edges_[b] == 0) continue;
      const double ratio = self.thickness / edges_[b];
      if (ratio > kThickSelf)
        lines_.push_back(name(b) + ": a self-collision thickness of " + length(self.thickness) + " is " + times(ratio) +
                         " its edges, " + length(edges_[b]) +
                         ": most of it lies nearer to itself than that; take a "
                         "thickness below its edges");
      else if (ratio < kThin)
        lines_.push_back(name(b) + ": a self-collision thickness of " + length(self.thickness) + " is " + times(ratio) +
                         " its edges, " + length(edges_[b]) + ", less than contacts can keep; take " +
                         length(10 * kThin * edges_[b]) + " or more");
    }
    say_friction("self_collision: ", self.friction);
  }

  void say_friction(const std::string& of, double friction) {
    if (friction > kMaxFriction)
      lines_.push_back(of + "a friction of " + shown(friction) + " is " + times(friction) +
                       " the pressing force, where dry materials have .1 to 1.2: is it a percentage?");
  }

  const Model& model_;
  const Scene& scene_;
  const std::vector<Body>& bodies_;
  std::vector<double> edges_;
  std::vector<std::string> lines_;
};

}  // namespace

double finest_edge(const std::vector<Body>& bodies) {
  double finest = std::numeric_limits<double>::infinity();
  for (const Body& body : bodies)
    if (const double edge = median_edge(body); edge > 0) finest = std::min(finest, edge);
  return finest;
}

double default_thickness(double finest_edge) { return std::min(kThickness, kThicknessOfEdge * finest_edge); }

std::vector<std::string> unlikely_settings(const Model& model, const std::vector<Body>& bodies) {
  return UnlikelyFinder(model, bodies).find();
}

}  // namespace malha
