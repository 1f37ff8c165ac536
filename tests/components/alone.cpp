// SPDX-License-Identifier: Apache-2.0
// A program with a malha of which all parts are left out that can be. It makes scenes, steps them, continues them from
// a checkpoint, and asks for what is not there. Prints each promise that is broken; the exit status is their number.
#include <malha/scene.h>
#include <malha/simulation.h>

#include <cmath>
#include <cstdio>
#include <functional>

namespace {

int broken = 0;

void promise(bool kept, const char* what) {
  if (kept) return;
  std::printf("broken: %s\n", what);
  ++broken;
}

/// Tells whether `call` is refused by a message with these words.
bool refuses(const char* words, const std::function<void()>& call) {
  try {
    call();
  } catch (const malha::InputError& error) {
    if (std::string(error.what()).find(words) != std::string::npos) return true;
    std::printf("found the refusal: %s\n", error.what());
  }
  return false;
}

/// A sheet of springs that hangs by one row.
malha::Scene hanging_sheet() {
  malha::Scene scene;
  scene.name = "hanging";
  scene.gravity = {0, -9.81, 0};
  malha::BodySpec sheet;
  sheet.name = "sheet";
  sheet.shape = malha::GridShape{{1, 1}, {20, 20}};
  sheet.density = 0.2;
  sheet.pins.push_back(malha::RowPin{});
  malha::ConstraintSpec springs;
  springs.type = "distance", springs.elements = {"edges", "shear"}, springs.compliance = 1e-3;
  sheet.constraints.push_back(springs);
  scene.bodies.push_back(sheet);
  return scene;
}

std::vector<malha::Vec3> after_a_second(const malha::Scene& scene) {
  malha::Simulation simulation(scene);
  while (simulation.time() < 1) simulation.step();
  return simulation.positions();
}

double largest_distance(const std::vector<malha::Vec3>& one, const std::vector<malha::Vec3>& other) {
  double most = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    most = std::max(most, std::hypot(one[i][0] - other[i][0], one[i][1] - other[i][1], one[i][2] - other[i][2]));
  return most;
}

void runs_scenes_of_a_program() {
  malha::Scene scene = hanging_sheet();
  scene.name = "draped";
  scene.bodies[0].pins.clear();
  scene.bodies[0].transform.translate = {-0.5, 0.1, -0.5};
  malha::EnvironmentSpec box;  // of triangles, so that Embree is called
  box.name = "box", box.shape = malha::BoxShape{{0.4, 0.2, 0.4}, std::array<int, 3>{4, 4, 4}};
  box.transform.translate = {0, -0.1, 0};
  scene.environment.push_back(box);
  malha::Simulation simulation(scene);
  while (simulation.time() < 0.5) simulation.step();
  const malha::Measures measures = simulation.measure();
  promise(measures.contacts > 0, "a sheet that falls onto a box touches it");
  promise(measures.penetration_max < 1e-3, "it stays outside");
}

void filters_without_metis() {
  malha::Scene scene = hanging_sheet();
  scene.solver.type = "desbrun", scene.solver.precision = malha::Precision::Double;
  scene.solver.desbrun.filter = malha::FilterKind::Sparse;
  const std::vector<malha::Vec3> sparse = after_a_second(scene);
  scene.solver.desbrun.filter = malha::FilterKind::Dense;
  const std::vector<malha::Vec3> dense = after_a_second(scene);
  promise(sparse[400][1] < -0.1, "the sheet swings");
  promise(largest_distance(sparse, dense) < 1e-6, "the sparse filter, in another order, moves it as the dense one");
}

void continues_from_a_checkpoint(const std::string& file) {
  const malha::Scene scene = hanging_sheet();
  malha::Simulation whole(scene), first(scene), second(scene);
  for (int step = 0; step < 20; ++step) whole.step();
  for (int step = 0; step < 10; ++step) first.step();
  first.save_checkpoint(file);
  second.load_checkpoint(file);
  for (int step = 0; step < 10; ++step) second.step();
  promise(second.state_hash() == whole.state_hash(), "a run that continues has the bits of one in one piece");
}

void refuses_what_is_not_there() {
  malha::Scene scene = hanging_sheet();
  promise(refuses("scene.json: found JSON, and this malha was built with MALHA_JSON=OFF",
                  [] { malha::parse_scene("{}", "scene.json", ""); }),
          "scene files are refused");
  promise(refuses("MALHA_JSON=OFF", [&] { malha::Simulation(scene).report("finished"); }), "reports are refused");
  scene.outputs.page.emplace();
  promise(refuses("/outputs/page: found a page, and this malha was built with MALHA_PAGES=OFF",
                  [&] { malha::Simulation simulation(scene); }),
          "pages are refused");
  scene.outputs = {}, scene.outputs.picture.emplace();
  promise(refuses("MALHA_PICTURES=OFF", [&] { malha::Simulation simulation(scene); }), "pictures are refused");
  scene.outputs = {}, scene.outputs.every = 1, scene.outputs.formats = {"glb"};
  promise(refuses("built without tinygltf", [&] { malha::Simulation simulation(scene); }), "glTF is refused");
}

void checks_scenes_without_a_parser() {
  malha::Scene scene = hanging_sheet();
  scene.bodies[0].density = -1;
  promise(refuses("/bodies/0/density: found -1; allowed: a number > 0", [&] { malha::Simulation simulation(scene); }),
          "a bad number is refused with its place");
  promise(malha::to_json(hanging_sheet()).find("\"elements\": [") != std::string::npos, "a scene can be written");
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) return std::fprintf(stderr, "usage: %s CHECKPOINT\n", arguments[0]), 100;
  try {
    runs_scenes_of_a_program();
    filters_without_metis();
    continues_from_a_checkpoint(arguments[1]);
    refuses_what_is_not_there();
    checks_scenes_without_a_parser();
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 101;
  }
  if (broken == 0) std::printf("the library alone keeps its promises\n");
  return broken;
}
