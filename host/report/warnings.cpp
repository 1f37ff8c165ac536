// SPDX-License-Identifier: Apache-2.0
#include "host/report/warnings.h"

#include <algorithm>
#include <cmath>

#include "host/model/softening.h"
#include "host/report/failure_boundaries.h"
#include "host/report/resolution.h"
#include "malha/text.h"

namespace malha {

namespace {

// Boundaries at which the trials of the study turn from right to wrong.
constexpr double kSwingingStrain = 0.5;  // strain while swinging
constexpr double kPaperTorque = 0.01;    // k h^2 / m
constexpr double kOffTorque = 0.2;       // k h^2 / m, for each solve of a substep
constexpr double kPinnedFall = 0.4;      // g h^2 / l
constexpr double kDamping = 0.2;         // ratio to critical damping
// Cells that a shear wave travels in a substep over the root of the iterations. At 0.25, nine beams sag under their
// weight by -4 to 10 % too far with one iteration and by up to 22 % with more; at 0.4, by 31 to 77 %.
constexpr double kShearWave = 0.25;
constexpr double kAdvisedShearWave = 0.2;  // here they sag by -2 to 5 % too far, and up to 9 % with more iterations
constexpr double kVolumeSoftening = 0.2;   // excess deformation of tetrahedra because of Poisson's ratio
constexpr double kAdvisedVolumeSoftening = 0.1;
constexpr double kSoftening = 0.1;  // excess deformation of a sheet
constexpr double kAdvisedSoftening = 0.08;
constexpr double kEdgesOfAFold = 2;  // a clamped strip's drop over reach is then right within some per cent
constexpr double kMassRatio =
    10;  // dropped from 24 mm on a block of 0.2 m, a block of this mass ratio drifts by 0.08 m
constexpr int kSubstepsOfLayers =
    8;  // substeps, with which layers slide by Coulomb's law within 7 % (0.35 on 20 degrees)

// Substeps of 1/60 s with which a strip that is pressed onto rough ground slips at the right force within 6 %, with
// fewer than kManyIterations and with as many (filtered bending, mu 0.1 to 0.3, stick and slip of `malha study
// validation`). On irregular triangles it is 12 % with 6 substeps, 16 % with 3 of 4 iterations, and 65 % with 4, or 1
// of 10.
constexpr int kSubstepsOfFriction = 8, kSubstepsOfFrictionByMany = 4, kManyIterations = 4;

double percent(double part) { return std::round(100 * part); }

/// The reference to a chart of `malha study stability`.
std::string shown_by(const char* chart) { return std::string(" (malha study stability, chart ") + chart + ")"; }

/// The advice against damping: the fewest substeps or refinements that suffice, where they are not too many.
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

/// The warning of too few substeps for friction of the environment; empty without it.
std::string friction_warning(const Scene& scene) {
  const SolverSpec& solver = scene.solver;
  const auto is_rough = [](const EnvironmentSpec& object) { return object.friction > 0; };
  const int in_a_frame = solver.iterations < kManyIterations ? kSubstepsOfFriction : kSubstepsOfFrictionByMany;
  const double needed = std::ceil(in_a_frame * 60 * solver.dt - 1e-3);  // 1e-3: a step of 0.0166667 s is 1/60 s
  if (solver.type != "pbd" || solver.substeps >= needed || std::ranges::none_of(scene.environment, is_rough)) return "";
  return "with " + counted(solver.substeps, "substep") + " of " + counted(solver.iterations, "iteration") +
         " bodies that friction holds slip at a force that is off by a tenth or more; take " + shown(needed) +
         " substeps or more (scenes/accuracy.md, Held against the outside)";
}

}  // namespace

std::vector<std::string> warnings(const Model& model) {
  std::vector<std::string> lines = model.notes;
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  if (const std::string coarse = resolution_warning(model, model.render_mesh.points); !coarse.empty())
    lines.push_back(coarse + shown_by("distance"));
  if (const PinStrain strain = worst_pin_strain(model); strain.swinging > kSwingingStrain)
    lines.push_back(
        "body '" + scene.bodies[strain.body].name + "': with " + counted(solver.substeps, "substep") + " of " +
        counted(solver.iterations, "iteration") + " the constraints next to its pins stretch by some " +
        shown(percent(strain.strain)) + " % under its weight, and by up to " + shown(percent(strain.swinging)) +
        " % while it swings; take " +
        (strain.swinging * strain.stiffness <= kSwingingStrain
             ? "a \"compliance\" instead of its \"stiffness\"" + shown_by("stiffness")
             : (strain.auto_levels_act ? "\"levels\": \"auto\", or " : "") +
                   shown(std::ceil(solver.substeps * std::sqrt(strain.swinging / kSwingingStrain))) +
                   " substeps or more, or \"long_range\"" + shown_by(strain.of_faces ? "resolution" : "masses")));
  if (const ShearWave wave = fastest_shear_wave(model); wave.cells > kShearWave)
    lines.push_back("body '" + scene.bodies[wave.body].name + "': a shear wave travels through " +
                    shown(two_digits(wave.cells * std::sqrt(solver.iterations))) + " of its cells in a substep of " +
                    counted(solver.iterations, "iteration") +
                    ", and its material will be softer than specified, by more "
                    "than a tenth beyond " +
                    shown(two_digits(kShearWave * std::sqrt(solver.iterations))) + "; take " +
                    shown(std::ceil(solver.substeps * wave.cells / kAdvisedShearWave)) +
                    " substeps (scenes/README.md, Tetrahedra)");
  else if (const VolumeSoftening volume = worst_volume_softening(model); volume.share > kVolumeSoftening)
    lines.push_back(
        "body '" + scene.bodies[volume.body].name + "': with " + counted(solver.substeps, "substep") + " of " +
        counted(solver.iterations, "iteration") + " its material of \"poisson_ratio\" " + shown(volume.poisson_ratio) +
        " deforms by some " + shown(two_digits(100 * volume.share)) + " % more than specified; take " +
        shown(std::ceil(solver.substeps * std::sqrt(volume.share / (1 - volume.share / 4) / kAdvisedVolumeSoftening))) +
        " substeps, or a smaller \"poisson_ratio\" (scenes/accuracy.md, Tetrahedra)");
  if (const Softening soft = worst_softening(model); soft.share > kSoftening)
    lines.push_back("body '" + scene.bodies[soft.body].name + "': with " + counted(solver.substeps, "substep") +
                    " of " + counted(solver.iterations, "iteration") + " its \"" + soft.type + "\" deforms " +
                    (soft.share < 1 ? "by some " + shown(two_digits(100 * soft.share)) + " % more than specified"
                                    : "some " + shown(two_digits(1 + soft.share)) + " times as much as specified") +
                    "; take " + shown(std::ceil(solver.substeps * std::sqrt(soft.share / kAdvisedSoftening))) +
                    " substeps, or a softer material (scenes/README.md, materials)");
  if (scene.solver.type == "pbd")
    for (const ConstraintSet& set : model.stencils) {
      const BendingStep step = bending_step(model, set);
      const std::string its = "body '" + scene.bodies[body_of(model, model.user_index[set.particles[0]])].name +
                              "': its \"" + set.type + "\" is ";
      if (step.turning > kMostTurning)
        lines.push_back(its +
                        "folded too sharply at rest for its stiffness, and filtered it may gain energy on impact; take "
                        "\"bending\": \"auto\", or " +
                        shown(std::ceil(solver.substeps * step.turning / kMostTurning)) +
                        " substeps (scenes/README.md, Filtered bending)");
      if (solver.precision == Precision::Float && step.s > kExactInFloat)
        lines.push_back(its + "too stiff for a filter in float; take \"precision\": \"double\", or " +
                        shown(std::ceil(solver.substeps * std::sqrt(step.s / kExactInFloat))) +
                        " substeps (scenes/README.md, Filtered bending)");
    }
  if (const HangingFold fold = sharpest_fold(model); fold.spacing > 0 && fold.edges() < kEdgesOfAFold)
    lines.push_back("body '" + scene.bodies[fold.body].name + "': next to its clamp or pins its weight bends it over " +
                    shown(two_digits(fold.length)) + " m, which spans " + shown(two_digits(fold.edges())) +
                    " of its edges, too few for its material; take edges of " +
                    shown(two_digits(fold.length / kEdgesOfAFold)) +
                    " m there, or stiffer bending (scenes/accuracy.md, Materials)");
  if (scene.self_collision && solver.substeps < kSubstepsOfLayers)
    lines.push_back(
        "with " + counted(solver.substeps, "substep") +
        " friction between layers in self-contact deviates from Coulomb's law, by tens of per cent with one or two; "
        "take " +
        shown(kSubstepsOfLayers) + " or more (scenes/README.md, Self-collision)");
  if (const std::string rough = friction_warning(scene); !rough.empty()) lines.push_back(rough);
  if (const HeavyOnLight pair = worst_heavy_on_light(model); pair.ratio >= kMassRatio)
    lines.push_back(
        "body '" + scene.bodies[pair.heavy].name + "' falls on body '" + scene.bodies[pair.light].name +
        "' and weighs " + shown(two_digits(pair.ratio)) + " times as much; from a ratio of " + shown(kMassRatio) +
        " on, undamped bounces make it drift off sideways; lay it on without a fall, or give \"wind\" a \"drag\" of " +
        shown(two_digits(pair.drag)) + " N s/m (scenes/accuracy.md, Rest, weights and distance)");
  if (solver.type != "desbrun") return lines;
  const DesbrunSpec& spec = solver.desbrun;
  const Corrector corrector = spec.corrects();
  const double most = corrector == Corrector::Paper ? kPaperTorque : kOffTorque * (1 + spec.refinement_iterations);
  if (const double k = corrector != Corrector::Inertia ? max_free_stiffness(model) : 0; k > most)
    lines.push_back("k h^2 / m is up to " + shown(k) + " on free bodies; above " + shown(most) + " the corrector \"" +
                    (corrector == Corrector::Paper ? "paper\" adds angular momentum" : "off\" damps their rotation") +
                    "; take \"corrector\": \"inertia\" or more substeps" + shown_by("torque"));
  if (const double fallen = spec.filter_external_forces ? 0 : pinned_spring_strain(model); fallen > kPinnedFall)
    lines.push_back("\"filter_external_forces\": false leaves springs next to pins some " + shown(percent(fallen)) +
                    " % too long; set it to true, or take more substeps" + shown_by("weight"));
  if (const FilterDamping filter = worst_filter_damping(model); filter.damping > kDamping)
    lines.push_back("body '" + scene.bodies[filter.body].name +
                    "': the filter damps its swinging about its pins with " + shown(two_digits(filter.damping)) +
                    " times the critical damping; take " + less_damped(model, filter) + shown_by("turning"));
  return lines;
}

}  // namespace malha
