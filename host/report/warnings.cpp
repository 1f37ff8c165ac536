// SPDX-License-Identifier: Apache-2.0
#include "host/report/warnings.h"

#include <cmath>

#include "host/report/failure_boundaries.h"
#include "host/report/folds.h"
#include "host/report/heavy_on_light.h"
#include "host/report/resolution.h"
#include "host/report/softening.h"
#include "malha/text.h"

namespace malha {

namespace {

// Where the study's trials turn from right to wrong.
constexpr double kSwingingStrain = 0.5;  // strain of a swinging body
constexpr double kPaperTorque = 0.01;    // k h^2 / m
constexpr double kOffTorque = 0.2;       // k h^2 / m, for each solve of a substep
constexpr double kPinnedFall = 0.4;      // g h^2 / l
constexpr double kDamping = 0.2;         // of the critical
// Of cells a substep over the root of its iterations, by which nine beams under their weight sink too far: -4 to 10 %
// with one iteration and up to 22 % with more; 31 to 77 % at 0.4.
constexpr double kWave = 0.25;
constexpr double kSlowWave = 0.2;         // -2 to 5 %, up to 9 %
constexpr double kVolumeSoftening = 0.2;  // additional strain of tetrahedra, because of Poisson's ratio
constexpr double kLessVolumeSoftening = 0.1;
constexpr double kSoft = 0.1;  // of what a sheet gives way
constexpr double kLessSoft = 0.08;
constexpr double kEdgesOfAFold = 2;  // a clamped strip's drop over reach is then right within some per cent
constexpr double kHeavy = 10;        // of masses: let down from 24 mm on a block of 0.2 m, a block walks off by 0.08 m
constexpr int kLayers = 8;  // substeps, with which layers slide by Coulomb's law within 7 % (0.35 on 20 degrees)

double percent(double part) { return std::round(100 * part); }

/// "malha study stability" and its chart.
std::string shown_by(const char* chart) { return std::string(" (malha study stability, chart ") + chart + ")"; }

/// What would damp less: as few more substeps or refinements as that takes, where they are not too many.
std::string less_damped(const Model& model, const FilterDamping& filter) {
  constexpr double most_substeps = 1024, most_refine = 16;
  const double substeps = std::ceil(model.scene.solver.substeps * filter.damping / kDamping);
  const double more = std::ceil(std::log(kDamping / filter.damping) / std::log(filter.kept));
  const double refine = model.scene.solver.desbrun.refinement_iterations + more;
  std::string ways;
  if (refine <= most_refine) ways += "\"refinement_iterations\": " + shown(refine) + ", ";
  if (substeps <= most_substeps) ways += shown(substeps) + " substeps, ";
  return ways + (ways.empty() ? "" : "or ") + "\"type\": \"pbd\"";
}

}  // namespace

std::vector<std::string> warnings(const Model& model) {
  std::vector<std::string> lines = model.notes;
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  if (const std::string coarse = coarse_resolution(model, model.look.points); !coarse.empty())
    lines.push_back(coarse + shown_by("distance"));
  if (const PinStrain strain = worst_pin_strain(model); strain.swinging > kSwingingStrain)
    lines.push_back("body '" + scene.bodies[strain.body].name + "': with " + counted(solver.substeps, "substep") +
                    " of " + counted(solver.iterations, "iteration") + " what is next to its pins stretches by some " +
                    shown(percent(strain.strain)) + " % under its weight, and up to " +
                    shown(percent(strain.swinging)) + " % where it swings; take " +
                    (strain.swinging * strain.stiffness <= kSwingingStrain
                         ? "a \"compliance\" instead of its \"stiffness\"" + shown_by("stiffness")
                         : (strain.auto_level_threshold ? "\"levels\": \"auto\", or " : "") +
                               shown(std::ceil(solver.substeps * std::sqrt(strain.swinging / kSwingingStrain))) +
                               " substeps or more, or \"long_range\"" +
                               shown_by(strain.of_faces ? "resolution" : "masses")));
  if (const ShearWave wave = fastest_shear_wave(model); wave.cells > kWave)
    lines.push_back("body '" + scene.bodies[wave.body].name + "': a shear wave gets through " +
                    shown(two_digits(wave.cells * std::sqrt(solver.iterations))) + " of its cells in a substep of " +
                    counted(solver.iterations, "iteration") +
                    ", and its material will be softer than asked for, by more "
                    "than a tenth beyond " +
                    shown(two_digits(kWave * std::sqrt(solver.iterations))) + "; take " +
                    shown(std::ceil(solver.substeps * wave.cells / kSlowWave)) +
                    " substeps (scenes/README.md, Tetrahedra)");
  else if (const VolumeSoftening softening = worst_volume_softening(model); softening.share > kVolumeSoftening)
    lines.push_back("body '" + scene.bodies[softening.body].name + "': with " + counted(solver.substeps, "substep") +
                    " of " + counted(solver.iterations, "iteration") + " its material of \"poisson_ratio\" " +
                    shown(softening.poisson_ratio) + " gives way by some " + shown(two_digits(100 * softening.share)) +
                    " % more than asked for; take " +
                    shown(std::ceil(solver.substeps *
                                    std::sqrt(softening.share / (1 - softening.share / 4) / kLessVolumeSoftening))) +
                    " substeps, or a smaller \"poisson_ratio\" (scenes/accuracy.md, Tetrahedra)");
  if (const Softening soft = worst_softening(model); soft.share > kSoft)
    lines.push_back("body '" + scene.bodies[soft.body].name + "': with " + counted(solver.substeps, "substep") +
                    " of " + counted(solver.iterations, "iteration") + " its \"" + soft.type + "\" gives way " +
                    (soft.share < 1 ? "by some " + shown(two_digits(100 * soft.share)) + " % more than asked for"
                                    : "some " + shown(two_digits(1 + soft.share)) + " times as far as asked for") +
                    "; take " + shown(std::ceil(solver.substeps * std::sqrt(soft.share / kLessSoft))) +
                    " substeps, or a softer material (scenes/README.md, materials)");
  if (const HangingFold fold = sharpest_fold(model); fold.spacing > 0 && fold.edges() < kEdgesOfAFold)
    lines.push_back("body '" + scene.bodies[fold.body].name + "': where it is held its weight folds it over " +
                    shown(two_digits(fold.length)) + " m, which is " + shown(two_digits(fold.edges())) +
                    " of its edges there, and it will hang otherwise than its material does; take edges of " +
                    shown(two_digits(fold.length / kEdgesOfAFold)) +
                    " m there, or stiffer bending (scenes/accuracy.md, Materials)");
  if (scene.self_collision && solver.substeps < kLayers)
    lines.push_back(
        "with " + counted(solver.substeps, "substep") +
        " layers in self-contact slide otherwise than by Coulomb's law, by tens of per cent with one or two; "
        "take " +
        shown(kLayers) + " or more (scenes/README.md, Self-collision)");
  if (const HeavyOnLight pair = worst_heavy_on_light(model); pair.ratio >= kHeavy)
    lines.push_back(
        "body '" + scene.bodies[pair.heavy].name + "' falls on body '" + scene.bodies[pair.light].name +
        "' and weighs " + shown(two_digits(pair.ratio)) + " times as much; from " + shown(kHeavy) +
        " times on, where nothing damps its bouncing, it walks off; lay it on, or give \"wind\" a \"drag\" of " +
        shown(two_digits(pair.drag)) + " N s/m (scenes/accuracy.md, Rest, weights and distance)");
  if (solver.type != "desbrun") return lines;
  const DesbrunSpec& spec = solver.desbrun;
  const Corrector corrector = spec.corrects();
  const double most = corrector == Corrector::Paper ? kPaperTorque : kOffTorque * (1 + spec.refinement_iterations);
  if (const double k = corrector != Corrector::Inertia ? free_stiffness(model) : 0; k > most)
    lines.push_back(
        "k h^2 / m is up to " + shown(k) + " on free bodies, and above " + shown(most) + " corrector \"" +
        (corrector == Corrector::Paper ? "paper\" adds angular momentum" : "off\" takes their rotation away") +
        "; take \"corrector\": \"inertia\" or more substeps" + shown_by("torque"));
  if (const double fallen = spec.filter_external_forces ? 0 : pinned_fall(model); fallen > kPinnedFall)
    lines.push_back("\"filter_external_forces\": false leaves springs next to pins some " + shown(percent(fallen)) +
                    " % too long; filter all, or take more substeps" + shown_by("weight"));
  if (const FilterDamping filter = worst_filter_damping(model); filter.damping > kDamping)
    lines.push_back("body '" + scene.bodies[filter.body].name + "': the filter damps its swinging about its pins, by " +
                    shown(two_digits(filter.damping)) + " times what is critical; take " + less_damped(model, filter) +
                    shown_by("turning"));
  return lines;
}

}  // namespace malha
