# SPDX-License-Identifier: Apache-2.0
"""Work-precision diagrams: error over cost of every method, beside explicit and implicit integrators in double.

Each case is a body of springs or tetrahedra whose true motion or equilibrium is known in closed form, or from a
Runge-Kutta run with a converged step. Each method runs it at several costs; its error is the RMS distance of the
particles from the truth.

    PYTHONPATH=build/release /usr/bin/python3 tools/study/accuracy.py --quick

To add a case, write a function that returns make_case(...) and add it to cases(). To add a method, add its series to
methods(). The other integrators are those of the module _malha_reference (tools/study/reference/module.cpp), because
their processor time is measured, too.
"""
import functools
import itertools
import json
import math
import pathlib
import statistics
import sys
import time
import types

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

studies.require("_malha_reference")

import _malha_reference as reference  # noqa: E402
import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

plt.rcParams["figure.max_open_warning"] = 0  # a study keeps its figures until it writes them

G = 9.81  # m/s^2
FRAME = 1 / 60  # s: the step of all methods, which they divide into substeps
PERTURBATION = 1e-14  # m: about the accumulated rounding error of positions of some metres
CHAOTIC = 1e-3  # m: uncertainty above which a motion counts as chaotic, or its reference as not converged


# ---- Cases -----------------------------------------------------------------------------------------------------------


def make_case(name, title, what, shape, constraints, *, gravity=(0, -G, 0), pins=(), **more):
    """A case: a scene of one body whose distance constraints have a compliance, and how it is measured.

    more: fields of the case other than their defaults below, and keys of the body.
    """
    made = types.SimpleNamespace(
        name=name, title=title, what=what,
        times=[1, 5],  # s, multiples of 0.1 s: when errors are measured
        exact=None,  # closed form: a function of the time (s) that returns x (N, 3), m, and v (N, 3), m/s
        reference=0,  # substeps a frame of the reference run where there is no closed form
        at_rest=False,  # the equilibrium is compared that damped motion reaches
        taut=False,  # prestressed: the energy of the springs at the start is not part of the motion's
        bends=False,  # it has a bending rigidity, which PBD can filter
        tetrahedra=False,  # methods for springs only are left out
        # Largest cost of each kind; 0: the kind is left out. Substeps or iterations a frame of malha's sweeps, solves of
        # the filter, of the dense filter (0: no variant at all), refinements, and substeps of the other integrators.
        sweeps=1024, solves=256, dense=64, refinements=16, euler=1024, rk4=256, newton=16,
        newton_end=math.inf,  # s: how long Newton's method is run
        discretisation_error=0,  # m: distance of the continuous equilibrium from that of the springs
        expected="")  # a sentence about the equilibrium
    for key in [key for key in more if hasattr(made, key)]:
        setattr(made, key, more.pop(key))
    made.body = {"name": name, "shape": shape, "pins": list(pins), "constraints": constraints} | more
    made.scene = {"name": name, "duration": 1, "gravity": list(gravity), "bodies": [made.body]}
    return made


def scene_by(case, solver, compliant=True):
    """The scene of a case with this solver. compliant: whether the springs keep their compliance; else k = 1 by PBD."""
    body = case.body if compliant else case.body | {"constraints": [
        {key: value for key, value in one.items() if key != "compliance"} for one in case.body["constraints"]]}
    return case.scene | {"bodies": [body], "solver": {"dt": FRAME} | solver}


def system_of(case):
    """The equations of motion of a case."""
    return reference.System(json.dumps(scene_by(case, {"type": "pbd"})))


def springs(stiffness, elements, rest_scale=1):
    """Springs of a stiffness in N/m."""
    return {"type": "distance", "elements": elements, "compliance": 1 / stiffness, "rest_scale": rest_scale}


def mass_on_a_spring(name, title, what, exact, **more):
    """1 kg on a spring of 1000 N/m and 1 m, pinned at the other end, starts at 1.5 m (XPBD 2016, section 6).

    exact: a function of the time (s) that returns the position and velocity of the mass.
    """
    return make_case(name, title, what, {"chain": {"from": [0, 0, 0], "to": [1.5, 0, 0], "segments": 1}},
                     [springs(1000, ["edges"], 1 / 1.5)], mass=2,  # half of the mass is at each end
                     gravity=(0, 0, 0), pins=[{"particles": [0]}],
                     exact=lambda t: tuple(np.array([[0, 0, 0], moving]) for moving in exact(t)), **more)


def oscillator():
    w = math.sqrt(1000)
    return mass_on_a_spring("oscillator", "A mass on a spring, to and fro",
                            "1 kg on a spring of 1000 N/m and 1 m, released at 1.5 m: five periods a second.",
                            lambda t: ([1 + 0.5 * math.cos(w * t), 0, 0], [-0.5 * w * math.sin(w * t), 0, 0]))


def orbit():
    w = math.sqrt(1000 * 0.5 / 1.5)  # a stretch of 0.5 m keeps 1 kg on a circle of 1.5 m
    return mass_on_a_spring("orbit", "A mass on a spring, round and round",
                            "The same spring on a circle of 1.5 m, whose centripetal force is that of the stretch.",
                            lambda t: ([1.5 * math.cos(w * t), 1.5 * math.sin(w * t), 0],
                                       [-1.5 * w * math.sin(w * t), 1.5 * w * math.cos(w * t), 0]), velocity=[0, 1.5 * w, 0])


def square(name, title, what, n, stiffness, rest_scale=1, **more):
    """A sheet of n x n particles with springs along edges and diagonals, horizontal at the start."""
    return make_case(f"{name}{n}", f"{title} of {n} x {n} particles",
                     f"1 m and 0.2 kg, springs of {stiffness:g} N/m along edges and diagonals, {what}",
                     {"grid": {"size": [1, 1], "cells": [n - 1, n - 1]}}, [springs(stiffness, ["edges", "shear"], rest_scale)],
                     mass=0.2, **more)


def sheet(n, stiffness, reference):
    return square("sheet", "A sheet", "pinned at one side and released horizontally.", n, stiffness, pins=[{"row": "first"}],
                  reference=reference)


