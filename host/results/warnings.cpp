#include "host/results/warnings.h"

#include <cmath>

#include "host/base/shown.h"
#include "host/results/boundaries.h"
#include "host/results/resolution.h"

namespace malha {

namespace {

// Where the study's trials turn from right to wrong.
constexpr double kSag = 0.5;           // strain of what swings
constexpr double kPaperTorque = 0.01;  // k h^2 / m
constexpr double kOffTorque = 0.2;     // k h^2 / m, for each solve of a substep
constexpr double kPinnedFall = 0.4;    // g h^2 / l
constexpr double kDamping = 0.2;       // of the critical

double percent(double part) { return std::round(100 * part); }

double two_digits(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

/// "malha study stability" and its chart.
std::string shown_by(const char* chart) { return std::string(" (malha study stability, chart ") + chart + ")"; }

}  // namespace

std::vector<std::string> warnings(const Model& model) {
  std::vector<std::string> lines;
  const Scene& scene = model.scene;
  const SolverSpec& solver = scene.solver;
  if (const std::string coarse = coarse_resolution(model, model.look.points); !coarse.empty())
    lines.push_back(coarse + shown_by("distance"));
  else if (unrounded_fall(model) < 1)
    lines.push_back("with " + counted(solver.substeps, "substep") +
                    " what gravity adds to a place in one is less than half the spacing of the numbers, and is "
                    "rounded away; take fewer, or \"precision\": \"double\"" +
                    shown_by("masses"));
  if (const Sag sag = worst_sag(model); sag.swinging > kSag)
    lines.push_back("body '" + scene.bodies[sag.body].name + "': with " + counted(solver.substeps, "substep") + " of " +
                    counted(solver.iterations, "iteration") + " what is next to its pins stretches by some " +
                    shown(percent(sag.strain)) + " % under its weight, and up to " + shown(percent(sag.swinging)) +
                    " % where it swings; take " +
                    (sag.soft ? "a \"compliance\" instead of its \"stiffness\"" + shown_by("stiffness")
                              : shown(std::ceil(solver.substeps * std::sqrt(sag.swinging / kSag))) +
                                    " substeps or more, or \"long_range\"" +
                                    shown_by(sag.of_faces ? "resolution" : "masses")));
  if (solver.type != "desbrun") return lines;
  const DesbrunSpec& spec = solver.desbrun;
  const Corrector corrector = spec.corrector.value_or(spec.refine > 0 ? Corrector::Off : Corrector::Inertia);
  const double most = corrector == Corrector::Paper ? kPaperTorque : kOffTorque * (1 + spec.refine);
  if (const double k = free_stiffness(model); corrector != Corrector::Inertia && k > most)
    lines.push_back(
        "k h^2 / m is up to " + shown(k) + " on free bodies, and above " + shown(most) + " corrector \"" +
        (corrector == Corrector::Paper ? "paper\" adds angular momentum" : "off\" takes their rotation away") +
        "; take \"corrector\": \"inertia\" or more substeps" + shown_by("torque"));
  if (const double fallen = pinned_fall(model); spec.internal_only && fallen > kPinnedFall)
    lines.push_back("\"filtered\": \"internal_only\" leaves springs next to pins some " + shown(percent(fallen)) +
                    " % too long; filter all, or take more substeps" + shown_by("weight"));
  if (const Swing swing = most_damped_swing(model); swing.damping > kDamping)
    lines.push_back("body '" + scene.bodies[swing.body].name + "': the filter damps its swinging about its pins, by " +
                    shown(two_digits(swing.damping)) +
                    " of what would be critical; take \"refine\", more substeps or \"type\": \"pbd\"" +
                    shown_by("turning"));
  return lines;
}

}  // namespace malha
