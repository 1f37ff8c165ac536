// Known failures of the study "stability" that are of places: starts that are no shape at all, and surfaces thinner
// than a step is long.
#include <cmath>
#include <random>

#include "host/base/shown.h"
#include "host/simulation.h"
#include "tools/bench/output.h"
#include "tools/study/stability_lines.h"
#include "tools/study/stability_map.h"

namespace malha::study {

namespace {

using bench::formatted;

enum class Start { Random, Collapsed, NearlyCollapsed };

/// A sheet of n x n particles of 1 m, held at two corners, that keyframes carry to another start and let go there.
Scene started(int n, Start start, double compliance) {
  Scene scene = hanging_sheet(n, 1, 0.2, compliance);
  scene.solver.substeps = 10;
  BodySpec& body = scene.bodies[0];
  body.pins = {ListPin{{0, n - 1}}};
  std::mt19937 random(7);
  const auto unit = [&random] { return double(random()) / 4294967296.0; };  // the same on every library
  for (int i = 0; i < n * n; ++i) {
    if (i == 0 || i == n - 1) continue;
    const double x = double(i % n) / (n - 1), z = double(i / n) / (n - 1);
    Vec3 to{0.5, -0.5, 0.5};
    if (start == Start::Random) to = {unit(), unit() - 0.5, unit()};
    if (start == Start::NearlyCollapsed)
      for (double& a : to) a += 1e-6 * unit();
    Keyframe there;
    there.time = 0.02, there.translate = {to[0] - x, to[1], to[2] - z};
    Keyframe rest = there;
    rest.time = 0.04;
    Pin pin{ListPin{{i}}};
    pin.motion = {Keyframe{}, there, rest}, pin.until = 0.04;
    body.pins.push_back(pin);
  }
  return scene;
}

constexpr double kThickness = 0.002;  // m

/// 11 x 11 loose particles that fly at a wall, and how many are behind it in the end.
int passed(double speed, const Cells& cells) {
  BodySpec bullets;
  bullets.name = "bullets", bullets.shape = CloudShape{{-1, -0.5, -0.5}, {-1, 0.5, 0.5}, {1, 11, 11}};
  bullets.mass = 1, bullets.velocity = {speed, 0, 0};
  EnvironmentSpec wall;
  wall.name = "wall", wall.shape = GridShape{{10, 10}, {4, 4}}, wall.sides = Sides::TwoSided,
  wall.thickness = kThickness;
  wall.transform.translate = {0, -5, -5}, wall.transform.axis = {0, 0, 1}, wall.transform.degrees = 90;
  Scene scene;
  scene.file = "malha study", scene.name = "bullets", scene.bodies = {bullets}, scene.environment = {wall};
  scene.solver.dt = kFrame, scene.solver.substeps = 1;
  Simulation simulation(scene, {.threads = 1});
  const int steps = std::max(2, int(std::ceil(2 / speed / kFrame)));
  for (int step = 0; step < steps; ++step) simulation.step(), cells.go_on();
  int count = 0;
  for (const Vec3& x : simulation.positions()) count += x[0] > 0;
  return count;
}

/// The same by a look at the end of each step alone, which finds those within the thickness; `phase`: of the start.
bool passes_unseen(double speed, double phase) {
  double x = -1 - phase * speed * kFrame;
  while (x < -kThickness) x += speed * kFrame;
  return x > kThickness;
}

/// Edges and triangles of two sheets that are crossed after one was thrown at the other.
double crossed(double speed, const Cells& cells) {
  Scene scene = hanging_sheet(9, 0.5, 0.05, 0);
  scene.gravity = {0, 0, 0}, scene.solver.substeps = 1, scene.solver.iterations = 4;
  scene.bodies[0].pins.clear();
  BodySpec other = scene.bodies[0];
  other.name = "other", other.transform.translate = {0.03, 0.3, 0.02}, other.velocity = {0, -speed, 0};
  scene.bodies.push_back(other);
  SelfCollision self;
  self.thickness = kThickness;
  scene.self_collision = self;
  Simulation simulation(scene, {.threads = 1});
  const int steps = std::max(2, int(std::ceil(0.6 / speed / kFrame)));
  for (int step = 0; step < steps; ++step) simulation.step(), cells.go_on();
  return double(simulation.measure().crossings);
}

}  // namespace

Section start_failure(Cells& cells, Json& rows) {
  const int n = cells.quick() ? 7 : 17;
  Section section{formatted("Random and collapsed starts: %d x %d particles held at two corners", n, n), {}, {}, {}};
  section.table.columns = {"start",       "method",    "RMS strain at the start",
                           "after 0.5 s", "after 3 s", "without a direction"};
  const std::vector<std::pair<Start, std::string>> starts{
      {Start::Random, "anywhere in 1 m^3"}, {Start::NearlyCollapsed, "within 1e-6 m"}, {Start::Collapsed, "one point"}};
  for (const auto& [start, title] : starts)
    for (const double compliance : {0.0, 1e-3}) {
      const std::string method = compliance > 0 ? "XPBD, 1 kN/m" : "PBD";
      const Json cell = cells(formatted("start: %d, %s, %s", n, title.c_str(), method.c_str()), [&]() -> Json {
        Simulation simulation(started(n, start, compliance), {.threads = 1});
        Json strain = Json::array();
        std::int64_t degenerate = 0;
        for (int step = 1; step <= 183; ++step) {
          simulation.step(), cells.go_on();
          const Measures m = simulation.measure();
          degenerate = m.degenerate;
          if (step == 2 || step == 33 || step == 183) strain.push_back(m.strain_rms);
        }
        return {{"strain", strain}, {"degenerate", degenerate}};
      });
      std::vector<std::string> row{title, method};
      for (const auto& strain : cell["strain"]) row.push_back(formatted("%.2g", strain.get<double>()));
      row.push_back(std::to_string(cell["degenerate"].get<int>()));
      section.table.rows.push_back(row);
      rows.push_back({{"map", "start"}, {"panel", method}, {"x_name", title}, {"rms_strain", cell["strain"].back()}});
      section.sentences.push_back(method + ", " + title + ": " +
                                  formatted("RMS strain %.2g at the start and %.2g after 3 s.",
                                            cell["strain"][0].get<double>(), cell["strain"][2].get<double>()));
    }
  section.sentences.push_back(
      "What guards: a constraint between coincident particles has no direction and is left out, counted in the report "
      "(degenerate_constraints_skipped), until others move its ends apart.");
  return section;
}

Section thickness_failure(Cells& cells, Json& rows) {
  Section section{"Thickness smaller than what a step moves by", {}, {}, {}};
  section.table.columns = {"speed, m/s", "a step moves by, thicknesses", "passed, malha, of 121",
                           "passed, seen at ends of steps alone", "crossings of two sheets, malha"};
  double most = 0, unseen_most = 0;
  for (const double speed : cells.quick() ? std::vector<double>{1, 100} : std::vector<double>{0.1, 1, 10, 100, 1000}) {
    const Json cell = cells(formatted("thickness: %g m/s", speed), [&]() -> Json {
      return {{"passed", passed(speed, cells)}, {"crossings", crossed(speed, cells)}};
    });
    int unseen = 0;
    for (int k = 0; k < 100; ++k) unseen += passes_unseen(speed, k / 100.0);
    section.table.rows.push_back({short_number(speed), formatted("%.3g", speed * kFrame / kThickness),
                                  std::to_string(cell["passed"].get<int>()), formatted("%d %%", unseen),
                                  formatted("%g", cell["crossings"].get<double>())});
    rows.push_back({{"map", "thickness"},
                    {"x_name", "speed (m/s)"},
                    {"x", speed},
                    {"passed", cell["passed"]},
                    {"passed_unseen_percent", unseen},
                    {"crossings", cell["crossings"]}});
    most = std::max({most, cell["passed"].get<double>(), cell["crossings"].get<double>()});
    unseen_most = std::max(unseen_most, double(unseen));
  }
  section.sentences = {
      formatted(
          "121 particles fly at a wall %g m thick, and a sheet at another, one substep a step: a look at the ends of "
          "steps alone lets up to %g %% through; of malha's, %g pass or cross.",
          kThickness, unseen_most, most),
      "What guards: collisions are found along the whole way (Embree's rays, swept boxes, planes that part pairs)."};
  return section;
}

}  // namespace malha::study