def drum(n, reference):
    """A sheet whose springs are under tension, at rest and in motion, so that nothing buckles."""
    e = 1e-6
    return square("drum", "A taut sheet",
                  "pinned at its four sides and horizontal. Its springs are a tenth shorter at rest than at the start, and the "
                  "weight makes it oscillate under tension throughout. Newton's method, whose factors are expensive here, is run "
                  "for 1 s only.", n, 5, 0.9, reference=reference, taut=True, newton_end=1,
                  pins=[{"row": "first"}, {"row": "last"}, {"box": {"min": [-e, -1, -1], "max": [e, 1, 2]}},
                        {"box": {"min": [1 - e, -1, -1], "max": [1 + e, 1, 2]}}])


def shell(subdivisions, reference):
    """A free shell that turns and, because it starts at its rest lengths, pulsates."""
    return make_case("shell", "A free body: a turning shell",
                     "A sphere of 0.5 m and 1 kg of springs of 100 N/m, thrown and turning at 3.7 rad/s without gravity.",
                     {"sphere": {"radius": 0.5, "subdivisions": subdivisions}}, [springs(100, ["edges"])], gravity=(0, 0, 0),
                     mass=1, velocity=[0.3, 0.2, -0.1], spin=[2, 3, -1], reference=reference)


CHAIN_MASS, CHAIN_EA = 0.1, 12.5  # kg, N


def chain(segments, reference=0):
    return make_case("chain", "A chain released between two pins",
                     f"{segments} springs, 1 m and 0.1 kg, EA = {CHAIN_EA:g} N, straight and slack at the start.",
                     {"chain": {"from": [0, 0, 0], "to": [1, 0, 0], "segments": segments}},
                     [springs(CHAIN_EA * segments, ["edges"])], mass=CHAIN_MASS, pins=[{"particles": [0, segments]}],
                     reference=reference)


def at_rest(case, name, title, what, equilibrium, mass, slowest):
    """The case with air drag on its particles, compared after 5 s with its equilibrium (N, 3), m.

    slowest: the frequency of the slowest mode, rad/s, which the drag damps about critically.
    """
    case.scene["wind"] = {"velocity": [0, 0, 0], "drag": 2 * slowest * mass / len(equilibrium)}
    vars(case).update(name=name, title=title, what=what, at_rest=True, times=[5],
                      exact=lambda t: (equilibrium, np.zeros_like(equilibrium)))
    return case


def elastic_catenary(span, length, weight, EA, points):
    """The elastic catenary (Irvine, Cable Structures, 1981, section 1.3) between (0, 0) and (span, 0): (points + 1, 3), m.

    The points divide a line of unstretched length (m), total weight (N) and stiffness EA (N) evenly.
    """
    def place(s, H):
        """The point at s m along the unstretched line, under the horizontal force H."""
        V = weight / 2
        below, a = V - weight * s / length, H * length / weight  # below: vertical force at s
        return [H * s / EA + a * (math.asinh(V / H) - math.asinh(below / H)),
                -weight * s / EA * (V / weight - s / (2 * length)) - a * (math.hypot(1, V / H) - math.hypot(1, below / H)), 0]

    low, high = 1e-9 * weight, 1e9 * weight  # the span grows with the force
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if place(length, middle)[0] < span else (low, middle)
    return np.array([place(length * k / points, low) for k in range(points + 1)])


def catenary(segments):
    line, hung = elastic_catenary(1, 1, CHAIN_MASS * G, CHAIN_EA, segments), chain(segments)
    hung.discretisation_error = studies.rms_distance(system_of(hung).equilibrium(1e-9), line)
    hung.expected = (
        f"The equilibrium of the springs is {hung.discretisation_error:.1e} m (RMS) from that of the continuous line, which sags "
        f"by {-line[segments // 2, 1]:.4f} m: this error is the discretisation's, not the methods'.")
    return at_rest(hung, "catenary", "The same chain come to rest: the elastic catenary",
                   "Air drag of the particles brings it to rest.", line, CHAIN_MASS, 9)


STRIP_DENSITY, STRIP_WIDTH = 0.1, 0.25  # kg/m^2, m


def clamped_strip(cells, gamma, **more):
    """A strip of 1 m with `cells` cells along, clamped by its first two rows. gamma: density g L^3 / D."""
    across, D = cells // 4, STRIP_DENSITY * G * (1 - 1 / cells)**3 / gamma
    return make_case("strip", "A clamped strip",
                     f"1 x 0.25 m of 0.1 kg/m^2 in {cells} cells along, springs of 1e5 N/m, bending of a rigidity of {D:.4f} N m:"
                     f" density g L^3 / D is {gamma:g} from the clamp on.",
                     {"grid": {"size": [STRIP_WIDTH, 1], "cells": [across, cells]}},
                     [springs(1e5, ["edges", "shear"]), {"type": "bending", "rigidity": D}], mass=STRIP_DENSITY * STRIP_WIDTH,
                     pins=[{"particles": list(range(2 * (across + 1)))}], bends=True, refinements=0, **more)


def cantilever(cells):
    bent, across, cell = clamped_strip(cells, 10, sweeps=256), cells // 4, 1 / cells
    line = (1 - cell) * reference.heavy_elastica(10, cells - 1)
    rows = np.array([[0, 0, 0], *([0, -drop, cell + reach] for reach, drop, _ in line)])  # the first row is in the clamp
    points = np.repeat(rows, across + 1, axis=0)
    points[:, 0] = np.tile(STRIP_WIDTH * np.arange(across + 1) / across, cells + 1)
    bent.expected = f"The continuous line falls by {line[-1, 1]:.4f} m over a reach of {line[-1, 0]:.4f} m."
    return at_rest(bent, "cantilever", "A clamped strip come to rest: the heavy elastica",
                   f"{bent.what} Air drag brings it to rest.", points, STRIP_DENSITY * STRIP_WIDTH, 3.5)


def strip_swing(cells, gamma, end, reference):
    """Its swing down without drag. end: s, before it swings back."""
    swing = clamped_strip(cells, gamma, times=[end], reference=reference, dense=0)
    swing.name, swing.title = f"swing{gamma:g}", f"A clamped strip that swings, Gamma {gamma:g}"
    swing.what += (" Released horizontally, without drag. The true motion has bending by second differences along rows and "
                   "columns. Methods can come no nearer to it than their hinges do, of which projected ones resist angles and "
                   "filtered ones chords.")
    return swing


