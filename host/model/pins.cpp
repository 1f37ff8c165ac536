#include "host/model/pins.h"

#include <algorithm>

#include "host/error.h"

namespace malha {

namespace {

double squared_distance(const Vec3& a, const Vec3& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

/// The particles that one pin names; empty where it names none.
class Finder {
 public:
  Finder(const Shape& shape, const Mesh& mesh) : shape_(shape), mesh_(mesh), n_(static_cast<int>(mesh.points.size())) {}

  std::vector<int> operator()(const RowPin& pin) const {
    int row = 0;
    if (const auto* grid = std::get_if<GridShape>(&shape_)) row = grid->cells[0] + 1;
    if (std::holds_alternative<ChainShape>(shape_)) row = 1;
    std::vector<int> found(row);
    for (int i = 0; i < row; ++i) found[i] = pin.last ? n_ - row + i : i;
    return found;
  }
  std::vector<int> operator()(const BoxPin& pin) const {
    return where([&pin](const Vec3& x) {
      bool inside = true;
      for (int k = 0; k < 3; ++k) inside = inside && pin.min[k] <= x[k] && x[k] <= pin.max[k];
      return inside;
    });
  }
  std::vector<int> operator()(const SpherePin& pin) const {
    return where([&pin](const Vec3& x) { return squared_distance(x, pin.center) <= pin.radius * pin.radius; });
  }
  std::vector<int> operator()(const NearestPin& pin) const {
    const auto nearer = [&pin](const Vec3& a, const Vec3& b) {
      return squared_distance(a, pin.point) < squared_distance(b, pin.point);
    };
    const auto& points = mesh_.points;
    return {static_cast<int>(std::min_element(points.begin(), points.end(), nearer) - points.begin())};
  }
  std::vector<int> operator()(const ListPin& pin) const { return pin.particles; }

 private:
  template <class Test>
  std::vector<int> where(Test&& test) const {
    std::vector<int> found;
    for (int i = 0; i < n_; ++i)
      if (test(mesh_.points[i])) found.push_back(i);
    return found;
  }

  const Shape& shape_;
  const Mesh& mesh_;
  int n_;
};

}  // namespace

std::vector<bool> pinned_particles(const Scene& scene, std::size_t body, const Mesh& mesh) {
  const BodySpec& spec = scene.bodies[body];
  const std::string place = "/bodies/" + std::to_string(body) + "/pins";
  const int n = static_cast<int>(mesh.points.size());
  std::vector<bool> pinned(n, false);
  for (std::size_t k = 0; k < spec.pins.size(); ++k) {
    const std::string here = place + "/" + std::to_string(k);
    const std::vector<int> found = std::visit(Finder(spec.shape, mesh), spec.pins[k]);
    if (found.empty())
      refuse(scene.file, here, "no particle there", "a pin that holds a particle (rows are for grids and chains)");
    for (int i : found) {
      if (i < 0 || i >= n) refuse(scene.file, here, "particle " + std::to_string(i), "0 to " + std::to_string(n - 1));
      pinned[i] = true;
    }
  }
  if (std::find(pinned.begin(), pinned.end(), false) == pinned.end())
    refuse(scene.file, place, "every particle of body '" + spec.name + "' pinned", "at least one that can move");
  return pinned;
}

}  // namespace malha
