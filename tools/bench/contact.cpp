// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/contact.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/stopwatch.h"
#include "host/solver/solver.h"
#include "kernels/environment/proximity_cache.h"
#include "malha/simulation.h"
#include "malha/text.h"
#if defined(MALHA_HAS_BULLET)
#include "tools/bench/peers/bullet_drape.h"
#endif
#include "tools/bench/facts.h"
#include "tools/bench/machine.h"
#include "tools/bench/medians.h"
#include "tools/bench/output.h"

namespace malha::bench {

namespace {

using Json = nlohmann::ordered_json;

/// A scene, and how many steps it runs before the measurement, so that many particles are in contact by then.
struct ContactCase {
  std::string name;
  int warm_up;
  // For a cloth on a turning scan: the scan's mesh and scale, and the cloth's cells a side.
  std::string scan = {};
  double scale = 0;
  int cells = 0;
};

const std::vector<ContactCase>& all_contact_cases() {
  static const std::vector<ContactCase> all{{"drape_bunny", 60},
                                            {"soft_bunny", 60},
                                            {"ramp", 10},
                                            {"rotating_sphere", 60},
                                            {"bullets", 0},
                                            {"thin_wall", 5},
                                            {"sheet_on_mesh", 60},
                                            {"sheet_on_plane", 60},
                                            {"armadillo", 20, "armadillo", 0.006, 199},
                                            {"elephant", 20, "refined_elephant", 1.2, 199},
                                            {"armadillo_100000", 20, "armadillo", 0.006, 315}};
  return all;
}

/// Median time of a frame by Bullet in ms, which starts in the state of the simulation. NaN if `frames` is 0, if the
/// case is no cloth on a mesh, or if malha was built without Bullet.
double bullet_ms([[maybe_unused]] const ContactCase& which, [[maybe_unused]] const Simulation& simulation,
                 [[maybe_unused]] int frames) {
#if defined(MALHA_HAS_BULLET)
  const bool is_drape = which.name == "drape_bunny" || !which.scan.empty();
  if (frames == 0 || !is_drape) return NAN;
  BulletDrape drape(simulation);
  std::vector<double> ms;
  for (int frame = 0; frame < frames; ++frame) ms.push_back(1e3 * thread_seconds([&] { drape.step(); }));
  return median(ms);
#else
  return NAN;
#endif
}

/// A cloth of 1.6 m falls onto a scan that turns at 450 degrees/s.
Scene turning_scan(const ContactCase& which, const std::string& folder) {
  Scene scene;
  scene.file = "malha bench", scene.name = which.name, scene.gravity = {0, -9.81, 0};
  scene.solver.substeps = 30;
  BodySpec cloth;
  cloth.name = "cloth", cloth.shape = GridShape{{1.6, 1.6}, {which.cells, which.cells}}, cloth.density = 0.2;
  cloth.transform.translate = {-0.8, 0.6, -0.8};
  ConstraintSpec distance, bending;
  distance.type = "distance", distance.elements = {"edges", "shear"};
  bending.type = "bending", bending.stiffness = 0.02;
  cloth.constraints = {distance, bending};
  scene.bodies = {cloth};
  EnvironmentSpec scan;
  scan.name = which.scan, scan.shape = MeshFile{folder + "/meshes/scans/" + which.scan + ".off"};
  scan.transform.scale = {which.scale, which.scale, which.scale};
  scan.thickness = 0.008, scan.friction = 0.3;
  scan.motion = {{0, {0, 0, 0}, {0, 1, 0}, 0}, {10, {0, 0, 0}, {0, 1, 0}, 4500}};
  scene.environment = {scan};
  return scene;
}

/// A cloth of 10,000 particles at rest on the ground: two triangles, or a plane.
Scene sheet_on(const ContactCase& which) {
  Scene scene;
  scene.file = "malha bench", scene.name = which.name, scene.gravity = {0, -9.81, 0};
  BodySpec cloth;
  cloth.name = "cloth", cloth.shape = GridShape{{2, 2}, {99, 99}}, cloth.density = 0.2;
  cloth.transform.translate = {-1, 0.005, -1};
  ConstraintSpec distance;
  distance.type = "distance", distance.elements = {"edges", "shear"};
  cloth.constraints = {distance};
  scene.bodies = {cloth};
  EnvironmentSpec ground;
  ground.name = "ground", ground.friction = 0.5, ground.shape = PlaneShape{};
  if (which.name == "sheet_on_mesh") {
    ground.shape = GridShape{{6, 6}, {1, 1}}, ground.sides = Sides::OneSided;
    ground.transform.translate = {-3, 0, -3};
  }
  scene.environment = {ground};
  return scene;
}

/// The case's scene without self-collision, which this benchmark does not measure.
Scene contact_scene(const ContactCase& which, const std::string& folder) {
  if (which.name.starts_with("sheet_on_")) return sheet_on(which);
  if (!which.scan.empty()) return turning_scan(which, folder);
  Scene scene = load_scene(folder + "/" + which.name + ".json");
  scene.self_collision.reset(), scene.expect = {};
  return scene;
}

double process_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double contact_seconds(const Solver& solver) {
  const auto& passes = solver.pass_seconds();
  return passes[static_cast<int>(Pass::Collision)] + passes[static_cast<int>(Pass::Contact)];
}

struct ContactRun {
  Simulation simulation;
  int threads;
  std::string hash_after_warm_up = {};
  ContactStats at_start{};
  std::int64_t first = 0;  // first measured step
  // One value a turn: ns per particle and substep of the two passes (wall clock), ms per step (wall clock), and ms of
  // processor time per step.
  std::vector<double> contact = {}, step = {}, processor = {};
};

/// Runs steps for at least `min_seconds` and adds their times.
void run_contact_turn(ContactRun& line, double min_seconds) {
  const Solver& solver = line.simulation.solver();
  const double before = contact_seconds(solver), processor = process_seconds();
  const std::int64_t first = line.simulation.steps();
  const double step = mean_seconds([&] { line.simulation.step(); }, min_seconds);
  const auto steps = static_cast<double>(line.simulation.steps() - first);
  const double per =
      1e9 / (static_cast<double>(line.simulation.model().scene.solver.substeps) * line.simulation.model().count());
  line.contact.push_back((contact_seconds(solver) - before) / steps * per);
  line.step.push_back(1e3 * step);
  line.processor.push_back(1e3 * (process_seconds() - processor) / steps);
}

/// Bytes that must move per particle and substep, whatever detects the contacts: for meshes both first tests read each
/// particle's previous position, position and prediction (18 numbers), and one slot of each near particle is read and
/// written. For exact shapes both tests read its position, displacement and mass (10 numbers), and the 10 numbers of
/// each contact are written and read.
double floor_bytes(const ContactRun& line, const ContactStats& facts) {
  const Model& model = line.simulation.model();
  const bool in_double = model.scene.solver.precision == Precision::Double;
  const double number = in_double ? 8 : 4;
  const double slot = sizeof(ProximityRecord) + (in_double ? sizeof(Contact<double>) : sizeof(Contact<float>));
  const auto meshes = static_cast<double>(mesh_count(model));
  const double shapes = mesh_count(model) < model.environment.size() ? 1 : 0;
  return meshes * 2 * (6 * number + 16) + 2 * slot * facts.near / model.count() + shapes * 2 * (10 + 10) * number;
}

Json contact_row(const ContactCase& which, const ContactRun& line, double gb_per_s, double bullet) {
  const Model& model = line.simulation.model();
  const ContactStats facts = line.simulation.solver().facts().contact.value_or(ContactStats{});
  const auto steps = static_cast<double>(line.simulation.steps() - line.first);
  const double n = model.count(), each = facts.near > 0 ? static_cast<double>(facts.near_bytes) / facts.near : 0;
  const double meshes = std::max<double>(1, static_cast<double>(mesh_count(model)));
  return {
      {"case", which.name},
      {"particles", model.count()},
      {"threads", line.threads},
      {"contact_ns_per_particle_and_substep", median(line.contact)},
      {"step_ms", median(line.step)},
      {"processor_ms_per_step", median(line.processor)},
      {"list_queries_per_step", static_cast<double>(facts.closest_point_queries - line.at_start.closest_point_queries -
                                                    facts.full_queries + line.at_start.full_queries) /
                                    steps},
      {"full_queries_per_step", static_cast<double>(facts.full_queries - line.at_start.full_queries) / steps},
      {"near_particles", facts.near},
      {"bytes_per_far_particle", static_cast<double>(facts.far_bytes) / (n * meshes)},
      {"bytes_per_near_particle", each + static_cast<double>(facts.far_bytes) / (n * meshes)},
      {"bytes_of_lists", facts.cell_bytes},
      {"floor_ns_per_particle_and_substep", floor_bytes(line, facts) / gb_per_s},
      {"bullet_ms_per_step", std::isnan(bullet) ? Json() : Json(bullet)},
      {"state_hash_after_warm_up", line.hash_after_warm_up}};
}

std::string printed_contact(const Json& row) {
  const auto number = [&](const char* key) { return row[key].get<double>(); };
  return formatted("%-17s %7.0f %3.0f %9.1f %7.1f %9.2f %9.2f %9.0f %9.0f %7.0f %6.0f %6.0f %8.2f %9s\n",
                   row["case"].get<std::string>().c_str(), number("particles"), number("threads"),
                   number("contact_ns_per_particle_and_substep"), number("floor_ns_per_particle_and_substep"),
                   number("step_ms"), number("processor_ms_per_step"), number("list_queries_per_step"),
                   number("full_queries_per_step"), number("near_particles"), number("bytes_per_far_particle"),
                   number("bytes_per_near_particle"), number("bytes_of_lists") / (1 << 20),
                   row["bullet_ms_per_step"].is_null() ? "-" : formatted("%.0f", number("bullet_ms_per_step")).c_str());
}

}  // namespace

const std::vector<std::string>& contact_cases() {
  static const std::vector<std::string> names = case_names(all_contact_cases());
  return names;
}

void run_contact(const ContactOptions& options) {
  const std::vector<int> threads = thread_counts(options);
  Output out("contact", options);
  out.facts = machine_facts(threads, options.on);
  out.print(
      formatted(
          "Contact with the environment: wall time of the passes collision and contact, in ns per particle "
          "and substep, and its floor,\nthe bytes that must move at the triad's bandwidth. %d x %g s a line, in turns; "
          "medians.\n",
          options.repeats, options.seconds) +
      machine_lines(out.facts, "") +
      "case            particles thr   contact   floor   step ms processor   by list   queries    near  far B "
      "near B lists MiB Bullet ms\n");
  Json rows = Json::array();
  for (const ContactCase& which : all_contact_cases()) {
    if (!options.cases.empty() &&
        std::find(options.cases.begin(), options.cases.end(), which.name) == options.cases.end())
      continue;
    const Scene scene = contact_scene(which, options.scenes);
    std::vector<ContactRun> lines;
    for (const int count : threads) {
      out.show_progress(which.name, double(lines.size()) / double(threads.size()));
      lines.push_back({Simulation(scene, options.on.simulation_options(count, true)), count});
      ContactRun& line = lines.back();
      for (int step = 0; step < which.warm_up; ++step) line.simulation.step();
      line.first = which.warm_up;
      if (which.warm_up > 0) line.at_start = line.simulation.solver().facts().contact.value_or(ContactStats{});
      line.hash_after_warm_up = hex(line.simulation.state_hash());
    }
    const double bullet = bullet_ms(which, lines.front().simulation, options.bullet_frames);
    for (int turn = 0; turn < options.repeats; ++turn) {
      out.show_progress(which.name, double(turn) / options.repeats);
      for (ContactRun& line : lines) run_contact_turn(line, options.seconds);
    }
    for (const ContactRun& line : lines) {
      rows.push_back(contact_row(
          which, line, memory_gb_per_s(out.facts, options.on.is_device(), kMemoryBytes, line.threads), bullet));
      out.print(printed_contact(rows.back()));
    }
    out.write(rows);
  }
  out.list();
}

}  // namespace malha::bench