LENGTH, WIDTH, YOUNG, DENSITY = 1, 0.2, 1e6, 1000  # of the beam: m, m, Pa, kg/m^3


def beam(cells, reference=0):
    return make_case("beam", "A beam of tetrahedra, released",
                     f"1 x 0.2 x 0.2 m, {cells} cells across, 1 MPa, 1000 kg/m^3, pinned at one end, gravity 1 m/s^2.",
                     {"tet_box": {"size": [LENGTH, WIDTH, WIDTH], "cells": [5 * cells, cells, cells]}},
                     [{"type": "neo_hookean", "young_modulus": YOUNG, "poisson_ratio": 0.3}], gravity=(0, -1, 0), density=DENSITY,
                     pins=[{"box": {"min": [-LENGTH, -1, -1], "max": [-LENGTH / 2 + 1e-6, 1, 1]}}], tetrahedra=True,
                     reference=reference)


def sunk_beam(cells):
    sunk = beam(cells)
    system = system_of(sunk)
    equilibrium = system.equilibrium(1e-7)
    tip = (system.positions - equilibrium)[system.positions[:, 0] > LENGTH / 2 - 1e-6, 1].mean()
    bernoulli = DENSITY * 12 * LENGTH**4 / (8 * YOUNG * WIDTH**2)
    sunk.expected = (
        f"There its end has sunk by {tip:.4f} m, {tip / bernoulli:.2f} of the {bernoulli:.4f} m by Euler and Bernoulli: the "
        "difference is due to the mesh (tetrahedra of constant strain lock), not to the methods.")
    return at_rest(sunk, "sunk_beam", "The same beam come to rest",
                   "Air drag of the particles brings it to rest; compared with the equilibrium of the same energy by relaxation.",
                   equilibrium, DENSITY * LENGTH * WIDTH * WIDTH, 6)


def cases(quick):
    """All cases; only small ones if `quick`."""
    if quick:
        small = [oscillator(), orbit(), sheet(7, 100, 256), drum(5, 128), shell(1, 256), chain(8, 256), catenary(8),
                 cantilever(12), strip_swing(12, 1, 0.3, 1024), beam(1, 256), sunk_beam(1)]
        for one in small:
            one.times = [1] if len(one.times) > 1 and not one.taut else one.times
            one.sweeps, one.solves, one.euler, one.rk4, one.newton = 64 if one.at_rest else 256, 64, 256, 128, 16
            one.dense = 0 if one.taut or one.bends else 16
        return small
    stiff, large, taut = sheet(17, 1e4, 4096), sheet(100, 100, 512), drum(100, 128)
    vars(stiff).update(name=f"{stiff.name}_stiff", title=f"{stiff.title}, stiff", newton=4)
    vars(large).update(sweeps=256, solves=16, dense=4, euler=512, rk4=256, newton=0, times=[0.5, 1])
    large.what += (" It becomes chaotic sooner than the smaller one, so that errors are measured after 0.5 s and 1 s; the taut "
                   "sheet of as many particles shows 5 s. Newton's method is left out: its 50 iterations do not converge from "
                   "the fourth frame on.")
    vars(taut).update(sweeps=256, solves=16, dense=0, refinements=4, euler=128, rk4=64, newton=2)
    return [oscillator(), orbit(), sheet(17, 100, 1024), stiff, large, taut, shell(2, 512), chain(20, 1024), catenary(20),
            cantilever(48), strip_swing(24, 1, 0.3, 2048), strip_swing(24, 10, 0.6, 2048), beam(2, 512), sunk_beam(2)]


# ---- Methods ---------------------------------------------------------------------------------------------------------


XPBD = {"type": "pbd", "substeps": 1, "iterations": 1, "precision": "double", "levels": "off", "bending": "projected"}
DESBRUN = {"type": "desbrun", "substeps": 1, "iterations": 1, "precision": "double", "filter": "sparse"}
FLOAT = {"precision": "float"}


def methods(case, quick):
    """All methods that run a case, series by series, each in order of increasing cost.

    A method: series, its name in legends, which says what varies within the series; integrator, "malha" or one of
    _malha_reference; solver, of the scene, whose substeps a frame hold for all integrators; compliant, false for PBD of
    stiffness 1; variant, true if it appears only in the chart of filters; end: how long it is run, s.
    """
    found = []

    def add(series, solver, varied, most, **more):
        """Adds a series. varied: the key of the solver that grows up to `most`."""
        counts = [4**k if quick else 2**k for k in range(12)]
        if varied == "refinement_iterations":
            counts = [0, 1, 2, 4, 8, 16] if most else []
        for count in counts:
            if count <= most:
                found.append(types.SimpleNamespace(**{"series": series, "integrator": "malha", "solver": solver | {varied: count},
                                                      "compliant": True, "variant": False, "end": math.inf} | more))

    def has_levels(solver):
        return bool(malha.Simulation(scene_by(case, solver), threads=1).plan()["levels"])

    if not case.tetrahedra:
        for precision in ("float", "double"):
            add(f"PBD, iterations, {precision}", XPBD | {"precision": precision}, "iterations", case.sweeps // 4, compliant=False)
    add("XPBD, substeps, float", XPBD | FLOAT, "substeps", case.sweeps)
    add("XPBD, substeps, double", XPBD, "substeps", case.sweeps)
    add("XPBD, iterations", XPBD, "iterations", case.sweeps)
    levels, filtered = XPBD | FLOAT | {"levels": "auto"}, {"bending": "filtered"}
    if has_levels(levels):
        add("XPBD, substeps and levels, float", levels, "substeps", case.sweeps)
    if case.bends:
        add("XPBD, substeps, filtered bending, float", XPBD | FLOAT | filtered, "substeps", case.sweeps)
        if has_levels(levels | filtered):
            add("XPBD, substeps and levels, filtered bending, float", levels | filtered, "substeps", case.sweeps)

    if not case.tetrahedra:
        add("Desbrun, substeps", DESBRUN, "substeps", case.solves)
        for substeps, words in ((1, "1 substep"), (16, "16 substeps")):
            add(f"Desbrun, refine, {words}", DESBRUN | {"substeps": substeps, "corrector": "off"}, "refinement_iterations",
                case.refinements)
        if any(case.scene["gravity"]) and not case.at_rest:
            add("Desbrun, gravity round the filter", DESBRUN | {"filter_external_forces": False}, "substeps", case.solves)
        if not case.exact and case.dense:
            for corrector in ("inertia", "paper", "off") if not case.body["pins"] else ():
                add(f"Desbrun, corrector {corrector}", DESBRUN | {"corrector": corrector}, "substeps", case.solves, variant=True)
            for storage in ("float", "double", "int16"):
                precision = "double" if storage == "double" else "float"
                add(f"Desbrun, dense, {storage}", DESBRUN | {"precision": precision, "filter": "dense", "storage": storage},
                    "substeps", case.dense, variant=True)
            add("Desbrun, sparse, float", DESBRUN | FLOAT, "substeps", case.solves, variant=True)

    if not case.at_rest:
        for name, most in (("explicit Euler", case.euler), ("symplectic Euler", case.euler), ("RK4", case.rk4)):
            add(name, XPBD, "substeps", most, integrator=name)
        if not case.tetrahedra:
            add("backward Euler, Newton", XPBD, "substeps", case.newton, integrator="backward Euler", end=case.newton_end)
    return found


def key_of(method):
    """The whole method in words."""
    solver = method.solver
    words = f"{method.series}, {solver['substeps']}x{solver['iterations']} {solver['precision']}"
    if solver["type"] == "desbrun":
        words += f" r={solver.get('refinement_iterations', 0)} {solver['filter']}"
        words += "".join(f" {solver[key]}" for key in ("storage", "corrector") if key in solver)
        words += " internal only" if "filter_external_forces" in solver else ""
    return words


def settings_of(method):
    """Substeps and iterations as "10x1" or "1x10", or of Desbrun's method substeps and refinements as "1, r = 4"."""
    solver = method.solver
    if method.integrator != "malha":
        return f"{solver['substeps']} a frame"
    if solver["type"] == "pbd":
        return f"{solver['substeps']}x{solver['iterations']}"
    return f"{solver['substeps']}, r = {solver.get('refinement_iterations', 0)}"


# ---- Measuring -------------------------------------------------------------------------------------------------------


def norm(a):
    """The Euclidean norm. Its squares are added one after the other, so that its bits do not depend on numpy's build."""
    return math.sqrt(np.cumsum(a * a)[-1])


def rms(a):
    return norm(a) / math.sqrt(a.size)


def kinetic_plus_elastic(system, x, v):
    now = system.conserved(x, v)
    return now["kinetic"] + now["elastic"]


def reference_run(case, system, substeps, perturbation):
    """RK4 with `substeps` a frame: the states at the case's times, and the largest kinetic plus elastic energy (J).

    perturbation: amplitude (m) that is added to the coordinates at the start.
    """
    change = np.array([math.sin(1.7 * k) for k in range(system.positions.size)]).reshape(-1, 3)
    change[system.pinned] = 0
    run = reference.Integrator(system, "RK4", system.positions + perturbation * change, system.velocities)
    energy, states = kinetic_plus_elastic(system, run.positions, run.velocities), []
    for frame in range(1, round(case.times[-1] / FRAME) + 1):
        run.advance(FRAME / substeps, substeps)
        energy = max(energy, kinetic_plus_elastic(system, run.positions, run.velocities))
        if frame in [round(at / FRAME) for at in case.times]:
            states.append({"x": run.positions, "v": run.velocities})
    return {"energy_j": energy, "states": states}


def truth_of(study, case, system):
    """The true motion of a case at its times, in closed form or by RK4 in three cells.

    at: the states (x, v). step_difference, perturbed_difference: RMS distances (m) of the reference run to one with twice
    the step, and of that one to one whose start is perturbed; uncertainty: the larger of both. energy: the largest kinetic
    plus elastic energy (J) of the motion. omega: the largest frequency at the start, rad/s.
    """
    truth = types.SimpleNamespace(omega=system.largest_frequency(), energy=0, step_difference=[], perturbed_difference=[])
    if case.exact:
        truth.at = [case.exact(t) for t in case.times]
        truth.uncertainty = [case.discretisation_error] * len(case.times)
    else:
        def run(substeps, perturbation=0):
            key = f"{case.name} reference, RK4, {substeps} substeps" + (f", from {perturbation:g} m off" if perturbation else "")
            cell = study.cell(key, lambda: reference_run(case, system, substeps, perturbation))
            return cell["energy_j"], [(np.array(state["x"]), np.array(state["v"])) for state in cell["states"]]

        (_, perturbed), (_, coarse) = run(case.reference // 2, PERTURBATION), run(case.reference // 2)
        truth.energy, truth.at = run(case.reference)
        truth.step_difference = [studies.rms_distance(a[0], b[0]) for a, b in zip(truth.at, coarse)]
        truth.perturbed_difference = [studies.rms_distance(a[0], b[0]) for a, b in zip(perturbed, coarse)]
        truth.uncertainty = list(map(max, truth.step_difference, truth.perturbed_difference))
    truth.energy = max(truth.energy, *(kinetic_plus_elastic(system, *state) for state in truth.at))
    if case.taut:
        truth.energy -= system.conserved(system.positions, system.velocities)["elastic"]
    return truth


def errors(system, x, v, truth, energy):
    """Errors of a state against the true one; energy: that to which the drift of the energy is related, J."""
    now, then = system.conserved(x, v), system.conserved(*truth)
    return {"rms_error_m": studies.rms_distance(x, truth[0]),
            "rms_strain": rms(system.strains(x)),
            "rms_strain_error": rms(system.strains(x) - system.strains(truth[0])),
            "energy_drift": (now["energy"] - then["energy"]) / energy,
            "momentum_error_kg_m_per_s": norm(now["momentum"] - then["momentum"]),
            "angular_momentum_error_kg_m2_per_s": norm(now["angular_momentum"] - then["angular_momentum"])}


def measured(case, system, method, truth, on):
    """The cell of a method: costs a simulated second on one thread, and its errors at each of the case's times.

    The time is the median processor time of a frame (on a device the time by the clock), the counts do not depend on the
    machine. A run that is no longer finite has the status "diverged", and no errors from then on.
    """
    solver, ours, on_device = method.solver, method.integrator == "malha", on.get("backend") == "cuda"
    cell = {"status": "finished"} | ({"backend": on["backend"]} if ours and on_device else {})
    if ours:
        run = malha.Simulation(scene_by(case, solver, method.compliant), threads=1, **on)
        clock, together = time.perf_counter if on_device else time.thread_time, 6  # 0.1 s: many frames a call

        def advance():
            start = clock()
            run.step(together)
            return (clock() - start) / together
    else:
        run, together = reference.Integrator(system, method.integrator, system.positions, system.velocities), 1

        def advance():
            seconds = run.advance(FRAME / solver["substeps"], solver["substeps"])
            if not np.abs(run.positions).max() <= 1e6:
                raise malha.Diverged(method.integrator)
            return seconds

    seconds, at, frames = [], [], 0
    try:
        for end, state in zip(case.times, truth.at):
            while end <= method.end and frames < round(end / FRAME):
                seconds.append(advance())
                frames += together
            if end <= method.end:
                at.append(errors(system, run.positions, run.velocities, state, truth.energy))
    except malha.Diverged:
        cell["status"] = "diverged"
    cell["ms_per_s"] = statistics.median(seconds or [0]) * 1000 / FRAME
    substeps, refinements = solver["substeps"], solver.get("refinement_iterations", 0)
    if method.integrator == "backward Euler":
        cell["sweeps_per_s"] = cell["factorisations_per_s"] = run.factorisations / max(frames, 1) / FRAME
    elif not ours:
        cell["sweeps_per_s"] = cell["evaluations_per_s"] = substeps * (4 if method.integrator == "RK4" else 1) / FRAME
    elif solver["type"] == "desbrun":
        cell["sweeps_per_s"] = cell["solves_per_s"] = substeps * (1 + refinements) / FRAME
    else:
        cell["sweeps_per_s"] = substeps * solver["iterations"] / FRAME
        cell["projections_per_s"] = run.plan()["projections_a_step"] / FRAME
    return cell | {"at": at}


def add_rows(study, case, method, truth, cell):
    """Adds a row for each time up to the method's last. It has no errors where the run ended before."""
    solver = method.solver
    for k, at in enumerate(case.times):
        if at <= method.end:
            study.row(**({"case": case.name, "series": method.series, "settings": settings_of(method), "variant": method.variant,
                          "ours": method.integrator == "malha", "precision": solver["precision"], "substeps": solver["substeps"],
                          "iterations": solver["iterations"], "refinement_iterations": solver.get("refinement_iterations", 0),
                          "key": key_of(method), "status": cell["status"], "time_s": at, "truth_known_to_m": truth.uncertainty[k],
                          "rms_error_m": None} | {key: value for key, value in cell.items() if key not in ("at", "status")} |
                         (cell["at"][k] if k < len(cell["at"]) else {})))


# ---- Sentences and tables --------------------------------------------------------------------------------------------


def points_at(rows, name, at):
    """The rows of a case at a time (s), without runs that diverged before."""
    return [row for row in rows if row["case"] == name and row["time_s"] == at and row["rms_error_m"] is not None]


def cheapest(points, error, cost, ours):
    """The cheapest point by the column `cost` with an error of at most `error` m, or None. ours: of malha's only."""
    return min((point for point in points if point["rms_error_m"] <= error and (point["ours"] or not ours)),
               key=lambda point: point[cost], default=None)


def cheapest_list(points, uncertainty, cost, unit, ours):
    """The cheapest points in words, each with the smallest power of ten of the error for which it is the cheapest.

    uncertainty: of the true motion, m; smaller errors are left out.
    """
    best = {k: cheapest(points, 10.0**k, cost, ours) if 10.0**k > uncertainty else None for k in range(-1, -14, -1)}
    parts = [f"1e{k} m: {best[k]['series']} ({best[k]['settings']}, {best[k][cost]:.3g} {unit})"
             for k in itertools.takewhile(best.get, range(-1, -13, -1)) if best[k - 1] is not best[k]]
    return "; ".join(parts) or "none reaches 1e-1 m"


CHEAPEST = ["error at most, m", "cheapest of all", "settings", "ms per s", "cheapest of malha's", "settings", "ms per s",
            "fewest sweeps of malha's", "settings", "sweeps per s"]


def cheapest_table(points, uncertainty):
    """Rows of CHEAPEST for each power of ten of the error that any method reaches."""
    rows = []
    for k in range(0, -13, -1):
        if 10.0**k < uncertainty or not cheapest(points, 10.0**k, "ms_per_s", False):
            break
        row = [f"1e{k}"]
        for cost, ours in (("ms_per_s", False), ("ms_per_s", True), ("sweeps_per_s", True)):
            point = cheapest(points, 10.0**k, cost, ours)
            row += [point["series"], point["settings"], point[cost]] if point else ["none", "", ""]
        rows.append(row)
    return rows


def by_series(points):
    """(name, points) of each series."""
    return [(name, list(group)) for name, group in itertools.groupby(points, lambda point: point["series"])]


def order_of(points):
    """The order at which a series' error falls with the sweeps: the median slope of the logarithms between the last neighbours
    whose error still falls. 0 if it does not fall between three points."""
    slopes = [math.log(a["rms_error_m"] / b["rms_error_m"]) / math.log(b["sweeps_per_s"] / a["sweeps_per_s"])
              for a, b in itertools.pairwise(points) if 0 < b["rms_error_m"] < 0.8 * a["rms_error_m"]]
    return statistics.median(slopes[-3:]) if len(slopes) > 1 else 0


def truth_sentence(case, truth):
    frequency = (f"The largest frequency at the start is {truth.omega:.4g} rad/s: symplectic Euler is stable from "
                 f"{math.ceil(truth.omega * FRAME / 2)} steps a frame on.")
    if case.at_rest:
        return case.expected
    if case.exact:
        return "The true motion is known in closed form. " + frequency

    def away(distances):
        return " and ".join(f"{distance:.1e} m away after {at:g} s" for distance, at in zip(distances, case.times)) + ". "

    line = (f"The true motion is that of the same equations by RK4 with a step of {FRAME / case.reference:.2g} s (omega_max h = "
            f"{truth.omega * FRAME / case.reference:.2g}); the motion with twice that step is {away(truth.step_difference)}"
            f"If the start is perturbed by {PERTURBATION:g} m, it is {away(truth.perturbed_difference)}")
    if truth.uncertainty[-1] > CHAOTIC:
        by_step = truth.step_difference[-1] > 10 * truth.perturbed_difference[-1]
        line += ("That is the error of the step. " if by_step else
                 f"At {case.times[-1]:g} s the motion is chaotic, and no smaller step helps. ")
        line += f"Errors below {truth.uncertainty[-1]:.0e} m are not significant. "
    return line + frequency


def best_sentence(points):
    best = [min(group, key=lambda point: point["rms_error_m"]) for _, group in by_series(points)]
    return "Smallest error of each series, with its gain or loss of energy: " + "; ".join(
        f"{p['series']} {p['rms_error_m']:.1e} m ({p['settings']}, {100 * p['energy_drift']:+.2g} %)" for p in best) + "."


def float_sentences(points):
    """The number of substeps beyond which float gets worse, if it does."""
    group = dict(by_series(points)).get("XPBD, substeps, float", [])
    best, costliest = min(group, key=lambda point: point["rms_error_m"], default=None), group[-1] if group else None
    if not group or costliest["rms_error_m"] < 2 * best["rms_error_m"]:
        return []
    return [f"In float XPBD is best with {best['settings']} ({best['rms_error_m']:.1e} m), and with {costliest['settings']} its "
            f"error is {costliest['rms_error_m']:.1e} m and its energy is off by {100 * costliest['energy_drift']:+.2g} %: the "
            "displacement of a substep is lost in the rounding of positions."]


def momenta_sentence(points, at):
    costliest = [max(group, key=lambda point: point["sweeps_per_s"]) for _, group in by_series(points)]
    return (f"Errors of momentum (kg m/s) and angular momentum (kg m^2/s) after {at:g} s, of each series at its highest cost: " +
            "; ".join(f"{p['series']} {p['momentum_error_kg_m_per_s']:.1e}, {p['angular_momentum_error_kg_m2_per_s']:.1e} "
                      f"({p['settings']})" for p in costliest) + ".")


def work_sentences(case, points, rows):
    """What the sweeps show: orders of convergence, the energy that explicit Euler adds, and runs that diverged."""
    sentences = []
    orders = "; ".join(f"{name} {order_of(group):.1f}" for name, group in by_series(points) if order_of(group) > 0)
    if orders:
        sentences.append(f"The error falls with the sweeps to the power of: {orders}.")
    series = dict(by_series(points))
    if "explicit Euler" in series:
        added = ", ".join(f"{100 * p['energy_drift']:+.2g} % ({p['settings']})" for p in series["explicit Euler"])
        kept = series["symplectic Euler"][-1]["energy_drift"] if "symplectic Euler" in series else 0
        sentences.append(f"Explicit Euler adds energy at every step, after {case.times[0]:g} s: {added}; symplectic Euler with "
                         f"the most steps: {100 * kept:+.2g} %.")
    diverged = [row for row in rows if (row["case"], row["time_s"], row["status"]) == (case.name, case.times[-1], "diverged")]
    if diverged:
        sentences.append("Diverged: " + "; ".join(f"{name} {', '.join(row['settings'] for row in group)}"
                                                  for name, group in by_series(diverged)) + ".")
    return sentences


RUNS = {"method": "series", "settings": "settings", "time, s": "time_s", "status": "status", "RMS error, m": "rms_error_m",
        "RMS strain": "rms_strain", "its error": "rms_strain_error", "energy drift": "energy_drift",
        "momentum error": "momentum_error_kg_m_per_s", "angular": "angular_momentum_error_kg_m2_per_s", "ms per s": "ms_per_s",
        "sweeps per s": "sweeps_per_s"}  # column of the page: column of the rows


# ---- Charts and sections ---------------------------------------------------------------------------------------------


# Colour, marker and line of each series: malha's methods by family, other integrators mostly in grey and black.
STYLES = {
    "PBD, iterations, float": ("#d55e00", "s", "-"), "PBD, iterations, double": ("#d55e00", "s", "--"),
    "XPBD, substeps, float": ("#0072b2", "o", "-"), "XPBD, substeps, double": ("#0072b2", "o", "--"),
    "XPBD, iterations": ("#56b4e9", "^", "-"), "XPBD, substeps and levels, float": ("#cc79a7", "o", "-"),
    "XPBD, substeps, filtered bending, float": ("#e69f00", "o", "-"),
    "XPBD, substeps and levels, filtered bending, float": ("#882255", "s", "-"),
    "Desbrun, substeps": ("#009e73", "D", "-"), "Desbrun, gravity round the filter": ("#000000", "D", "--"),
    "Desbrun, refine, 1 substep": ("#8fbc5a", "v", "-"), "Desbrun, refine, 16 substeps": ("#8fbc5a", "v", "--"),
    "Desbrun, corrector inertia": ("#0072b2", "o", "--"), "Desbrun, corrector paper": ("#d55e00", "s", "-"),
    "Desbrun, corrector off": ("#555555", "s", "--"), "Desbrun, dense, float": ("#56b4e9", "o", "-"),
    "Desbrun, dense, double": ("#cc79a7", "o", "--"), "Desbrun, dense, int16": ("#e69f00", "^", "-"),
    "Desbrun, sparse, float": ("#8fbc5a", "v", "-"), "explicit Euler": ("#e69f00", "+", "-"),
    "symplectic Euler": ("#555555", "s", "--"), "RK4": ("#000000", "x", "-"), "backward Euler, Newton": ("#661100", "x", "-")}


def plot(axes, x, y, label, colour, marker, line):
    axes.plot(x, y, line, color=colour, marker=marker, markersize=7, fillstyle="none" if line == "--" else "full", label=label)


def chart(case, truth, k, points, cost, axis):
    """Error over the column `cost` at the case's time number k; errors above 10 m are not drawn."""
    figure, axes = plt.subplots(figsize=(12.5, 6.4))
    drawn = [point for point in points if 0 < point["rms_error_m"] <= 10]
    for name, group in by_series(drawn):
        plot(axes, [point[cost] for point in group], [point["rms_error_m"] for point in group], name, *STYLES[name])
    if truth.uncertainty[k] > 1e-3 * min(point["rms_error_m"] for point in drawn):  # else it would press the lines together
        axes.axhline(truth.uncertainty[k], color="#444444", ls=":",
                     label="equilibrium of the springs" if case.exact else "how well the true motion is known")
    return labelled(figure, f"{case.title}: after {case.times[k]:g} s", axis,
                    f"RMS distance to the true {'equilibrium' if case.at_rest else 'motion'} (m)")


def labelled(figure, title, horizontal, vertical):
    """The figure with logarithmic axes of these names, and with its legend beside them."""
    axes = figure.axes[0]
    axes.set(xscale="log", yscale="log", xlabel=horizontal, ylabel=vertical)
    axes.set_title(title, fontsize=12)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=9.5)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    figure.subplots_adjust(left=0.075, right=0.68, top=0.94, bottom=0.15)
    return figure


def add_sections(study, case, truth):
    """Error over time, error over sweeps, errors at a later time, and variants of Desbrun's filter if they were run."""
    is_free = not case.at_rest and not case.body["pins"]
    # The series that variants are compared with. On free bodies it is a variant itself, that with the corrector by inertia.
    base = "" if is_free else "Desbrun, substeps"

    def points(at, variants=False):
        return [point for point in points_at(study.rows, case.name, at)
                if (point["variant"] or point["series"] == base if variants else not point["variant"])]

    def best(points, uncertainty, ours, cost="ms_per_s", unit="ms"):
        return cheapest_list(points, uncertainty, cost, unit, ours) + "."

    first, last, variants = points(case.times[0]), points(case.times[-1]), points(case.times[0], True)
    known, known_last = truth.uncertainty[0], truth.uncertainty[-1]
    axis = "ms of processor time per simulated second, one thread"
    if any(row.get("backend") == "cuda" for row in study.rows):
        axis = "ms per simulated second: malha on the device, by the clock; others on one thread"

    sentences = [case.what, truth_sentence(case, truth),
                 f"Cheapest of all methods after {case.times[0]:g} s (ms a simulated second): {best(first, known, False)}",
                 f"Of malha's methods: {best(first, known, True)}"]
    if len(case.times) > 1 and 3 * known_last < 0.1:  # errors below three times the uncertainty are coincidence
        sentences.append(f"After {case.times[-1]:g} s, of malha's: {best(last, 3 * known_last, True)}")
    sentences += [best_sentence(first), *float_sentences(first)]
    if is_free:
        sentences.append(momenta_sentence(last, case.times[-1]))
    study.section(f"{case.title}: what accuracy costs", sentences, CHEAPEST, cheapest_table(first, known),
                  (f"{case.name}_cost", chart(case, truth, 0, first, "ms_per_s", axis)), replays=replays(case))

    study.section(f"{case.title}: what accuracy takes in sweeps", [
        "Independent of the machine: a sweep is one projection of every constraint, one solve with Desbrun's filter, one "
        "evaluation of all forces, or one factorisation of Newton's method. PBD has stiffness 1, whatever the springs have.",
        f"Fewest sweeps of malha's methods: {best(first, known, True, 'sweeps_per_s', 'sweeps a second')}",
        *work_sentences(case, first, study.rows)],
        list(RUNS), [[row.get(key) for key in RUNS.values()] for row in study.rows if row["case"] == case.name],
        (f"{case.name}_work", chart(case, truth, 0, first, "sweeps_per_s", "sweeps, solves or evaluations per simulated second")))

    if len(case.times) > 1 and known_last <= CHAOTIC:
        study.section(f"{case.title}: what accuracy costs after {case.times[-1]:g} s", [
            f"Cheapest of all (ms a simulated second): {best(last, known_last, False)}",
            f"Of malha's methods: {best(last, known_last, True)}", best_sentence(last)],
            CHEAPEST, cheapest_table(last, known_last), (f"{case.name}_late", chart(case, truth, -1, last, "ms_per_s", axis)))
    if any(point["variant"] for point in variants):
        sentences = ["Unless their names say otherwise, they are sparse, in double, and with the corrector by inertia on free "
                     "bodies.", best_sentence(variants), f"Cheapest: {best(variants, known, True)}"]
        if is_free:
            sentences.append(momenta_sentence(points(case.times[-1], True), case.times[-1]))
        study.section(f"{case.title}: variants of Desbrun's filter", sentences, CHEAPEST, cheapest_table(variants, known),
                      (f"{case.name}_filters", chart(case, truth, 0, variants, "ms_per_s", axis)))


def replays(case):
    """Of the small sheet few substeps and many beside the reference; of the free body a corrector that diverges beside one
    that does not."""
    def named(name, **solver):
        return scene_by(case, solver) | {"name": name, "duration": case.times[0] + 1}

    def by_substeps(n):
        return named(f"{n} substep{'s' if n > 1 else ''}", type="pbd", substeps=n, iterations=1, precision="double")

    if case.name == "shell":
        paper, inertia = (named(name, type="desbrun", substeps=1, corrector=corrector)
                          for name, corrector in (("the paper's corrector", "paper"), ("by inertia", "inertia")))
        return [("shell_correctors", f"{case.title}: Desbrun's method with the paper's corrector, beside that by inertia",
                 paper, inertia)]
    if case.name not in ("sheet7", "sheet17"):
        return []
    many = by_substeps(1024)
    return [(f"{case.name}_{n}", f"{case.title}: {few['name']} a frame beside {many['name']}, close to the true motion",
             few, many) for n, few in ((n, by_substeps(n)) for n in (1, 100))]


# ---- Order of convergence --------------------------------------------------------------------------------------------


ORDER_TIME, ORDER_FRAMES = 0.5, 30  # s, frames
CHAIN_SUBSTEPS, CHAIN_UNCERTAINTY = 2048, 1e-7  # steps of the truth a frame, and m, by halving those
ONE_WAY, ONE, CONVERGED, LATER = ("one way, gradients at the end", "malha, 1 iteration", "malha, as many iterations as substeps",
                                  "the same, to half a substep later")


def order_lines(quick):
    """(title, scheme, edges, numbers of substeps a frame, style) of each line of the chart."""
    few, many = [10, 20, 40], [5, 10, 20, 40, 80, 160, 320]
    lines = [(ONE_WAY, ONE_WAY, 16, few if quick else many, ("#d55e00", "s", "-")),
             (ONE, ONE, 16, few if quick else many, ("#0072b2", "o", "-")),
             (f"{ONE}, 46 edges", ONE, 46, many[:-1], ("#56b4e9", "o", "--")),
             (CONVERGED, CONVERGED, 16, few if quick else many[1:5], ("#009e73", "^", "-")),
             (LATER, LATER, 16, few if quick else many[:4], ("#000000", "D", "-"))]
    return [line for line in lines if not quick or line[2] == 16]


@functools.lru_cache(None)
def chain_motion(links):
    """The joints (links + 1, 2), m, of a hanging chain after each step from a frame before ORDER_TIME to a frame after it."""
    chain, motion = reference.Chain(links, 1, G), []
    chain.advance(FRAME / CHAIN_SUBSTEPS, (ORDER_FRAMES - 1) * CHAIN_SUBSTEPS)
    for _ in range(2 * CHAIN_SUBSTEPS):
        chain.advance(FRAME / CHAIN_SUBSTEPS, 1)
        motion.append(chain.joints)
    return motion


def true_sheet(edges, at):
    """The particles (N, 3), m, of an inextensible sheet that hangs by a row: its rows move as the joints of a chain."""
    # The chain starts with a whole kick as well, and is half a step ahead of its time.
    step = at / FRAME * CHAIN_SUBSTEPS - 1.5 - (ORDER_FRAMES - 1) * CHAIN_SUBSTEPS
    before, after = chain_motion(edges)[math.floor(step)], chain_motion(edges)[math.floor(step) + 1]
    joints = before + (step - math.floor(step)) * (after - before)
    along, i = np.meshgrid(np.arange(edges + 1) / edges, np.arange(edges + 1))
    return np.concatenate([along[..., None], joints[i]], axis=2).reshape(-1, 3)


def order_error(scheme, edges, substeps):
    """RMS distance (m) of a hard sheet to the exact motion after ORDER_TIME."""
    hung = sheet(edges + 1, 1, 0)  # no scheme uses the stiffness of these springs
    if scheme == ONE_WAY:
        run = reference.PlainSweep(system_of(hung))
        run.advance(FRAME / substeps, ORDER_FRAMES * substeps)
    else:
        run = malha.Simulation(scene_by(hung, {"type": "pbd", "substeps": substeps, "precision": "double",
                                               "iterations": 1 if scheme == ONE else substeps}, compliant=False), threads=1)
        run.step(ORDER_FRAMES)
    return studies.rms_distance(run.positions, true_sheet(edges, ORDER_TIME + (FRAME / substeps / 2 if scheme == LATER else 0)))


def add_order(study, cells):
    """Rows and the section of the order of convergence. cells: those of each line."""
    figure, axes = plt.subplots(figsize=(12.5, 6.4))
    sentences = ["1 m and 16 x 16 edges with both diagonals, inextensible, pinned at a row and released from the horizontal: its "
                 f"rows move as the joints of a chain of rigid links, whose motion is known to {CHAIN_UNCERTAINTY:g} m (SHAKE, "
                 f"each step solved by Newton's method). Errors after {ORDER_TIME:g} s; the slope of each line is fitted to its "
                 "logarithms."]
    table = []
    for (title, scheme, edges, counts, style), line in zip(order_lines(study.quick), cells):
        found = [cell["error"] for cell in line]
        order = -np.polyfit(np.log(counts), np.log(found), 1)[0]
        plot(axes, counts, found, f"{title}: slope {order:.1f}", *style)
        sentences.append(f"{title}: {found[0]:.2g} m with {counts[0]} substeps, {found[-1]:.2g} m with {counts[-1]}, slope "
                         f"{order:.2f}.")
        for n, cell in zip(counts, line):
            study.row(case="order", series=title, settings=str(n), variant=False, ours=scheme != ONE_WAY, precision="double",
                      substeps=n, iterations=1 if scheme in (ONE_WAY, ONE) else n, refinement_iterations=0,
                      key=f"order: {title}, {n}", status="finished", time_s=ORDER_TIME, truth_known_to_m=CHAIN_UNCERTAINTY,
                      rms_error_m=cell["error"], **studies.machine(cell))
            table.append([title, edges, n, cell["error"]])
    sentences.append(
        "From rest the first substep applies a whole kick at once, so that a run is half a substep ahead of the exact motion. "
        "Only this error is of first order: compared with the motion half a substep later, converged substeps are of second "
        "order, down to some 5e-5 m, where the remaining strains of 1e-6 limit them.")
    labelled(figure, "A sheet of 1 m that hangs by a row, let go from the horizontal", "substeps a frame of 1/60 s",
             "RMS distance to the exact motion after 0.5 s (m)")
    axes.set_xticks([], minor=True)
    axes.set_xticks(order_lines(study.quick)[0][3])
    study.section("A hanging sheet: order of convergence", sentences, ["method", "edges", "substeps", "RMS error, m"], table,
                  ("order", figure))


# ---- The study -------------------------------------------------------------------------------------------------------


def measure(study):
    run = [(case, methods(case, study.quick)) for case in cases(study.quick)]
    lines = order_lines(study.quick)
    study.plan(sum(len(all_methods) + (0 if case.exact else 3) for case, all_methods in run) +
               sum(len(counts) for _, _, _, counts, _ in lines))
    found = {}  # truth and cells by the name of the case

    def measure_case(case, all_methods):
        system = system_of(case)
        truth = truth_of(study, case, system)
        found[case.name] = truth, study.cells(all_methods, lambda method: f"{case.name}: {key_of(method)}",
                                              lambda method: measured(case, system, method, truth, study.on))

    for case, all_methods in run:  # errors need the truth, which is measured, too
        study.together(lambda: measure_case(case, all_methods))
    order = [study.cells(counts, lambda n: f"order: {title}, {n}", lambda n: {"error": order_error(scheme, edges, n)})
             for title, scheme, edges, counts, _ in lines]
    if study.partial:
        return
    for case, all_methods in run:
        truth, cells = found[case.name]
        for method, cell in zip(all_methods, cells):
            add_rows(study, case, method, truth, cell)
        add_sections(study, case, truth)
    add_order(study, order)


if __name__ == "__main__":
    studies.main("accuracy", "Error over cost of every method, with explicit and implicit integrators for comparison", measure,
                 any_backend=True)
