# SPDX-License-Identifier: Apache-2.0
"""malha against results that are not its own: experiments, closed forms and boundary value problems of the literature.

Each protocol is a function that simulates a case over a range of its parameter, on several meshes, with several methods,
and compares what it measures with a master curve, which is computed here from the equations of the continuum and never
by malha. A method has passed a protocol on a mesh if no measured value is farther than the protocol's bar (5 %) from the
master curve, over the whole range that the mesh resolves.

    PYTHONPATH=build/release /usr/bin/python3 tools/study/validation.py --quick

To add a protocol, write a function of the study below the others and decorate it:

    @protocol("catenary", "a cable between two points: its sag over its span")
    def catenary(study):
        for method, mesh, cells in ...:
            for slack in ...:
                value = study.cell(f"catenary, {method}, {mesh}, {cells} cells, slack {slack}", lambda: sag_of(...))
                compare(study, method=method, mesh=mesh, cells=cells, setting="slack", at=slack, value=value,
                        reference=sag_of_a_catenary(slack))
        refinement_chart(study, "...")      # or study.section(title, sentences, columns, rows, chart) of its own

`study.cell(key, make)` measures a value once and reads it from the journal afterwards; its key names all that the value
depends on. `study.quick` asks for one or two meshes, methods and settings of each kind. `study.threads` is for
malha.Simulation. `compare` adds a row to validation.csv, from which the table of passed and failed is made.
"""
import functools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

studies.require("scipy")

import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from scipy.integrate import solve_bvp, solve_ivp  # noqa: E402
from scipy.interpolate import PchipInterpolator  # noqa: E402
from scipy.linalg import eigh  # noqa: E402
from scipy.optimize import brentq  # noqa: E402
from scipy.spatial import Delaunay  # noqa: E402
from scipy.special import beta, ellipk, iv, jn_zeros, jv  # noqa: E402

G = 9.81  # m/s^2
DENSITY = 0.1  # kg/m^2, of all sheets
MESHES = ("grid", "irregular")
PROTOCOLS = {}


def protocol(name, what, bar=0.05):
    """Registers a function of the study as a protocol. bar: the largest error with which a method passes it."""
    def register(function):
        function.what, function.bar = what, bar
        PROTOCOLS[name] = function
        return function
    return register


def compare(study, *, method, mesh, cells, setting, at, value, reference, substeps=None, resolved=True, scale=None,
            note=""):
    """Adds a measured value and its reference as a row of the protocol that runs.

    method, mesh: names as in the tables. cells: cells along the body. setting, at: the parameter's name and value.
    substeps: those of a step, where they are not the protocol's own. resolved: whether the mesh resolves the case, so
    that it counts for passed or failed. scale: what the error is a share of, the reference by default. value None: the
    simulation failed, as `note` says; the row then counts as failed.
    """
    error = None if value is None else abs(value - reference) / abs(reference if scale is None else scale)
    study.row(protocol=study.protocol, method=method, mesh=mesh, cells=cells, substeps=substeps, setting=setting, at=at,
              value=value, reference=reference, error=error, resolved=bool(resolved),
              within=error is not None and error <= PROTOCOLS[study.protocol].bar, bar=PROTOCOLS[study.protocol].bar,
              note=note)


def finest_rows(rows):
    """Of the rows of each quantity or value of a parameter the one by the finest mesh and the most substeps."""
    best = {}
    for row in sorted(rows, key=lambda row: (row["cells"], row["substeps"] or 0)):
        best[row["setting"], row["at"]] = row
    return list(best.values())


def curve_chart(study, horizontal, vertical, curves, log=False, place=lambda row: (row["at"], row["value"]), error_over=None):
    """Two charts of the protocol that runs, side by side: what was measured beside master curves, and its error.

    horizontal, vertical: the axes' names. curves: (label, x, y) of each master curve, with arrays (N,). log: the axes of
    the first chart are logarithmic. place: where a row is shown there. error_over: the name of the parameter `at`, over
    which the errors are shown, where it is not `horizontal`. Each value is shown by the finest mesh and the most substeps.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(13, 6.2))
    for (label, x, y), style in zip(curves, ("-", "--", ":", "-.")):
        left.plot(x, y, color="black", ls=style, label=label, zorder=1)
    groups = {}
    for row in study.rows:
        if row["protocol"] == study.protocol and row["value"] is not None:
            groups.setdefault((row["method"], row["mesh"]), []).append(row)
    methods = list(dict.fromkeys(method for method, _ in groups))
    for (method, mesh), rows in groups.items():
        shown_rows = finest_rows(rows)
        shown = dict(color=studies.COLOURS[methods.index(method) % len(studies.COLOURS)], ls="none", markersize=7,
                     marker="s^"[MESHES.index(mesh)], fillstyle="full" if mesh == MESHES[0] else "none")
        left.plot(*zip(*map(place, shown_rows)), **shown)
        counted = [row for row in shown_rows if row["resolved"]]
        right.plot([row["at"] for row in counted], [100 * (row["value"] / row["reference"] - 1) for row in counted],
                   label=f"{method}, {mesh}", **shown)
    bar = 100 * PROTOCOLS[study.protocol].bar
    right.axhspan(-bar, bar, color="#2ca02c", alpha=0.12, lw=0)
    right.set_yscale("symlog", linthresh=2 * bar)
    right.yaxis.set_major_formatter(lambda value, _: f"{value:g} %")
    left.set(xlabel=horizontal, ylabel=vertical)
    right.set(xlabel=error_over or horizontal, ylabel="error; shaded: passed")
    if log:
        left.set(xscale="log", yscale="log"), right.set(xscale="log")
    left.legend(loc="best", fontsize=10)
    figure.legend(*right.get_legend_handles_labels(), loc="center right", fontsize=10)
    figure.subplots_adjust(left=0.07, right=0.78, top=0.95, bottom=0.16, wspace=0.3)
    section(study, figure)


def section(study, figure=None):
    """Adds the section of the protocol that runs: what it is, its verdicts in words, all its rows, and the figure."""
    rows = [row for row in study.rows if row["protocol"] == study.protocol]
    sentences = [f"{PROTOCOLS[study.protocol].what[0].upper()}{PROTOCOLS[study.protocol].what[1:]}."]
    for method in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == method and row["resolved"]]
        failed = [row for row in own if not row["within"]]
        worst = max((row["error"] for row in own if row["error"] is not None), default=0)
        sentences.append(f"{method[0].upper()}{method[1:]}: {len(own) - len(failed)} of {len(own)} values are within "
                         f"{100 * PROTOCOLS[study.protocol].bar:g} %, the largest error is {studies.text(100 * worst)} %.")
    columns = ["method", "mesh", "cells", "substeps", "setting", "at", "value", "reference", "error", "resolved", "within", "note"]
    study.section(study.protocol, sentences, columns, [[row[key] for key in columns] for row in rows],
                  (study.protocol.replace(" ", "_"), figure) if figure else None)


# ---- Bodies ----------------------------------------------------------------------------------------------------------


def quads(along, across):
    """The quads of a grid of cells, whose points are numbered across first."""
    n = across + 1
    corner = (np.arange(along)[:, None] * n + np.arange(across)).ravel()
    return np.stack([corner, corner + n, corner + n + 1, corner + 1], axis=1)


def mixed_triangles(flat, random, least, aspect=1.0):
    """Delaunay's triangles of points (N, 2), half of them turned over.

    random: a generator. least: triangles of at most half of this area are left out: they lie between points of a straight
    side. aspect: the first axis is stretched by it for the triangulation.
    """
    faces = Delaunay(flat * [aspect, 1]).simplices
    faces = faces[np.abs(np.linalg.det(flat[faces[:, 1:]] - flat[faces[:, :1]])) > least]
    turned = random.random(len(faces)) < 0.5
    faces[turned] = faces[turned, ::-1]
    return faces


def strip(length, width, along, across, mesh, clamp=1, seed=1):
    """A flat strip in the plane y = 0, along x from 0 and along z from 0, with `clamp` further rows of cells at x < 0.

    mesh: "grid" (quads) or "irregular": points moved at random by up to 0.3 cells, Delaunay's triangles, half of them
    turned over. The rows at x <= 0 and the last row stay straight. Returns points (N, 3), faces (F, 4 or 3), the
    particles at x <= 0, which a clamp pins, and those at the other end.
    """
    cell, n = length / along, across + 1
    x, z = np.meshgrid(np.arange(-clamp, along + 1) * cell, np.linspace(0, width, n), indexing="ij")
    points = np.stack([x, 0 * x, z], axis=-1)
    if mesh == "grid":
        faces = quads(along + clamp, across)
    else:
        random = np.random.default_rng(seed)
        moved = random.uniform(-0.3, 0.3, x.shape + (2,)) * [cell, width / across]
        moved[:clamp + 1, :, 0] = moved[-1, :, 0] = moved[:, 0, 1] = moved[:, -1, 1] = 0
        points[..., ::2] += moved
        faces = mixed_triangles(points.reshape(-1, 3)[:, ::2], random, 2e-6 * cell * width / across)
    count = len(points.reshape(-1, 3))
    return points.reshape(-1, 3), faces, list(range((clamp + 1) * n)), list(range(count - n, count))


def relax(simulation, size, period, tolerance=2e-5, most=10):
    """Steps to rest by kinetic damping: wherever the kinetic energy has a maximum, all velocities become 0.

    size: a length of the body (m). period: of its slowest oscillation (s). It rests when no particle has moved by more
    than `tolerance` of the size in half a period. Returns whether it does within `most` periods.
    """
    before, last, checked = simulation.positions, 0.0, simulation.time
    end = simulation.time + most * period
    while simulation.time < end:
        simulation.step()
        energy = np.sum(simulation.velocities**2)
        if not np.isfinite(energy):
            return False
        if energy < last:
            simulation.velocities = np.zeros_like(before)
        last = energy if energy >= last else 0.0
        if simulation.time - checked > period / 2:
            now = simulation.positions
            if np.abs(now - before).max() < tolerance * size:
                return True
            before, checked = now, simulation.time
    return False


# Methods by name: constraints of a sheet of the flexural rigidity D (N m) and a stretching modulus Y (N/m), and the keys
# of the solver.
SPRINGS = {"type": "distance", "elements": ["edges", "shear"]}


def _pbd(bending, **more):
    return {"type": "pbd", "dt": 1 / 60, "bending": bending, "precision": "double"} | more


METHODS = {
    "hinges, projected": lambda D, Y: ([SPRINGS, {"type": "bending", "rigidity": D}], _pbd("projected")),
    "hinges, filtered": lambda D, Y: ([SPRINGS, {"type": "bending", "rigidity": D}], _pbd("filtered")),
    "plate, filtered": lambda D, Y: ([SPRINGS, {"type": "plate", "rigidity": D}], _pbd("filtered")),
    "membrane and plate": lambda D, Y: ([{"type": "membrane", "young_modulus": Y, "poisson_ratio": 0},
                                         {"type": "plate", "rigidity": D}], _pbd("filtered")),
    "Desbrun": lambda D, Y: ([SPRINGS, {"type": "bending", "rigidity": D}],
                             {"type": "desbrun", "dt": 1 / 60, "precision": "double"}),
}


FILTERED = ("hinges, filtered", "plate, filtered")  # the methods of which finer meshes are measured


def methods(study, quick=FILTERED):
    """The names of METHODS that the study measures; `quick` are those of its quick version."""
    return quick if study.quick else tuple(METHODS)


def sheet(points, faces, method, *, D, Y, density, pins, substeps, iterations=1, refinement=10, gravity=(0, -G, 0)):
    """The scene of a sheet by one of METHODS. D (N m), Y (N/m), density (kg/m^2). iterations: those of a substep of PBD;
    refinement: those of Desbrun's method, whose filter alone damps a rotation so that it hardly comes to rest."""
    constraints, solver = METHODS[method](D, Y)
    solver |= {"iterations": iterations} if solver["type"] == "pbd" else {"refinement_iterations": refinement}
    if len(faces[0]) == 3:  # triangles have no diagonals
        constraints = [{**one, "elements": ["edges"]} if one["type"] == "distance" else one for one in constraints]
    return {"name": "sheet", "duration": 1, "gravity": list(gravity), "solver": solver | {"substeps": substeps},
            "bodies": [malha.body(points, faces, density=density, pins=pins, constraints=constraints)]}


def period(D, density=1.0):
    """The period (s) of the slowest oscillation of a clamped strip of 1 m, of D (N m) and density (kg/m^2)."""
    return 2 * np.pi / (3.516 * np.sqrt(D / density))


# ---- Cantilever ------------------------------------------------------------------------------------------------------


@functools.lru_cache(None)
def heavy_elastica(gamma):
    """Drop over reach of the end of an inextensible strip, clamped horizontally, that bends under its weight.

    gamma: density g L^3 / D. Solves theta'' + gamma (1 - s) cos theta = 0, theta(0) = 0, theta'(1) = 0 by collocation,
    from small gamma on. Romero et al., "Physical validation of simulators in computer graphics", 2021, cantilever.
    """
    s, load = np.linspace(0, 1, 100), min(gamma, 1.0)
    y = np.zeros((2, len(s)))
    while True:
        found = solve_bvp(lambda s, y: np.stack([y[1], load * (1 - s) * np.cos(y[0])]),
                          lambda a, b: np.array([a[0], b[1]]), s, y, tol=1e-8, max_nodes=100000)
        if not found.success:
            raise RuntimeError(f"the heavy elastica of gamma {load}: {found.message}")
        if load == gamma:
            break
        y, load = found.sol(s), min(gamma, 4 * load)  # on the first nodes again, because refinements accumulate otherwise
    nodes, weights = np.polynomial.legendre.leggauss(400)
    angle = found.sol((nodes + 1) / 2)[0]
    return -np.sum(weights * np.sin(angle)) / np.sum(weights * np.cos(angle))


def drop_over_reach(study, method, mesh, cells, substeps, gamma):
    points, faces, clamped, end = strip(1, 0.25, cells, cells // 4, mesh)
    D = DENSITY * G / gamma
    simulation = malha.Simulation(sheet(points, faces, method, D=D, Y=1e5 * D, density=DENSITY, pins=clamped,
                                        substeps=substeps), threads=study.threads)
    rests = relax(simulation, 1, period(max(D, DENSITY * G / 50), DENSITY))
    tip = simulation.positions[end].mean(axis=0)
    return [-tip[1] / tip[0], rests]


def solid_drop_over_reach(study, cells, gamma):
    """The cantilever of tetrahedra: a beam as thick as a tenth of its length."""
    thick, cell, D = 0.1, 1 / cells, DENSITY * G / gamma
    beam = {"name": "beam", "density": DENSITY / thick, "pins": [{"box": {"min": [-1, -1, -1], "max": [1e-9, 1, 1]}}],
            "shape": {"tet_box": {"size": [1 + cell, thick, thick], "cells": [cells + 1] + 2 * [round(cells * thick)]}},
            "transform": {"translate": [(1 - cell) / 2, 0, 0]},
            "constraints": [{"type": "neo_hookean", "young_modulus": 12 * D / thick**3, "poisson_ratio": 0}]}
    simulation = malha.Simulation({"name": "beam", "duration": 1, "gravity": [0, -G, 0], "bodies": [beam],
                                   "solver": _pbd("auto") | {"substeps": 100}}, threads=study.threads)
    end = simulation.positions[:, 0] > 1 - cell / 2
    rests = relax(simulation, 1, period(D, DENSITY), most=4)
    tip = simulation.positions[end].mean(axis=0)
    return [-tip[1] / tip[0], rests]


@protocol("cantilever", "a clamped strip that bends under its weight: drop over reach of its end, over Gamma = density g L^3 / D")
def cantilever(study):
    def case(method, mesh, cells, substeps, gamma, measured):
        value, rests = study.cell(f"cantilever, {method}, {mesh}, {cells} cells, {substeps} substeps, Gamma {gamma}", measured)
        compare(study, method=method, mesh=mesh, cells=cells, substeps=substeps, setting="Gamma", at=gamma, value=value,
                reference=heavy_elastica(gamma), resolved=cells / np.sqrt(gamma) >= 2, note="" if rests else "not at rest")

    for mesh in MESHES:
        for method in methods(study):
            slow = method == "Desbrun"  # 20 s for each of the softer strips
            for cells in (12,) if study.quick else (24, 48) if method not in ("hinges, projected", "Desbrun") else (24,):
                for gamma in (1, 10) if study.quick or slow else (0.1, 1, 10, 100, 1000):
                    case(method, mesh, cells, 20, gamma, lambda: drop_over_reach(study, method, mesh, cells, 20, gamma))
            if not study.quick and method in FILTERED:
                case(method, mesh, 96, 40, 1000, lambda: drop_over_reach(study, method, mesh, 96, 40, 1000))
    for method in () if study.quick else ("hinges, projected", *FILTERED):
        for substeps in (5, 10, 40, 80):
            for gamma in (1, 100):
                case(method, "grid", 24, substeps, gamma, lambda: drop_over_reach(study, method, "grid", 24, substeps, gamma))
    for cells in () if study.quick else (20,):
        for gamma in (1, 10):
            case("tetrahedra", "grid", cells, 100, gamma, lambda: solid_drop_over_reach(study, cells, gamma))
    gammas = np.geomspace(0.1, 1000, 40)
    curve_chart(study, "Gamma = density g L^3 / D", "drop over reach",
                [("heavy elastica", gammas, [heavy_elastica(gamma) for gamma in gammas])], log=True)


# ---- Bend and twist --------------------------------------------------------------------------------------------------


@functools.lru_cache(None)
def sag_of_ribbon(curl, gamma, width, inextensible=False):
    """Drop of the end, over L, of a ribbon that is curved at rest by the angle `curl` (rad) about an axis across it,
    clamped, and that hangs with its weight along that axis, so that it can only sag by twisting.

    gamma: density g L^3 / D. width over L. Kirchhoff's equations of a ribbon that does not bend in its own plane, with
    the directors t, n, b (t' = k n, n' = -k t + tau b, b' = -tau n), Poisson's ratio 0 and the energy per width and D of
    ((k - curl)^2 + 2 tau^2 + width^2 / 12 tau'^2) / 2. Its last term is the warping of a plate, which the clamp
    hinders; inextensible adds Sadowsky's term (tau^2 / k)^2 / 2, the curvature across that a developable surface must
    have, where a sheet that may stretch remains straight across.
    """
    s, warp = np.unique(np.concatenate([np.linspace(0, 1, 101), np.linspace(0, width, 41)])), width**2 / 12
    # The rows are the downward components of t, n and b; k, tau, tau', the torque T and the moment in the plane.
    y = np.stack([0 * s, 0 * s, 1 + 0 * s, curl + 0 * s, 0 * s, 0 * s, 0 * s, 0 * s])
    for load in np.linspace(gamma / 6, gamma, 6):
        def slope(s, y):
            t, n, b, k, tau, dtau, T, m = y
            dM, dT = -m * tau - load * (1 - s) * n, m * k
            if inextensible:
                M, dk = k - curl - tau**4 / k**3, (dM + 4 * tau**3 / k**3 * dtau) / (1 + 3 * tau**4 / k**4)
                stiff = 2 * tau + 2 * tau**3 / k**2
            else:
                M, dk, stiff = k - curl, dM, 2 * tau
            return np.stack([k * n, -k * t + tau * b, -tau * n, dk, dtau, (stiff - T) / warp, dT,
                             M * tau - T * k + load * (1 - s) * b])

        found = solve_bvp(slope, lambda a, b: np.array([a[0], a[1], a[2] - 1, a[4], b[3] - curl, b[5], b[6], b[7]]), s, y,
                          tol=1e-6, max_nodes=20000)
        if not found.success:
            raise RuntimeError(f"the ribbon of curl {curl} and gamma {load}: {found.message}")
        s, y = found.x, found.y
    nodes, weights = np.polynomial.legendre.leggauss(200)
    return float(np.sum(weights * found.sol((nodes + 1) / 2)[0]) / 2)


def sag(study, method, mesh, cells, substeps, curl, gamma, width):
    points, faces, clamped, end = strip(1, width, cells, max(2, round(cells * width)), mesh)
    angle = points[:, 0] * curl
    start = np.stack([np.sin(angle) / curl, (1 - np.cos(angle)) / curl, points[:, 2]], axis=1)
    D = DENSITY * G / gamma
    simulation = malha.Simulation(sheet(start, faces, method, D=D, Y=1e5 * D, density=DENSITY, pins=clamped,
                                        substeps=substeps, iterations=4, gravity=(0, 0, -G)), threads=study.threads)
    rests = relax(simulation, 1, period(D, DENSITY), tolerance=5e-6)
    return [(start - simulation.positions)[end, 2].mean(), rests]


@protocol("bend and twist", "a ribbon that is curved at rest and can only sag by twisting: the drop of its end, over Gamma")
def bend_and_twist(study):
    width = 0.2
    for mesh in MESHES:
        for method in methods(study, FILTERED[1:]):
            for cells in (20,) if study.quick or method not in FILTERED else (20, 40):
                for curl, gammas in {1: (3,)}.items() if study.quick else CURLS.items():
                    for gamma in gammas:
                        value, rests = study.cell(
                            f"bend and twist, {method}, {mesh}, {cells} cells, 80 substeps, width {width}, curl {curl} pi, Gamma {gamma}",
                            lambda: sag(study, method, mesh, cells, 80, curl * np.pi, gamma, width))
                        right, other = (sag_of_ribbon(curl * np.pi, gamma, width, flag) for flag in (False, True))
                        compare(study, method=method, mesh=mesh, cells=cells, substeps=80, setting=f"curl {curl} pi, Gamma",
                                at=gamma, value=value, reference=right, resolved=abs(other / right - 1) < 0.02,
                                note="" if rests else "not at rest")
    loads = np.geomspace(0.8, 36, 6)
    curve_chart(study, "Gamma = density g L^3 / D", "drop of the end over L",
                [(f"curved by {curl:g} pi", loads, [sag_of_ribbon(curl * np.pi, load, width) for load in loads]) for curl in CURLS],
                log=True)


# In pi, with values of Gamma. A sheet that may stretch then sags as one that may not, within 2 %, and by twisting: a
# straighter ribbon sags as far by what little it bends in its own plane.
CURLS = {1: (1, 3), 1.5: (3,), 2: (3, 10)}


# ---- Lateral buckling ------------------------------------------------------------------------------------------------


@functools.lru_cache(None)
def buckling_load(depth, poisson=0.0, along=12, across=8):
    """Gamma = density g L^3 / D at which a plate that is clamped at one side, with its depth vertical, buckles laterally.

    depth: over L. Ritz's method with Legendre's polynomials: the plane stress under the plate's weight, and Kirchhoff's
    plate with that stress. As the depth goes to 0 it is the beam of Timoshenko and Gere, "Theory of elastic stability",
    1961, chapter 6, under its weight: 12.85 sqrt(B C / D^2) with the rigidities of bending, B = (1 - poisson^2) D, and of
    torsion, C = 2 (1 - poisson) D, for each unit of depth.
    """
    line, lines = np.polynomial.legendre.leggauss(30)
    x, y, weights = (line + 1) / 2, line, np.outer(lines / 2, lines * depth / 2).ravel()
    polynomial = np.polynomial.Polynomial

    def powers(first, count, places, domain, factor):
        """x^first times Legendre's polynomials, with two derivatives."""
        basis = [polynomial([0] * first + [1]) * np.polynomial.legendre.Legendre.basis(i, domain=domain).convert(kind=polynomial)
                 for i in range(count)]
        return [factor**d * np.array([(p.deriv(d) if d else p)(places) for p in basis]) for d in range(3)]

    def products(first):
        a, b = powers(first, along, x, [0, 1], 1), powers(0, across, y, [-1, 1], 2 / depth)
        return lambda i, j: np.einsum("ia,jb->ijab", a[i], b[j]).reshape(along * across, -1)

    plane = products(1)
    ux, uy, none = plane(1, 0), plane(0, 1), np.zeros((along * across, weights.size))
    ex, ey, shear = np.vstack([ux, none]), np.vstack([none, uy]), np.vstack([uy, ux])
    c = 1 / (1 - poisson**2)
    stiffness = (c * ((ex * weights) @ ex.T + (ey * weights) @ ey.T + poisson * ((ex * weights) @ ey.T + (ey * weights) @ ex.T)) +
                 (shear * weights) @ shear.T / (2 * (1 + poisson)))
    weight = np.concatenate([np.zeros(along * across), -(plane(0, 0) * weights).sum(axis=1)])
    moved = np.linalg.solve(stiffness, weight)
    sx, sy, sxy = moved @ ex, moved @ ey, moved @ shear / (2 * (1 + poisson))
    sx, sy = c * (sx + poisson * sy), c * (sy + poisson * sx)
    bent = products(2)
    xx, yy, xy, wx, wy = bent(2, 0), bent(0, 2), bent(1, 1), bent(1, 0), bent(0, 1)
    bending = ((xx * weights) @ xx.T + (yy * weights) @ yy.T + 2 * (1 - poisson) * (xy * weights) @ xy.T +
               poisson * ((xx * weights) @ yy.T + (yy * weights) @ xx.T))
    stress = (wx * weights * sx) @ wx.T + (wy * weights * sy) @ wy.T + (wx * weights * sxy) @ wy.T + (wy * weights * sxy) @ wx.T
    return 1 / eigh(-stress, bending, eigvals_only=True)[-1]


def amplification(study, method, mesh, cells, depth, substeps, gamma):
    """How much farther a plate is pushed sideways by a small force on it than it would be without its own weight; None
    where it does not come to rest."""
    points, faces, clamped, end = strip(1, depth, cells, max(2, round(cells * depth)), mesh)
    D, sideways = DENSITY * G / gamma, 1e-3
    simulation = malha.Simulation(sheet(points, faces, method, D=D, Y=1e5 * D, density=DENSITY, pins=clamped, substeps=substeps,
                                        iterations=10, refinement=40, gravity=(0, -sideways * G, -G)), threads=study.threads)
    if not relax(simulation, 1, period(D, DENSITY), tolerance=5e-6, most=30):
        return None
    return (points - simulation.positions)[end, 1].mean() / (sideways * gamma / 8)


def measured_buckling_load(study, method, mesh, cells, depth, substeps):
    """Where the inverse of the amplification, which is linear in Gamma^2 (Southwell's plot), is 0; None where that is not
    found, or the plate does not come to rest."""
    right, known, high, gamma = buckling_load(depth), [], np.inf, 0.6 * buckling_load(depth)
    for _ in range(7):
        by = amplification(study, method, mesh, cells, depth, substeps, gamma)
        if by is None:
            return None
        if not 0 < by < 15:  # it has buckled
            high = gamma
            gamma = 0.6 * gamma if not known else np.sqrt((known[-1][0] + gamma**2) / 2)
            continue
        known.append((gamma**2, 1 / by))
        if len(known) > 1:
            (a, fa), (b, fb) = known[-2:]
            if fa <= fb or b > 50 * right**2:
                return None
            zero = b + fb * (b - a) / (fa - fb)
            if fb < 0.35:
                return np.sqrt(zero)
            gamma = min(np.sqrt(b + 0.8 * (zero - b)), (gamma + high) / 2)
        else:
            gamma = min(1.3 * gamma, (gamma + high) / 2)
    return None


@protocol("lateral buckling", "a deep plate, clamped at one side, that buckles sideways under its weight: Gamma at which it does, "
          "over its depth")
def lateral_buckling(study):
    for mesh in MESHES:
        for method in methods(study, FILTERED[1:]):
            for depth in (0.2,) if study.quick else (0.1, 0.2, 0.5):
                if depth != 0.2 and method == "Desbrun" or depth > 0.3 and method not in FILTERED:
                    continue  # they take minutes
                for cells in (10,) if study.quick else (20, 40) if depth == 0.2 and method in FILTERED else (20,):
                    value = study.cell(f"lateral buckling, {method}, {mesh}, {cells} cells, depth {depth}, 20 substeps",
                                       lambda: measured_buckling_load(study, method, mesh, cells, depth, 20))
                    compare(study, method=method, mesh=mesh, cells=cells, substeps=20, setting="depth over L", at=depth,
                            value=value, reference=buckling_load(depth), note="" if value else "no rest, or no buckling load")
    depths = np.linspace(0.05, 0.55, 11)
    curve_chart(study, "depth over length", "Gamma at which it buckles",
                [("Kirchhoff's plate, Ritz", depths, [buckling_load(depth) for depth in depths])])


# ---- Stick and slip --------------------------------------------------------------------------------------------------


TANGENT = brentq(lambda k: np.tan(k) - k, 4.4, 4.6)  # of a strip that is clamped above and hinged below: P = 20.19 B / L^2


def pinned_mode(s):
    """The deflection of a clamped and hinged strip that buckles, and its slope."""
    k = TANGENT
    return np.sin(k * s) - k * np.cos(k * s) + k * (1 - s), k * np.cos(k * s) + k * k * np.sin(k * s) - k


@functools.lru_cache(None)
def force_ratio(gamma):
    """The horizontal over the vertical force on the lower end of a vertical strip that is pressed onto the ground.

    gamma: density g L^3 / D. The strip is clamped above; its lower end neither slips nor resists a turn. Solves
    theta'' + (V - gamma (1 - s)) sin theta + H cos theta = 0, with theta(0) = theta'(1) = 0 and its lower end below the
    clamp, for shares `pressed` of L by which the clamp is lowered. Returns these and |H| / V, up to where the strip's
    end lies flat on the ground. The end slips where this exceeds the coefficient of friction (Sano, Yamaguchi, Wada, "Slip
    morphology of elastic strips on frictional rigid substrates", 2017; the stick-slip protocol of Romero et al. 2021).
    """
    s = np.linspace(0, 1, 200)
    deflection, slope = pinned_mode(s)
    small = 0.002
    factor = np.sqrt(2 * small / np.sum((slope[1:]**2 + slope[:-1]**2) / 2 * np.diff(s)))
    theta = factor * slope
    y = np.stack([theta, np.gradient(theta, s), factor * deflection, s * (1 - small)])
    forces, found = [TANGENT**2 + gamma / 2, -factor * TANGENT**3], [(0.0, 0.0)]
    for pressed in np.concatenate([[0.002, 0.004, 0.007], np.arange(0.01, 0.5, 0.01)]):
        solved = solve_bvp(lambda s, y, p: np.stack([y[1], -(p[0] - gamma * (1 - s)) * np.sin(y[0]) - p[1] * np.cos(y[0]),
                                                     np.sin(y[0]), np.cos(y[0])]),
                           lambda a, b, p: np.array([a[0], a[2], a[3], b[1], b[2], b[3] - 1 + pressed]), s, y, p=forces,
                           tol=1e-7, max_nodes=20000)
        if not solved.success or np.abs(solved.y[0]).max() > np.pi / 2:
            break
        y, forces = solved.sol(s), solved.p
        found.append((pressed, abs(forces[1] / forces[0])))
    return np.array(found).T


SETTLING = 60  # steps before the clamp moves, after each of which velocities become 0


def pressed_at_slip(study, method, mesh, cells, substeps, friction, gamma, width=0.2, iterations=1):
    """The share of L by which the clamp is lowered when the lower end has slipped by 0.002 L; None: it never does."""
    points, faces, clamped, end = strip(1, width, cells, max(2, round(cells * width)), mesh)
    D, start_pressed, end_pressed, seconds, thick = 0.01, 0.004, 0.34, 30.0, 0.005
    s = np.clip(points[:, 0], 0, 1)
    # It starts in the shape of the mode, because a straight strip would not know to which side to buckle.
    fine = np.linspace(0, 1, 2001)
    slope = pinned_mode(fine)[1]
    factor = np.sqrt(2 * start_pressed / np.sum((slope[1:]**2 + slope[:-1]**2) / 2 * np.diff(fine)))
    steps = np.sqrt(1 - (factor * (slope[1:] + slope[:-1]) / 2)**2) * np.diff(fine)
    down = np.interp(s, fine, np.concatenate([[0], np.cumsum(steps)]))
    flat = np.stack([0 * s, -points[:, 0], points[:, 2]], axis=1)
    start = flat.copy()
    start[s > 0, 0], start[s > 0, 1] = factor * pinned_mode(s[s > 0])[0], -down[s > 0]
    start_pressed = 1 - down.max()
    lower = {"particles": clamped, "motion": [
        {"time": SETTLING / 60}, {"time": SETTLING / 60 + seconds, "translate": [0, start_pressed - end_pressed, 0]}]}
    scene = sheet(flat, faces, method, D=D, Y=1e5 * D, density=DENSITY, pins=[lower], substeps=substeps,
                  iterations=iterations, gravity=(0, -gamma * D / DENSITY, 0))
    scene["environment"] = [{"name": "ground", "shape": {"plane": {}}, "friction": friction, "thickness": thick,
                             "transform": {"translate": [0, start[:, 1].min() - thick, 0]}}]
    swing = 15.4 * np.sqrt(D / DENSITY)  # 1/s, of a clamped and hinged strip; the drag is critical
    scene["wind"] = {"velocity": [0, 0, 0], "drag": 2 * swing * DENSITY * width / len(points)}
    simulation = malha.Simulation(scene, threads=study.threads)
    simulation.positions = start
    for _ in range(SETTLING):  # from the continuum's shape to the mesh's own, without the swing that would make it slip early
        simulation.step()
        simulation.velocities = np.zeros_like(start)
    at, settled = simulation.positions[end, 0].mean(), simulation.time
    while simulation.time < settled + seconds:
        simulation.step(6)
        if abs(simulation.positions[end, 0].mean() - at) > 0.002:
            return start_pressed + (end_pressed - start_pressed) * (simulation.time - settled) / seconds
    return None


@protocol("stick and slip", "a vertical strip that is pressed onto the ground: the coefficient of friction at which its end slips, "
          "over how far it is pressed", bar=0.1)
def stick_and_slip(study):
    for gamma in (0,) if study.quick else (0, 5):
        pressed, ratio = force_ratio(gamma)
        for mesh in MESHES:
            for method in FILTERED if gamma else methods(study):
                for cells in (12,) if study.quick else (24, 48) if method in FILTERED and not gamma else (24,):
                    for friction in (0.2,) if study.quick else (0.1, 0.15, 0.2, 0.25, 0.3):
                        value = study.cell(
                            f"stick and slip, settled, {method}, {mesh}, {cells} cells, 20 substeps, friction {friction}, Gamma {gamma}",
                            lambda: pressed_at_slip(study, method, mesh, cells, 20, friction, gamma))
                        compare(study, method=method, mesh=mesh, cells=cells, substeps=20, setting=f"Gamma {gamma}, friction",
                                at=friction, value=None if value is None else np.interp(value, pressed, ratio),
                                reference=friction, note="never slips" if value is None else f"pressed by {value:.4f} L")
    curves = {gamma: force_ratio(gamma) for gamma in (0, 5)}
    curve_chart(study, "pressed, as a share of L", "coefficient of friction; above the curve it sticks",
                [(f"Gamma {gamma}", *curve) for gamma, curve in curves.items()], error_over="coefficient of friction",
                place=lambda row: (np.interp(row["value"], *curves[int(row["setting"].split()[1][:-1])][::-1]), row["at"]))


# ---- Mechanics: benchmarks and closed forms of others -----------------------------------------------------------------
#
# What `substeps` counts in these protocols, such as those in which a wave crosses a cell, each of them says.


def results(study, make, reference, *, method, mesh, cells, substeps=None, case="", resolved=True, scale=None):
    """Measures a cell and adds a row for each of its quantities.

    make: returns {quantity: value}. reference: {quantity: what it should be}. case: what distinguishes the cell from others
    of the same method, mesh and settings; it goes before the quantity in the table. scale: {quantity: what its error is a
    share of}, where that is not the reference.
    """
    def cell():
        try:
            return make()
        except malha.Diverged:
            return {}

    values = study.cell(f"{study.protocol}, {method}, {mesh}, {cells} cells, {substeps} substeps" +
                        (f", {case}" if case else ""), cell)
    for quantity, one in reference.items():
        value = values.get(quantity)
        compare(study, method=method, mesh=mesh, cells=cells, substeps=substeps, setting="quantity",
                at=f"{case}, {quantity}" if case else quantity, value=value, reference=one, resolved=resolved, scale=(scale or {}).get(quantity),
                note="" if value is not None else "no result")


def errors_chart(study):
    """The section of the protocol that runs, with a chart of its errors: of each method and mesh the finest cells."""
    finest = {}
    for row in sorted((row for row in study.rows if row["protocol"] == study.protocol),
                      key=lambda row: (row["cells"], row["substeps"] or 0)):
        finest[row["at"], row["method"], row["mesh"]] = row
    quantities, names, meshes = [list(dict.fromkeys(key[i] for key in finest)) for i in range(3)]
    figure, axes = plt.subplots(figsize=(13, max(3, 1 + 0.4 * len(quantities))))
    for method, mesh in dict.fromkeys(key[1:] for key in finest):
        rows = [row for key, row in finest.items() if key[1:] == (method, mesh) and row["value"] is not None]
        sign = [np.sign(row["value"] - row["reference"]) * 100 * row["error"] for row in rows]
        axes.plot(sign, [quantities.index(row["at"]) for row in rows], ls="none", marker="s^oD"[meshes.index(mesh)], markersize=7,
                  color=studies.COLOURS[names.index(method) % len(studies.COLOURS)],
                  fillstyle="none" if mesh == "irregular" else "full", label=f"{method}, {mesh}")
    bar = 100 * PROTOCOLS[study.protocol].bar
    axes.axvspan(-bar, bar, color="#2ca02c", alpha=0.12, lw=0)
    axes.set_xscale("symlog", linthresh=2 * bar)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g} %")
    axes.set_yticks(range(len(quantities)), quantities)
    axes.set(xlabel="error of the finest mesh; shaded: passed", ylim=(len(quantities) - 0.5, -0.5))
    figure.legend(loc="center right", fontsize=10)
    figure.subplots_adjust(left=0.24, right=0.74, top=0.96, bottom=min(0.3, 0.9 / figure.get_figheight()))
    section(study, figure)


def simulation_of(study, bodies, solver, **scene):
    """A simulation of bodies of malha.body, in double. solver: keys of the solver; scene: further keys of the scene."""
    return malha.Simulation({"name": "protocol", "duration": 1, "solver": {"type": "pbd", "precision": "double"} | solver,
                             "bodies": bodies, **scene}, threads=study.threads)


def square(along, across, mesh, place=lambda p: p, *, aspect=1.0, seed=1):
    """A mesh of the unit square (s, t), which `place` maps to space: from an array (N, 2) to one (N, 3).

    mesh: "grid" (quads), or "irregular": inner points moved at random by up to 0.3 cells, Delaunay's triangles, half of
    them turned over. aspect: the length of the image of a unit of s over that of t. Returns points, faces and (s, t).
    """
    flat = np.stack(np.meshgrid(np.linspace(0, 1, along + 1), np.linspace(0, 1, across + 1), indexing="ij"), -1).reshape(-1, 2)
    if mesh == "grid":
        return place(flat), quads(along, across), flat
    random = np.random.default_rng(seed)
    inside = ((flat > 1e-9) & (flat < 1 - 1e-9)).all(axis=1)
    flat[inside] += random.uniform(-0.3, 0.3, (inside.sum(), 2)) / [along, across]
    return place(flat), mixed_triangles(flat, random, 1e-6 / along / across, aspect), flat


def solid(cells, mesh, place, seed=1):
    """Tetrahedra of the unit cube, which `place` maps to space. cells: along x, y and z.

    mesh: "grid", five tetrahedra a cell whose orientation alternates; or "irregular", six a cell (Kuhn), inner points
    moved at random by up to 0.15 cells. Returns points, tetrahedra and the points of the cube.
    """
    count = np.array(cells) + 1
    cube = np.stack(np.meshgrid(*[np.linspace(0, 1, n) for n in count], indexing="ij"), -1).reshape(-1, 3)
    cell = np.stack(np.meshgrid(*[np.arange(n) for n in cells], indexing="ij"), -1).reshape(-1, 3)
    corners = np.ravel_multi_index((cell[:, None] + np.indices((2, 2, 2)).reshape(3, 8).T).T, count).T  # (cells, 8)
    if mesh == "grid":
        even, odd = [[0, 4, 2, 1], [6, 4, 2, 7], [5, 4, 1, 7], [3, 2, 1, 7], [4, 2, 1, 7]], \
            [[4, 0, 6, 5], [2, 0, 6, 3], [1, 0, 5, 3], [7, 6, 5, 3], [0, 6, 5, 3]]
        parity = cell.sum(axis=1) % 2
        tetrahedra = np.concatenate([corners[parity == 0][:, even], corners[parity == 1][:, odd]]).reshape(-1, 4)
    else:
        paths = [[0, 1 << a, (1 << a) | (1 << b), 7] for a in range(3) for b in range(3) if a != b]
        tetrahedra = corners[:, paths].reshape(-1, 4)
        inside = ((cube > 1e-9) & (cube < 1 - 1e-9)).all(axis=1)
        cube[inside] += np.random.default_rng(seed).uniform(-0.15, 0.15, (inside.sum(), 3)) / cells
    points = place(cube)
    inverted = np.linalg.det(points[tetrahedra[:, 1:]] - points[tetrahedra[:, :1]]) < 0
    tetrahedra[inverted] = tetrahedra[inverted][:, [0, 2, 1, 3]]
    return points, tetrahedra, cube


def shares(x):
    """The share of a uniform load that each of some points on a line carries."""
    order = np.argsort(x)
    gaps = np.diff(x[order])
    share = np.zeros(len(x))
    share[order[:-1]] += gaps / 2
    share[order[1:]] += gaps / 2
    return share / share.sum()


def rest(simulation, size, tolerance=1e-3, most=6400, least=25):
    """Steps to rest by kinetic damping; size: about how far the body is displaced (m). Returns whether it rests.

    All velocities become 0 where the kinetic energy has fallen by a tenth from its maximum, so that quick oscillations do
    not hold up slow ones; by Desbrun's method after each step, which is implicit and goes downhill from rest however long
    it is. The body rests when no particle has moved by more than `tolerance` of the size in the second half of all steps, of
    which there are `most` at most and 2 `least` at least. A step should have four substeps or more: the first after
    velocities of 0 moves particles twice as far as it should.
    """
    descends = simulation.scene.to_dict()["solver"]["type"] == "desbrun"
    steps, before, peak = least, simulation.positions, 0.0
    while 2 * steps <= most:
        for _ in range(steps):
            simulation.step()
            energy = np.sum(simulation.velocities**2)
            peak = max(peak, energy)
            if descends or energy < 0.9 * peak:
                simulation.velocities, peak = np.zeros_like(before), 0.0
        now, steps = simulation.positions, 2 * steps
        if not np.isfinite(energy):
            return False
        if np.abs(now - before).max() < tolerance * size:
            return True
        before = now
    return False


def isotropic_springs(Y, nu=1 / 3):
    """Springs of a sheet of Young's modulus times thickness Y (N/m), for quads; of triangles the edges alone."""
    return [{"type": "distance", "elements": ["edges"], "rigidity": Y / (1 + nu)},
            {"type": "distance", "elements": ["shear"], "rigidity": Y * nu / (1 - nu**2)}]


def membrane(Y, nu):
    return [{"type": "membrane", "young_modulus": Y, "poisson_ratio": nu}]


def neo_hookean(E, nu):
    return [{"type": "neo_hookean", "young_modulus": E, "poisson_ratio": nu}]


STRETCH = {  # sheets that stretch: constraints for a modulus Y (N/m) and nu = 1/3, and the method
    "membrane": (lambda mesh, Y: membrane(Y, 1 / 3), "pbd"),
    "springs": (lambda mesh, Y: isotropic_springs(Y) if mesh == "grid" else
                [{"type": "distance", "elements": ["edges"], "rigidity": Y}], "pbd"),
    "membrane, Desbrun": (lambda mesh, Y: membrane(Y, 1 / 3), "desbrun"),
    "springs, Desbrun": (lambda mesh, Y: isotropic_springs(Y) if mesh == "grid" else
                         [{"type": "distance", "elements": ["edges"], "rigidity": Y}], "desbrun"),
}


def method_keys(kind, dt, step):
    """The solver's keys: pbd by substeps of dt; Desbrun's method, which needs none, by steps of `step`."""
    return {"type": "pbd", "dt": 10 * dt, "substeps": 10, "levels": "off"} if kind == "pbd" else \
        {"type": "desbrun", "dt": step, "refinement_iterations": 5}


@protocol("Cook's membrane", "a tapered panel, clamped at its left side, sheared by a load at its right one: how far the middle of that "
          "side rises")
def cooks_membrane(study):
    """Cook (1974): corners (0, 0), (48, 44), (48, 60), (0, 44), E = 1, nu = 1/3, thickness 1, a shear of 1 in all.

    The displacement of (48, 52) is 23.96 in small strain; linear triangles of our own give 23.944 and 23.960 with 128 and
    256 cells. The load here is 0.004, so that the strain is small.
    """
    load = 0.004

    def tapered(p):
        return np.stack([48 * p[:, 0], 44 * p[:, 0] + (44 - 28 * p[:, 0]) * p[:, 1], 3 / n * 8 * p[:, 2] if p.shape[1] == 3 else
                         0 * p[:, 0]], axis=1)

    def rise(kind, body, points, weights):
        simulation = simulation_of(study, [body], method_keys(kind, 16 / n / crossing, 40))
        simulation.set_forces(np.outer(weights * load, [0, 1, 0]))
        if not rest(simulation, 23.96 * load):
            return {}
        up = simulation.positions[:, 1] - points[:, 1]
        side = np.flatnonzero(weights)
        side = side[np.argsort(points[side, 1])]
        return {"rise": np.interp(52, points[side, 1], up[side]) / load}

    def sheet_of(method, mesh):
        points, faces, flat = square(n, n, mesh, tapered)
        constraints, kind = STRETCH[method]
        right = flat[:, 0] == 1
        weights = np.zeros(len(points))
        weights[right] = shares(points[right, 1])
        return rise(kind, malha.body(points, faces, density=1, pins=np.flatnonzero(flat[:, 0] == 0),
                                     constraints=constraints(mesh, 1.0)), points, weights)

    def solid_of(mesh):
        points, tetrahedra, cube = solid((n, n, 1), mesh, tapered)
        right = cube[:, 0] == 1
        weights = np.zeros(len(points))
        weights[right] = np.repeat(shares(points[right & (cube[:, 2] == 0), 1]), 2) / 2 * 24 / n  # per unit of thickness
        return rise("pbd", malha.body(points, tetrahedra=tetrahedra, density=1, pins=np.flatnonzero(cube[:, 0] == 0),
                                      constraints=neo_hookean(1.0, 1 / 3)), points, weights)

    for mesh in MESHES:
        for method in STRETCH if study.quick else (*STRETCH, "tetrahedra"):
            for n, crossing in ((8, 6),) if study.quick else ((8, 6), (16, 3), (16, 6), (32, 6)):
                if "Desbrun" in method and crossing == 3 or (method == "tetrahedra" and n == 32):
                    continue
                results(study, lambda: solid_of(mesh) if method == "tetrahedra" else sheet_of(method, mesh), {"rise": 23.96},
                        method=method, mesh=mesh, cells=n, substeps=None if "Desbrun" in method else crossing)
    errors_chart(study)


@protocol("twisted beam", "a beam of tetrahedra, twisted by a right angle, under a load at its end: the end's displacement")
def twisted_beam(study):
    """MacNeal and Harder (1985): length 12, width 1.1, thickness 0.32, twisted by 90 degrees, E = 29e6, nu = 0.22.

    A unit load in the plane of the end's width, which is along z there, moves it by 5.424e-3, one out of it by 1.754e-3.
    """
    def place(p):
        y, z, angle = 1.1 * (p[:, 1] - 0.5), 0.32 * (p[:, 2] - 0.5), np.pi / 2 * p[:, 0]
        return np.stack([12 * p[:, 0], y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)], axis=1)

    def displacements():
        points, tetrahedra, cube = solid(cells, mesh, place)
        end, found = cube[:, 0] == 1, {}
        for quantity, axis, size in (("out of plane", 1, 1.754e-3), ("in plane", 2, 5.424e-3)):
            body = malha.body(points, tetrahedra=tetrahedra, density=1, pins=np.flatnonzero(cube[:, 0] == 0),
                              constraints=neo_hookean(29e6, 0.22))
            simulation = simulation_of(study, [body], {"dt": 40 * 0.32 / cells[2] / crossing / np.sqrt(29e6 / 3), "substeps": 40})
            simulation.set_forces(np.outer(100 * end / end.sum(), np.eye(3)[axis]))
            if rest(simulation, 100 * size, 3e-3, 3200):
                found[quantity] = (simulation.positions - points)[end, axis].mean() / 100
        return found

    for mesh in MESHES[:1 if study.quick else 2]:
        for cells, crossing in (((8, 2, 1), 4),) if study.quick else (((16, 4, 2), 4), ((24, 4, 2), 5)):
            results(study, displacements, {"out of plane": 1.754e-3, "in plane": 5.424e-3}, method="tetrahedra", mesh=mesh,
                    cells=cells[0], substeps=crossing)
    errors_chart(study)


@protocol("bar", "a bar of tetrahedra of the slenderness 5 under small loads at its end: extension, contraction, deflection and twist")
def bar(study):
    """Length 1, width 0.2, E = 1, nu = 0.3, one end clamped (free to contract for the extension).

    Extension F L / (E A) and contraction by nu of it; deflection F L^3 / (3 E I) + F L / (k G A) with k = 10 (1 + nu) /
    (12 + 11 nu) (Timoshenko 1921, Cowper 1966); twist T L / (0.1406 G a^4) (Saint-Venant).
    """
    a, E, nu = 0.2, 1.0, 0.3
    G12, area, inertia, k = E / 2 / (1 + nu), a * a, a**4 / 12, 10 * (1 + nu) / (12 + 11 * nu)

    def place(p):
        return p * [1, a, a] - [0, a / 2, a / 2]

    def loaded():
        points, tetrahedra, cube = solid((5 * n, n, n), mesh, place)
        end, root, found = cube[:, 0] == 1, cube[:, 0] == 0, {}
        weights = np.zeros(len(points))
        weights[end] = np.outer(shares(np.linspace(0, 1, n + 1)), shares(np.linspace(0, 1, n + 1))).ravel()

        def displaced(forces, size, pins, environment=()):
            body = malha.body(points, tetrahedra=tetrahedra, density=1, pins=pins, constraints=neo_hookean(E, nu))
            simulation = simulation_of(study, [body], {"dt": 4 * a / n / crossing / np.sqrt(E / 3), "substeps": 4},
                                       environment=list(environment))
            simulation.set_forces(forces)
            return simulation.positions - points if rest(simulation, size, 3e-3) else None

        # Extension: both ends are pulled, so that nothing hinders the contraction.
        opposite = np.zeros(len(points))
        opposite[root] = weights[end]
        load = 1e-3 * E * area
        u = displaced(np.outer(load * (weights - opposite), [1, 0, 0]), 1e-3, [])
        if u is not None:
            middle = np.abs(cube[:, 0] - 0.5) < 0.21
            found["extension"] = (u[end, 0].mean() - u[root, 0].mean()) * E * area / load
            slope = np.polyfit(points[middle, 1], u[middle, 1], 1)[0]
            found["contraction"] = -slope / found["extension"] * E * area / load
        load = 1e-3 * 3 * E * inertia
        u = displaced(np.outer(load * weights, [0, 1, 0]), 1e-3, np.flatnonzero(root))
        if u is not None:
            found["deflection"] = u[end, 1].mean() / load
        around = np.cross([1, 0, 0], points) * weights[:, None]  # forces that have no resultant
        torque = np.cross(points, around)[:, 0].sum()
        u = displaced(1e-3 * 0.1406 * G12 * a**4 / torque * around, 1e-3, np.flatnonzero(root))
        if u is not None:
            edge = end & ((cube[:, 1] == 0.5) | (cube[:, 2] == 0.5)) if n % 2 == 0 else end
            spin = np.cross(points, u)[edge, 0].sum() / (points[edge, 1:]**2).sum()
            found["twist"] = spin / (1e-3 * 0.1406 * G12 * a**4)
        return found

    references = {"extension": 1.0, "contraction": nu, "deflection": 1 / (3 * E * inertia) + 1 / (k * G12 * area),
                  "twist": 1 / (0.1406 * G12 * a**4)}
    for mesh in MESHES:
        for n, crossing in ((2, 5),) if study.quick else ((2, 5), (4, 5)):
            results(study, loaded, references, method="tetrahedra", mesh=mesh, cells=n, substeps=crossing)
    errors_chart(study)


def catenary_of(length):
    """The sag of a catenary of that length over a span of 1, and its slope at the ends."""
    a = brentq(lambda a: 2 * a * np.sinh(0.5 / a) - length, 0.05, 50)
    return a * (np.cosh(0.5 / a) - 1), np.sinh(0.5 / a)


HUNG = {  # chains and strips that hardly stretch: constraints, and keys of the solver
    "stiff springs": ([SPRINGS], {"type": "pbd"}),
    "membrane": (membrane(1e4, 0), {"type": "pbd"}),
    "springs, Desbrun": ([{**SPRINGS, "rigidity": 2e3}], {"type": "desbrun", "refinement_iterations": 10}),
    "membrane, Desbrun": (membrane(2e3, 0), {"type": "desbrun", "refinement_iterations": 10}),
}


def hung_body(method, mesh, along, across, place, mass, **body):
    """A chain, or a strip, along s with `across` cells along t. place: from (s, t) to space. Returns the body and (s, t).

    It is flat at rest and not stretched by `place`, which keeps its length 'length' along s and its width along t.
    """
    constraints, _ = HUNG[method]
    length = body.pop("length")
    if mesh == "chain":
        flat = np.stack([np.linspace(0, 1, along + 1), np.full(along + 1, 0.5)], axis=1)
        mesh_data = {"lines": np.stack([np.arange(along), np.arange(1, along + 1)], axis=1)}
    else:
        _, faces, flat = square(along, across, mesh, lambda p: p, aspect=along / across)
        mesh_data = {"faces": faces, "rest": {"points": (np.insert(flat, 1, 0, axis=1) * [length, 0, length * across / along]).tolist()}}
    if mesh != "grid":
        constraints = [{**one, "elements": ["edges"]} if one["type"] == "distance" else one for one in constraints]
    return malha.body(place(flat), mass=mass, constraints=constraints, **mesh_data, **body), flat


@protocol("catenary", "an inextensible chain or strip between two points: its sag, and its slope at the ends")
def catenary(study):
    """Span 1 m; lengths 1.05 and 1.5 m. The start is a circular arc of the same length.

    Substeps are those of 1/60 s. Membranes have 1e4 N/m, for a weight of 1 N, so that they stretch by some 1e-4; those and the
    springs of Desbrun's method, which creeps where they are stiff or the cells are small, have 2e3 N/m and 16 cells.
    """
    def hung():
        half = brentq(lambda t: np.sin(t) / t - 1 / length, 1e-6, np.pi)
        radius, across = length / 2 / half, 4

        def place(p):
            angle = (2 * p[:, 0] - 1) * half
            return np.stack([0.5 + radius * np.sin(angle), radius * (np.cos(half) - np.cos(angle)),
                             length * across / n * p[:, 1]], axis=1)

        body, flat = hung_body(method, mesh, n, across, place, 0.1, length=length)
        ends = np.flatnonzero((flat[:, 0] == 0) | (flat[:, 0] == 1))
        simulation = simulation_of(study, [{**body, "pins": [{"particles": ends.tolist()}]}],
                                   HUNG[method][1] | {"dt": 1 / 60, "substeps": substeps or 1},
                                   gravity=[0, -G, 0])
        if not rest(simulation, 1):
            return {}
        x = simulation.positions
        middle = np.argsort(x[:, 1])[:1 if mesh == "chain" else across + 1]
        near = (flat[:, 0] > 0) & (flat[:, 0] < (1.5 if mesh == "chain" else 3.5) / n)
        # The chord from the end leaves it at half its length: catenaries have tan(angle) linear in the arc length.
        tangent = np.mean(-x[near, 1] / x[near, 0] / (1 - flat[near, 0]))
        return {"sag": -x[middle, 1].mean(), "slope": tangent}

    for mesh in ("chain", "grid") if study.quick else ("chain", "grid", "irregular"):
        for method in HUNG:
            if mesh == "chain" and "membrane" in method:
                continue
            for n, substeps in ((16, 20),) if study.quick else ((16, 20), (64, 20), (64, 80)):
                if "Desbrun" in method:
                    if n == 64:
                        continue
                    substeps = None
                for length in (1.5,) if study.quick else (1.05, 1.5):
                    sag, slope = catenary_of(length)
                    results(study, hung, {"sag": sag, "slope": slope}, method=method, mesh=mesh, cells=n, substeps=substeps,
                            case=f"length {length}")
    errors_chart(study)


def frequency(times, signal):
    """The frequency (Hz) of a signal about 0, by the line through its first five zero crossings; None of fewer than three."""
    k = np.flatnonzero(signal[:-1] * signal[1:] < 0)[:5]
    if len(k) < 3:
        return None
    crossings = times[k] - signal[k] * (times[k + 1] - times[k]) / (signal[k + 1] - signal[k])
    return 0.5 / np.polyfit(np.arange(len(k)), crossings, 1)[0]


def frequencies(simulation, still, modes, weights, axis, steps):
    """The frequency of each mode of a body that was released from `still` and a sum of the modes along `axis`.

    still: (N, 3), the equilibrium; modes: {name: (N,) shape}; weights: (N,) masses, with which the displacement is
    projected on each mode after every step. What that contains of the other modes is small where the shapes are right.
    """
    shapes = np.array(list(modes.values())) * weights
    signals, times = [], []
    for _ in range(steps):
        signals.append(shapes @ (simulation.positions - still)[:, axis])
        times.append(simulation.time)
        simulation.step()
    return {name: frequency(np.array(times), np.array(signals)[:, i]) for i, name in enumerate(modes)}


def particle_masses(simulation):
    """Masses (kg) of the particles, 0 where they are pinned."""
    w = simulation.inverse_masses
    return np.divide(1, w, out=np.zeros_like(w), where=w > 0)


@protocol("hanging chain", "an inextensible chain or strip that hangs from its end and swings: its first three frequencies")
def hanging_chain(study):
    """Daniel Bernoulli (1733): j / (4 pi) sqrt(g / L), with the zeros j of the Bessel function J0.

    Length 1 m, amplitudes of 5 mm; the start has the chain's length. Substeps are those of 1/60 s; the first period is 1.67 s.
    """
    zeros = jn_zeros(0, 3)

    def swung():
        def modes(s):
            return {f"mode {i + 1}": 0.005 * jv(0, j * np.sqrt(1 - s)) for i, j in enumerate(zeros)}

        def place(p):
            return np.stack([0 * p[:, 0], -p[:, 0], 4 / n * p[:, 1]], axis=1)

        body, flat = hung_body(method, mesh, n, 4, place, 0.1, length=1, pins=[])
        body["pins"] = [{"particles": np.flatnonzero(flat[:, 0] == 0).tolist()}]
        simulation = simulation_of(study, [body], HUNG[method][1] | {"dt": 1 / 60, "substeps": substeps}, gravity=[0, -G, 0])
        if not rest(simulation, 1, 1e-6):
            return {}
        still, shapes = simulation.positions, modes(flat[:, 0])
        line = np.linspace(0, 1, 2001)  # along the arc length
        slopes = np.diff(sum(modes(line).values())) / np.diff(line)
        drop = np.append(0, np.cumsum(np.sqrt(1 - slopes**2) * np.diff(line)))
        start = still.copy()
        start[:, 0] = sum(shapes.values())
        start[:, 1] += flat[:, 0] - np.interp(flat[:, 0], line, drop)
        simulation.positions = start
        simulation.velocities = np.zeros_like(start)
        return frequencies(simulation, still, shapes, particle_masses(simulation), 0, 250)

    references = {f"mode {i + 1}": j / 4 / np.pi * np.sqrt(G) for i, j in enumerate(zeros)}
    for mesh in ("chain", "grid", "irregular"):
        for method in HUNG:
            if mesh == "chain" and "membrane" in method:
                continue
            for n, substeps in ((16, 20),) if study.quick else ((16, 20), (16, 80), (32, 80)):
                if study.quick and "springs" not in method:
                    continue
                results(study, swung, references, method=method, mesh=mesh, cells=n, substeps=substeps)
    errors_chart(study)


def disc(rings, mesh, still=1, inner=0.0, seed=1):
    """Triangles of the unit disc: 6 k points on the k-th ring. Returns points (N, 2), faces and the points of the last rings.

    mesh: "grid", as it is; "irregular": points moved at random by up to 0.3 of the rings' distance, half of the triangles
    turned over. still: the number of last rings whose points are not moved, and are returned. inner: points
    up to that radius are not moved either.
    """
    points = [np.zeros((1, 2))]
    for k in range(1, rings + 1):
        angle = 2 * np.pi * np.arange(6 * k) / (6 * k)
        points.append(k / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    points = np.concatenate(points)
    rim = np.flatnonzero(np.hypot(*points.T) > 1 - (still - 0.5) / rings)
    if mesh == "grid":
        return points, Delaunay(points).simplices, rim
    random = np.random.default_rng(seed)
    moved = np.hypot(*points.T) > inner + 0.01 / rings
    moved[rim] = False
    points[moved] += random.uniform(-0.3, 0.3, (moved.sum(), 2)) / rings
    return points, mixed_triangles(points, random, 0), rim


def lift(flat, y=0.0):
    """Points (x, y, z) of a plane at the height y from (x, z)."""
    return np.insert(flat, 1, y, axis=1)


@protocol("drum", "a taut membrane, round or square, that is released from its first modes: their frequencies")
def drum(study):
    """c j / (2 pi R) with the zeros j of J0 and J1 (round), c / 2 sqrt(m^2 + n^2) / a (square); c^2 = T / density.

    Radius and side are 1 m, the modulus Y = 100 N/m, nu = 1/3, at a stretch of 1.05. The tension of a material that is
    linear in the stretch is Y e / (1 - nu) per length at rest, and that over 1 + e per length now. Amplitudes are 2 mm.
    Substeps are those in a period of the first mode.
    """
    Y, e, density = 100.0, 0.05, 0.1
    c = np.sqrt(Y * e / (1 - 1 / 3) / (1 + e) / (density / (1 + e)**2))
    round_modes = [("mode 01", 0, 0), ("mode 11", 1, 0), ("mode 02", 0, 1)]
    square_modes = [("mode 11", 1, 1), ("mode 21", 2, 1), ("mode 22", 2, 2)]

    def struck():
        if shape == "round":
            flat, faces, rim = disc(n, mesh)
            radius, angle = np.hypot(*flat.T), np.arctan2(flat[:, 1], flat[:, 0])
            modes = {name: jv(m, jn_zeros(m, k + 1)[k] * radius) * np.cos(m * angle) for name, m, k in round_modes}
            body = {"faces": faces}
        else:
            _, faces, flat = square(2 * n, 2 * n, mesh)
            rim = np.flatnonzero(((flat == 0) | (flat == 1)).any(axis=1))
            modes = {name: np.sin(m * np.pi * flat[:, 0]) * np.sin(k * np.pi * flat[:, 1]) for name, m, k in square_modes}
            body = {"faces": faces}
        constraints, kind = STRETCH[method]
        body = malha.body(lift(flat), density=density, pins=rim, rest={"points": lift(flat / (1 + e)).tolist()},
                          constraints=constraints("grid" if shape == "square" and mesh == "grid" else "irregular", Y), **body)
        first = list(references.values())[0]
        simulation = simulation_of(study, [body], {"type": kind, "dt": 1 / first / 50, "substeps": substeps // 50, "levels": "off"}
                                   if kind == "pbd" else {"type": kind, "dt": 1 / first / 50, "substeps": substeps // 50})
        relaxed = rest(simulation, 1, 1e-6)
        still = simulation.positions
        modes = {name: 0.002 * one for name, one in modes.items()}
        start = still.copy()
        start[:, 1] += sum(modes.values())
        simulation.positions = start
        simulation.velocities = np.zeros_like(start)
        return frequencies(simulation, still, modes, particle_masses(simulation), 1, 150) if relaxed else {}

    for shape in ("round", "square"):
        references = {name: c / 2 / np.pi * jn_zeros(m, k + 1)[k] for name, m, k in round_modes} if shape == "round" else \
            {name: c / 2 * np.hypot(m, k) for name, m, k in square_modes}
        for mesh in MESHES:
            for method in STRETCH:
                for n, substeps in ((8, 200),) if study.quick else ((8, 200), (8, 800), (16, 800)):
                    results(study, struck, references, method=method, mesh=mesh, cells=n, substeps=substeps, case=shape)
    errors_chart(study)


@protocol("sliding block", "a block that slides over rough ground: its stopping distance, and the slope at which it begins to slide")
def sliding_block(study):
    """v^2 / (2 mu g) at 3 m/s, mu = 0.5 and, for the slope, tan(angle) = mu. Substeps are those of 1/60 s.

    The slope's angle is found by bisection: at a steeper one a block at rest slides by more than 5 mm within 1 s. The ground
    is tilted within the 0.5 s before. The block has a `damping` of 0.3 then.
    """
    mu = 0.5

    def block(**more):
        if method == "tetrahedra":
            points, tetrahedra, _ = solid((2 * n, n, 2 * n), mesh, lambda p: p * [0.2, 0.1, 0.2] + [0, 0.005, 0])
            return malha.body(points, tetrahedra=tetrahedra, density=500, constraints=neo_hookean(2e5, 0.3), **more)
        points, faces, _ = square(2 * n, 2 * n, mesh, lambda p: lift(p * 0.2, 0.005))
        return malha.body(points, faces, density=0.3, constraints=[
            {**SPRINGS, "elements": ["edges", "shear"] if mesh == "grid" else ["edges"]}, {"type": "bending", "rigidity": 1e-4}], **more)

    def simulated(gravity, **more):
        ground = {"name": "ground", "shape": {"plane": {}}, "friction": mu, "thickness": 0.005}
        kind = {"type": "desbrun"} if "Desbrun" in method else {}
        simulation = simulation_of(study, [block(**more)], {"dt": 1 / 60, "substeps": substeps} | kind,
                                   gravity=list(gravity),
                                   environment=[ground])
        masses = particle_masses(simulation)
        start = masses @ simulation.positions[:, 0] / masses.sum()
        return simulation, lambda: masses @ simulation.positions[:, 0] / masses.sum() - start

    def slid():
        simulation, travelled = simulated((0, -G, 0), velocity=[3, 0, 0])
        simulation.step(75)
        low, high = 0.4, 0.6
        distance = travelled()
        while high - low > 0.005:
            slope = (low + high) / 2
            angle = np.arctan(slope)
            simulation, travelled = simulated((0, -G * np.cos(angle), 0), damping=0.3)
            simulation.step(30)
            for turned in angle * np.arange(1, 31) / 30:
                simulation.gravity = [G * np.sin(turned), -G * np.cos(turned), 0]
                simulation.step()
            before = travelled()
            simulation.step(60)
            low, high = (low, slope) if travelled() - before > 0.005 else (slope, high)
        return {"distance": distance, "slope": (low + high) / 2}

    for method in ("tetrahedra", "cloth", "cloth, Desbrun"):
        for mesh in MESHES[:1 if study.quick else None]:
            for n, substeps in ((2, 20),) if study.quick else ((2, 5), (2, 20), (4, 20)):
                results(study, slid, {"distance": 9 / (2 * mu * G), "slope": mu}, method=method, mesh=mesh, cells=n, substeps=substeps)
    errors_chart(study)


@protocol("capstan", "a rope over a rough cylinder with a weight at either end: the ratio of the weights at which it begins to slide")
def capstan(study):
    """Euler (1769), Eytelwein: exp(mu pi) for a rope over half a cylinder; here mu = 0.3. Substeps are those of 1/60 s.

    Found by bisection: the rope slides when the heavier weight has sunk by more than 2 cm within the second 0.5 s.
    """
    mu, radius, arm = 0.3, 0.1, 0.2

    def chain_over():
        length = np.pi * (radius + 0.002) + 2 * arm
        s = np.linspace(0, length, n + 1) - length / 2
        angle = np.clip(s / (radius + 0.002), -np.pi / 2, np.pi / 2)
        points = (radius + 0.002) * np.stack([np.sin(angle), np.cos(angle), 0 * s], axis=1)
        points[:, 1] -= np.maximum(np.abs(s) - np.pi / 2 * (radius + 0.002), 0)
        low, high = 1.0, 5.0
        while high - low > 0.02:
            ratio = (low + high) / 2
            chain = malha.body(points, lines=np.stack([np.arange(n), np.arange(1, n + 1)], axis=1), mass=0.001,
                               constraints=[{"type": "distance"}])
            simulation = simulation_of(study, [chain], {"dt": 1 / 60, "substeps": substeps}, gravity=[0, 0, 0], environment=[{
                "name": "cylinder", "shape": {"cylinder": {"from": [0, 0, -1], "to": [0, 0, 1], "radius": radius}},
                "friction": mu, "thickness": 0.002}])
            # The weights are forces, so that nothing but the rope has inertia and the rope is nearly massless under them.
            forces = np.zeros_like(points)
            forces[0, 1], forces[-1, 1] = -0.1, -0.1 * ratio
            simulation.set_forces(forces)
            simulation.step(30)
            height = simulation.positions[-1, 1]
            simulation.step(30)
            low, high = (low, ratio) if height - simulation.positions[-1, 1] > 0.02 else (ratio, high)
        return {"ratio": (low + high) / 2}

    for n, substeps in ((30, 20),) if study.quick else ((30, 20), (30, 80), (60, 80)):
        results(study, chain_over, {"ratio": np.exp(mu * np.pi)}, method="stiff springs", mesh="chain", cells=n, substeps=substeps)
    errors_chart(study)


def elastic_pendulum(times, k, mass, length, start):
    """Places (x, y) of a mass on a spring from the origin at the times, from rest at `start`; by DOP853 to 1e-11."""
    def motion(t, state):
        place = state[:2]
        stretched = np.hypot(*place)
        return [*state[2:], *(-k / mass * (1 - length / stretched) * place - [0, G])]

    return solve_ivp(motion, (0, times[-1]), [*start, 0, 0], method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times).y[:2].T


@protocol("elastic pendulum", "a mass on a spring that swings and bounces for a minute: its energy, and its place")
def elastic_pendulum_protocol(study):
    """Length 1 m, 1 kg, 100 N/m, from rest at 30 degrees from the vertical; the reference is integrated by DOP853.

    Energy is that above equilibrium, at the end of the minute over that at its start. The place is that of the last
    second (RMS distance to the reference, of which 5 % of the length pass). Substeps are those of 1/60 s.
    """
    k, mass, length = 100.0, 1.0, 1.0
    start = np.array([np.sin(np.pi / 6), -np.cos(np.pi / 6)])
    lowest = -mass * G * (length + mass * G / k / 2)

    def swung():
        chain = malha.body([[0, 0, 0], [*start, 0]], lines=[[0, 1]], mass=2 * mass, pins=[0],
                           constraints=[{"type": "distance", "compliance": 1 / k}])
        simulation = simulation_of(study, [chain], {"dt": 1 / 60, "substeps": substeps} | solver, gravity=[0, -G, 0])

        def energy():
            x, v = simulation.positions[1], simulation.velocities[1]
            return mass * (v @ v / 2 + G * x[1]) + k / 2 * (np.linalg.norm(x) - length)**2 - lowest

        before, places = energy(), []
        for _ in range(3600):
            simulation.step()
            places.append(simulation.positions[1, :2])
        times = np.append(0, np.arange(1, 3601) / 60)
        reference = elastic_pendulum(times, k, mass, length, start)[1:]
        late = np.linalg.norm(np.array(places) - reference, axis=1)
        return {"energy": energy() / before, "distance after 10 s": np.sqrt(np.mean(late[540:600]**2)),
                "distance after 60 s": np.sqrt(np.mean(late[-60:]**2))}

    solvers = {"springs": {}, "springs, Desbrun": {"type": "desbrun"},
               "springs, Desbrun, 10 refinements": {"type": "desbrun", "refinement_iterations": 10}}
    for method, solver in list(solvers.items())[:2 if study.quick else None]:
        for substeps in (10,) if study.quick else (1, 10, 40, 160):
            results(study, swung, {"energy": 1, "distance after 10 s": 0, "distance after 60 s": 0},
                    scale={"distance after 10 s": length, "distance after 60 s": length},
                    method=method, mesh="chain", cells=1, substeps=substeps)
    errors_chart(study)


@protocol("rod pendulum", "a stiff bar that swings about one of its edges by up to 90 degrees: its period")
def rod_pendulum(study):
    """4 sqrt(I / (m g d)) K(sin(45 degrees)), with the moment of inertia I of the bar about the edge (Huygens 1673, Euler).

    Length 1 m, width and thickness 0.1 m. Substeps are those of 1/60 s.
    """
    a = 0.1
    period = 4 * np.sqrt((1 + a * a) / 3 / (G * np.hypot(1, a) / 2)) * ellipk(0.5)

    def swung():
        turn = np.arctan(a)  # the centre of mass starts level with the edge
        turned = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        points, tetrahedra, cube = solid((10 * n, n, n), mesh, lambda p: (p * [1, a, a]) @ turned)
        edge = (cube[:, 0] == 0) & (cube[:, 1] == 0)
        body = malha.body(points, tetrahedra=tetrahedra, density=100, pins=np.flatnonzero(edge), constraints=neo_hookean(1e7, 0.3))
        simulation = simulation_of(study, [body], {"dt": 1 / 60, "substeps": substeps}, gravity=[0, -G, 0])
        masses = particle_masses(simulation)
        signals, times = [], []
        for _ in range(400):
            signals.append(masses @ simulation.positions[:, 0])
            times.append(simulation.time)
            simulation.step()
        found = frequency(np.array(times), np.array(signals))
        return {"period": 1 / found} if found else {}

    for mesh in MESHES:
        for n, substeps in ((1, 80),) if study.quick else ((1, 20), (1, 80), (2, 160)):
            results(study, swung, {"period": period}, method="tetrahedra", mesh=mesh, cells=n, substeps=substeps)
    errors_chart(study)


def mode_of_cantilever(beta, s):
    """The shape of a mode of a clamped and free beam of length 1 at s, with beta from cos(beta) cosh(beta) = -1."""
    ratio = (np.sinh(beta) - np.sin(beta)) / (np.cosh(beta) + np.cos(beta))
    return np.cosh(beta * s) - np.cos(beta * s) - ratio * (np.sinh(beta * s) - np.sin(beta * s))


@protocol("clamped strip", "a clamped strip that swings without gravity: its first two frequencies")
def clamped_strip(study):
    """Euler and Bernoulli: beta^2 / (2 pi L^2) sqrt(D / density), cos(beta) cosh(beta) = -1; D with Poisson's ratio 0.

    Length 1 m, width 0.25 m, 0.1 kg/m^2, D = 0.01 N m, amplitudes of 1 mm. Substeps are those in the first period.
    """
    D, density = 0.01, 0.1
    betas = [brentq(lambda b: np.cos(b) * np.cosh(b) + 1, *limits) for limits in ((1, 3), (4, 6))]
    references = {f"mode {i + 1}": b * b / 2 / np.pi * np.sqrt(D / density) for i, b in enumerate(betas)}

    def swung():
        points, faces, clamped, _ = strip(1, 0.25, n, n // 4, mesh)
        scene = sheet(points, faces, method, D=D, Y=1e5 * D, density=density, pins=clamped, substeps=substeps // 50, gravity=(0, 0, 0))
        scene["solver"]["dt"] = 1 / references["mode 1"] / 50
        simulation = malha.Simulation(scene, threads=study.threads)
        still = simulation.positions
        shapes = {f"mode {i + 1}": 5e-4 * mode_of_cantilever(b, np.maximum(still[:, 0], 0)) for i, b in enumerate(betas)}
        start = still.copy()
        start[:, 1] += sum(shapes.values())
        simulation.positions = start
        return frequencies(simulation, still, shapes, particle_masses(simulation), 1, 150)

    for mesh in MESHES:
        for method in methods(study):
            for n, substeps in ((16, 200),) if study.quick else ((16, 200), (16, 800), (32, 800)):
                results(study, swung, references, method=method, mesh=mesh, cells=n, substeps=substeps)
    errors_chart(study)


@functools.lru_cache(None)
def elastica(load):
    """Drop and reach of the end of a clamped strip of length 1 under an end load, P L^2 / D = load, along its undeformed axis.

    theta'' = -load sin(theta), theta(0) = 0, theta'(1) = 0; a load above pi^2 / 4 compresses it beyond buckling.
    """
    k = brentq(lambda k: ellipk(k * k) - np.sqrt(load), 1e-6, 1 - 1e-9)
    # theta runs from 0 to alpha, k = sin(alpha / 2); by arc length from the free end it is a pendulum from rest.
    alpha = 2 * np.arcsin(k)
    bent = solve_ivp(lambda s, y: [y[1], -load * np.sin(y[0]), np.cos(y[0]), np.sin(y[0])], (0, 1), [alpha, 0, 0, 0],
                     rtol=1e-10, atol=1e-12).y[:, -1]
    return abs(bent[3]), bent[2]


@protocol("buckling", "a clamped strip that an end load compresses beyond Euler's: the end's deflection and reach, over the load's ratio "
          "to Euler's")
def buckling(study):
    """Euler's elastica (Euler 1744; Love 1927, article 263): clamped and free, loads of 1.5 and 3 times pi^2 D / (4 L^2).

    Length 1 m, width 0.25 m, D = 0.01 N m, no gravity. The start is an arc of 0.2 rad. Substeps are those of 1/60 s.
    """
    D, length = 0.01, 1.0

    def buckled():
        points, faces, clamped, end = strip(length, 0.25, n, n // 4, mesh)
        bent = points.copy()
        s = np.maximum(points[:, 0], 0)
        bent[:, 0] = np.where(points[:, 0] > 0, np.sin(0.2 * s) / 0.2, points[:, 0])
        bent[:, 1] = (1 - np.cos(0.2 * s)) / 0.2
        scene = sheet(bent, faces, method, D=D, Y=1e5 * D, density=0.1, pins=clamped, substeps=substeps, gravity=(0, 0, 0))
        scene["bodies"][0]["rest"] = {"points": points.tolist()}
        simulation = malha.Simulation(scene, threads=study.threads)
        forces = np.zeros_like(points)
        forces[end, 0] = -0.25 * load * np.pi**2 / 4 * D * shares(points[end, 2])
        simulation.set_forces(forces)
        if not rest(simulation, length, most=400 if method == "Desbrun" else 3200, least=200):
            return {}
        tip = simulation.positions[end].mean(axis=0)
        return {"deflection": tip[1], "reach": tip[0]}

    for mesh in MESHES:
        for method in methods(study, FILTERED[1:]):
            for n, substeps in ((16, 20),) if study.quick or method not in FILTERED else ((16, 20), (32, 20)):
                for load in (1.5,) if study.quick else (1.5, 3.0):
                    deflection, reach = elastica(load * np.pi**2 / 4)
                    results(study, buckled, {"deflection": deflection, "reach": reach}, scale={"reach": length}, method=method,
                            mesh=mesh, cells=n, substeps=substeps, case=f"load {load}")
    errors_chart(study)


@protocol("plate", "a plate under a uniform load, round and clamped or square and supported: its deflection and its first frequency")
def plate(study):
    """Timoshenko and Woinowsky-Krieger (1959): q a^4 / (64 D) of a clamped disc, 0.004062 q a^4 / D of a supported square.

    Frequencies: 10.2158 / (2 pi a^2) sqrt(D / density) and pi / a^2 sqrt(D / density) (Leissa 1969). None of these depends
    on Poisson's ratio, which is 0.3 of `plate` and 0 of hinges. Radius and side are 1 m; the deflection is so small that
    the sheet bears nothing by stretching. Substeps are those in a period.
    """
    D, density = 1.0, 1.0
    bendings = {"plate, filtered": ({"type": "plate", "rigidity": D, "poisson_ratio": 0.3}, {"bending": "filtered"}),
                "plate, projected": ({"type": "plate", "rigidity": D, "poisson_ratio": 0.3}, {"bending": "projected"}),
                "hinges, filtered": ({"type": "bending", "rigidity": D}, {"bending": "filtered"}),
                "plate, Desbrun": ({"type": "plate", "rigidity": D, "poisson_ratio": 0.3}, {"type": "desbrun"})}

    def bent():
        if shape == "disc":
            flat, faces, pins = disc(n + 1, mesh, still=2)
            flat, k = flat * (n + 1) / n, np.sqrt(10.2158)
            radius = np.hypot(*flat.T)
            mode = np.where(radius < 1, jv(0, k * radius) - jv(0, k) / iv(0, k) * iv(0, k * radius), 0)
        else:
            _, faces, flat = square(n, n, mesh)
            pins = np.flatnonzero(((flat == 0) | (flat == 1)).any(axis=1))
            mode = np.sin(np.pi * flat[:, 0]) * np.sin(np.pi * flat[:, 1])
        bending, keys = bendings[method]
        body = malha.body(lift(flat), faces, density=density, pins=pins, constraints=[*membrane(100 * D, 0), bending])
        solver = {"dt": 1 / references["frequency"] / 50, "substeps": substeps // 50} | keys
        simulation = simulation_of(study, [body], solver, gravity=[0, -1e-4, 0])
        found = {}
        if rest(simulation, 1e-4 * references["deflection"]):
            found["deflection"] = -simulation.positions[:, 1].min() / 1e-4
        simulation.gravity = [0, 0, 0]
        still = lift(flat)
        simulation.positions = lift(flat, 1e-6 * mode / mode.max())
        simulation.velocities = np.zeros_like(still)
        return found | frequencies(simulation, still, {"frequency": mode}, particle_masses(simulation), 1, 150)

    for shape in ("disc", "square"):
        references = {"deflection": 1 / 64 / D, "frequency": 10.2158 / 2 / np.pi * np.sqrt(D / density)} if shape == "disc" else \
            {"deflection": 0.004062 / D, "frequency": np.pi * np.sqrt(D / density)}
        for mesh in MESHES:
            for method in list(bendings)[:1 if study.quick else None]:
                for n, substeps in ((8, 200),) if study.quick else ((8, 200), (8, 800), (16, 800)):
                    results(study, bent, references, method=method, mesh=mesh, cells=n, substeps=substeps, case=shape)
    errors_chart(study)


@functools.lru_cache(None)
def pressed_membrane(load, Y, nu):
    """The middle's deflection of a disc of radius 1 that is held at its rim under a vertical load per area at rest.

    Of a material that is linear in the stretch, at any stretch; for small loads it is Hencky's problem (1915). With the
    radius r(s) and the height z(s) of a point at s: N1, N2 = Y / (1 - nu^2) (e1 + nu e2, e2 + nu e1), e2 = r / s - 1,
    (s N1 cos(angle))' = N2, s N1 sin(angle) = load s^2 / 2. Shooting with the stretch at the middle.
    """
    def shoot(e0):
        def slope(s, y):
            horizontal, r, _ = y
            vertical, e2 = load * s * s / 2, r / s - 1
            total = np.hypot(horizontal, vertical)
            e1 = total / s * (1 - nu**2) / Y - nu * e2
            return [Y / (1 - nu**2) * (e2 + nu * e1), (1 + e1) * horizontal / total, -(1 + e1) * vertical / total]

        s0 = 1e-4
        return solve_ivp(slope, (s0, 1), [Y / (1 - nu) * e0 * s0, (1 + e0) * s0, 0], rtol=1e-9, atol=1e-12).y[:, -1]

    e0 = brentq(lambda e: shoot(e)[1] - 1, 1e-9, 10)
    return -shoot(e0)[2]


@protocol("pressed membrane", "a round sheet that is held at its rim and loaded by its weight: how deep its middle sinks")
def pressed_membrane_protocol(study):
    """Hencky (1915), 0.653 (q a / Y)^(1/3) a for nu = 0.3 and small loads; at any load by shooting. Radius 1 m, 1 kg/m^2.

    Substeps are those in which a wave crosses a cell.
    """
    def sunk():
        flat, faces, rim = disc(n, mesh)
        constraints, kind = STRETCH[method]
        body = malha.body(lift(flat), faces, density=1, pins=rim, constraints=constraints("irregular", Y))
        simulation = simulation_of(study, [body], method_keys(kind, 1 / n / crossing / np.sqrt(Y), 0.2),
                                   gravity=[0, -1, 0])
        # A small dent gives the load something to act on: a flat sheet has no stiffness across.
        radius = np.hypot(*flat.T)
        simulation.positions = lift(flat, -0.01 * (1 - radius**2))
        return {"depth": -simulation.positions[0, 1]} if rest(simulation, depth) else {}

    for load in (0.001,) if study.quick else (0.001, 0.1):
        Y, depth = 1 / load, pressed_membrane(load, 1.0, 1 / 3)
        for mesh in MESHES:
            for method in STRETCH:
                for n, crossing in ((8, 4),) if study.quick else ((8, 4), (8, 8), (16, 8)):
                    if "Desbrun" in method and crossing == 8:
                        continue
                    results(study, sunk, {"depth": depth}, method=method, mesh=mesh, cells=n,
                            substeps=None if "Desbrun" in method else crossing, case=f"load {load} Y")
    errors_chart(study)


@protocol("balloon", "a sphere of elastic skin under pressure: its radius")
def balloon(study):
    """p R = 2 T with T = Y / (1 - nu) (R / R0 - 1) R0 / R (Laplace), nu = 1/3 and p = (r V0 - V) / compliance.

    Radius 1 m at rest, Y = 100 N/m; the pressure is that at which the sphere has 1.1 and 1.3 times its radius. Substeps
    are those in which a wave crosses a cell.
    """
    Y, density = 100.0, 0.1

    def blown():
        constraints, kind = STRETCH[method]
        pressure = 2 * Y * 1.5 * (ratio - 1) / ratio**2
        body = {"name": "ball", "density": density, "shape": {"sphere": {"radius": 1, "subdivisions": n}}, "constraints": [
            *constraints("irregular", Y),
            {"type": "pressure", "volume_ratio": 10, "compliance": (10 - ratio**3) * volume_at_rest / pressure}]}
        cell = 1.1 / 2**n
        simulation = simulation_of(study, [body], {"type": kind, "dt": 4 * cell / crossing / np.sqrt(Y / density), "substeps": 4}
                                   if kind == "pbd" else {"type": kind, "dt": 0.05})
        if not rest(simulation, 1):
            return {}
        x = simulation.positions
        triangles = x[simulation.triangles]
        return {"radius": np.cbrt(np.linalg.det(triangles).sum() / 6 / volume_at_rest)}

    volume_at_rest = None
    for n in (2,) if study.quick else (2, 3):
        sphere = malha.Simulation({"name": "sphere", "duration": 1, "solver": {"type": "pbd"}, "bodies": [
            {"name": "ball", "mass": 1, "shape": {"sphere": {"radius": 1, "subdivisions": n}}, "constraints": [{"type": "distance"}]}]})
        volume_at_rest = np.linalg.det(sphere.positions[sphere.triangles]).sum() / 6
        for method in STRETCH:
            for ratio in (1.1, 1.3):
                for crossing in (None,) if "Desbrun" in method else (4,) if study.quick or n == 3 else (4, 8):
                    results(study, blown, {"radius": ratio}, scale={"radius": ratio - 1}, method=method, mesh="icosphere",
                            cells=2**n, substeps=crossing, case=f"ratio {ratio}")
    errors_chart(study)


@functools.lru_cache(None)
def contact_time_of_a_ball(R, mass, pressure, Y, nu, speed):
    """How long a blown-up sphere of elastic skin touches smooth ground: its mass on the spring of its static flattening.

    R: at rest (m). Each state is flat up to the angle t0 of the sphere at rest, and a surface of revolution beyond, with
    N1, N2 = Y / (1 - nu^2) (e1 + nu e2, e2 + nu e1), H = rho N1 cos(angle), V = rho N1 sin(angle), rho = R sin(t):
    H' = R N2 - p r z' (R N2 where it is flat), V' = p r r'. The stretch e0 at the middle of the contact is such that the
    surface closes. The ground presses with p times the area of contact; the centre of mass is that of all skin.
    """
    def slope(t, y, flat):
        r, _, H, V = y
        rho, p = R * np.sin(t), 0 if flat else pressure
        e2, angle = r / rho - 1, np.arctan2(V, H) if p else 0 * r
        e1 = (np.hypot(H, V) if p else H) / rho * (1 - nu**2) / Y - nu * e2
        r_slope, z_slope = (1 + e1) * R * np.cos(angle), (1 + e1) * R * np.sin(angle)
        return np.array([r_slope, z_slope, R * Y / (1 - nu**2) * (e2 + nu * e1) - p * r * z_slope, p * r * r_slope])

    blown = brentq(lambda x: 2 * Y / (1 - nu) * (x - 1) / x - pressure * x * R, 1, 1.5)
    first, last = 1e-3, np.pi - 1e-3
    s = np.linspace(0, 1, 400)
    fall, force, guess, stretch = [0.0], [0.0], None, blown - 1
    for t0 in np.linspace(0.03, 0.36, 12):  # y: r, z, H and V where it is free, r and H where it is flat
        def slopes(s, y, e0):
            free = slope(t0 + s * (last - t0), y[:4], False) * (last - t0)
            flat = slope(first + s * (t0 - first), [y[4], 0, y[5], 0], True) * (t0 - first)
            return np.vstack([free, flat[[0, 2]]])

        def ends(a, b, e0):
            return np.array([a[0] - b[4], a[1], a[2] - b[5], a[3], b[0] - blown * R * 1e-3, a[4] - (1 + e0[0]) * R * first,
                             a[5] - R * first * Y / (1 - nu) * e0[0]])

        if guess is None:
            t, flat = t0 + s * (last - t0), first + s * (t0 - first)
            tension = pressure * (blown * R)**2 / 2  # H and V of the sphere: its tension times its radius there
            guess = np.array([blown * R * np.sin(t), blown * R * (1 - np.cos(t)), tension * np.sin(t) * np.cos(t),
                              tension * np.sin(t)**2, blown * R * flat, tension * flat])
        solution = solve_bvp(slopes, ends, s, guess, [stretch], tol=1e-5, max_nodes=20000)
        if not solution.success:
            raise ArithmeticError(solution.message)
        guess, stretch = solution.sol(s), solution.p[0]
        t = t0 + s * (last - t0)
        fall.append(blown * R - np.trapz(guess[1] * np.sin(t), t) / 2)
        force.append(pressure * np.pi * guess[0, 0]**2)
    spring = PchipInterpolator(fall, force)

    def off(t, y):
        return y[0]

    off.terminal, off.direction = True, -1
    return solve_ivp(lambda t, y: [y[1], -spring(y[0]) / mass], (0, 1), [0, speed], events=off, max_step=1e-4, rtol=1e-8).t[-1]


@protocol("bouncing ball", "a pressurised ball that bounces once on hard ground: how long it touches it, and its energy")
def bouncing_ball(study):
    """A football: R = 0.11 m at rest, 0.43 kg, p = 80 kPa, 2 m/s, a skin of 4e5 N/m, nu = 0.3 (1/3 of springs).

    The contact time is that of the ball's static flattening, which neglects vibrations of the skin. The textbook's pi
    sqrt(m / (2 pi R p)), which takes the contact to be the sphere's section with the ground, is 14 % shorter. Energy is that
    of motion, skin and pressure after the bounce over that before. Substeps are those in which a wave crosses a cell.
    """
    R, mass, pressure, Y, speed = 0.11, 0.43, 8e4, 4e5, 2.0

    def bounced():
        density = mass / (4 * np.pi * R * R)
        constraints = membrane(Y, 0.3) if method == "membrane" else [{"type": "distance", "rigidity": Y}]
        body = {"name": "ball", "mass": mass, "shape": {"sphere": {"radius": R, "subdivisions": n}}, "constraints": [
            *constraints, {"type": "pressure", "volume_ratio": 10, "compliance": 9 * 4 / 3 * np.pi * R**3 / pressure}],
            "transform": {"translate": [0, 1, 0]}}
        cell = 1.1 * R / 2**n
        solver = {"dt": 10 * cell / crossing / np.sqrt(Y / density), "substeps": 10}
        ground = {"name": "ground", "shape": {"plane": {}}, "thickness": 0.001}
        blown = simulation_of(study, [body], solver, environment=[ground])
        if not rest(blown, R * 0.01):
            return {}
        x = blown.positions.copy()
        x[:, 1] += 0.0012 - x[:, 1].min()
        blown.positions, blown.velocities = x, np.tile([0, -speed, 0], (len(x), 1))
        still = blown.measure()
        before, energies = still["kinetic_energy_j"], still["elastic_energy_j"]
        touched = []
        while blown.time < 1:
            blown.step()
            low = blown.positions[:, 1].min() < 0.001 + 1e-5
            if low:
                touched.append(blown.time)
            elif touched and blown.time > touched[-1] + 0.002:
                break
        now = blown.measure()
        energy = 1 + (now["kinetic_energy_j"] - before + now["elastic_energy_j"] - energies) / before
        return {"contact time": touched[-1] - touched[0] if touched else None, "energy": energy}

    for method in ("membrane", "springs"):
        for n, crossing in ((2, 6),) if study.quick else ((2, 6), (3, 3), (3, 6)):
            results(study, bounced, {"contact time": contact_time_of_a_ball(R, mass, pressure, Y, 0.3, speed), "energy": 1},
                    method=method, mesh="icosphere", cells=2**n, substeps=crossing)
    errors_chart(study)


@protocol("impact of a bar", "a bar of tetrahedra that hits hard ground with its end: how long it touches it, and its speed afterwards")
def impact_of_a_bar(study):
    """2 L / c with c = sqrt(E / density), and the speed before (Saint-Venant 1867); Poisson's ratio 0, so that it is exact.

    Length 1 m, 1 m/s, c = 100 m/s. Substeps are those in which the wave crosses a cell.
    """
    def struck():
        points, tetrahedra, _ = solid((n // 5, n, n // 5), mesh, lambda p: p * [0.2, 1, 0.2] + [0, 0.0011, 0])
        body = malha.body(points, tetrahedra=tetrahedra, density=1, velocity=[0, -1, 0], constraints=neo_hookean(1e4, 0.0))
        simulation = simulation_of(study, [body], {"dt": 1 / n / 100 / crossing, "substeps": 1},
                                   environment=[{"name": "ground", "shape": {"plane": {}}, "thickness": 0.001}])
        masses = particle_masses(simulation)
        momentum, times = [], []
        while simulation.time < 0.04:
            simulation.step()
            momentum.append(masses @ simulation.velocities[:, 1] / masses.sum())
            times.append(simulation.time)
        momentum, times = np.array(momentum), np.array(times)
        # The contact begins and ends where the momentum passes a tenth and nine tenths of its change, which is linear.
        final = momentum[-1]
        first, last = [times[np.argmax(momentum > -1 + share * (final + 1))] for share in (0.1, 0.9)]
        return {"contact time": (last - first) / 0.8, "speed": final}

    for mesh in MESHES:
        for n, crossing in ((20, 5),) if study.quick else ((20, 5), (20, 20), (40, 20)):
            results(study, struck, {"contact time": 0.02, "speed": 1}, method="tetrahedra", mesh=mesh, cells=n, substeps=crossing)
    errors_chart(study)


def stretched_neo_hookean(stretch, E, nu):
    """Force per area at rest, and the stretch across, of a bar of the stable neo-Hookean material that is free across.

    Smith, de Goes and Kim (2018): mu / 2 (I - ln(1 + I)) + lambda / 2 (J - 1 - 3 mu / (4 lambda))^2, with mu = 4/3 and
    lambda = Lame's + 5/6 of linear elasticity's mu, so that small strains are those of E and nu.
    """
    shear = E / 2 / (1 + nu)
    mu, lam = 4 / 3 * shear, E * nu / (1 + nu) / (1 - 2 * nu) + 5 / 6 * shear

    def parts(b):
        squares = stretch**2 + 2 * b * b
        return mu * squares / (1 + squares), lam * (stretch * b * b - 1 - 0.75 * mu / lam)

    across = brentq(lambda b: parts(b)[0] + parts(b)[1] * stretch, 0.1, 2)
    deviatoric, volumetric = parts(across)
    return deviatoric * stretch + volumetric * across**2, across


@protocol("stretched bar", "a bar of tetrahedra that is pulled to up to twice its length: its length and its width")
def stretched_bar(study):
    """Uniaxial stress of the stable neo-Hookean material in closed form, nu = 0.3 and 0.45.

    Errors are shares of the change of length or width. Substeps are those in which a wave crosses a cell.
    """
    def pulled():
        points, tetrahedra, cube = solid((2 * n, n, n), mesh, lambda p: p * [2, 1, 1])
        weights = np.zeros(len(points))
        face = np.outer(shares(np.linspace(0, 1, n + 1)), shares(np.linspace(0, 1, n + 1))).ravel()
        weights[cube[:, 0] == 1], weights[cube[:, 0] == 0] = face, -face
        body = malha.body(points, tetrahedra=tetrahedra, density=1, constraints=neo_hookean(1.0, nu))
        simulation = simulation_of(study, [body], {"dt": 8 / n / crossing / np.sqrt(1 / 3), "substeps": 8})
        simulation.set_forces(np.outer(weights * force, [1, 0, 0]))
        if not rest(simulation, 1):
            return {}
        x = simulation.positions
        middle = cube[:, 0] == 0.5 if mesh == "grid" else np.abs(cube[:, 0] - 0.5) < 0.5 / n
        sides = [x[middle & (cube[:, 1] == t), 1].mean() for t in (0, 1)]
        return {"length": (x[cube[:, 0] == 1, 0].mean() - x[cube[:, 0] == 0, 0].mean()) / 2, "width": sides[1] - sides[0]}

    for nu in (0.3,) if study.quick else (0.3, 0.45):
        for stretch in (1.2, 2.0):
            force, across = stretched_neo_hookean(stretch, 1.0, nu)
            for mesh in MESHES:
                for n, crossing in ((2, 20),) if study.quick else ((2, 20), (4, 20)):
                    results(study, pulled, {"length": stretch, "width": across}, method="tetrahedra", mesh=mesh, cells=n,
                            substeps=crossing, case=f"stretch {stretch}, nu {nu}",
                            scale={"length": abs(stretch - 1), "width": abs(across - 1)})
    errors_chart(study)


@protocol("spinning sheet", "a sheet and a ring that spin freely for a minute: angular momentum, energy, and the ring's radius")
def spinning(study):
    """Both are kept; the ring's hoop strain e is that of Y e = rho omega^2 R^2 (1 + e)^2 (per length at rest).

    A square of 0.5 m at 5 rad/s about its normal, without bending, and a ring of 1 m and 0.1 kg/m at 10 rad/s, Y = 100 N.
    Substeps are those of 1/60 s.
    """
    def spun():
        if mesh == "chain":
            angle = 2 * np.pi * np.arange(4 * n) / (4 * n)
            points = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
            body = malha.body(stretched * points, lines=np.stack([np.arange(4 * n), (np.arange(4 * n) + 1) % (4 * n)], axis=1),
                              density=0.1, spin=[0, omega, 0], rest={"points": points.tolist()},
                              constraints=[{"type": "distance", "rigidity": 100.0}])
        else:
            points, faces, _ = square(n, n, mesh, lambda p: lift(0.5 * p - 0.25))
            constraints, _ = STRETCH[method]
            body = malha.body(points, faces, density=0.2, spin=[0, 5, 0], constraints=constraints(mesh, 500.0))
        simulation = simulation_of(study, [body], {"dt": 1 / 60, "substeps": substeps, "type": kind})
        start = simulation.measure()
        simulation.step(3600)
        end = simulation.measure()
        found = {key: end[name] / start[name] if np.isscalar(end[name]) else end[name][1] / start[name][1]
                 for key, name in (("angular momentum", "angular_momentum_kg_m2_per_s"), ("energy", "energy_j"))}
        if mesh == "chain":
            x = simulation.positions
            found["radius"] = np.hypot(x[:, 0], x[:, 2]).mean()
        return found

    omega = 10.0
    hoop = brentq(lambda e: 100 * e - 0.1 * omega**2 * (1 + e), 0, 1)
    stretched = 1 + hoop
    for mesh in ("chain", "grid", "irregular"):
        for method in STRETCH:
            if "membrane" in method and (mesh == "chain" or study.quick):
                continue
            kind = STRETCH[method][1]
            for n, substeps in ((8, 10),) if study.quick else ((8, 2), (8, 10), (16, 20)):
                references = {"angular momentum": 1, "energy": 1} | ({"radius": stretched} if mesh == "chain" else {})
                results(study, spun, references, scale={"radius": hoop}, method=method, mesh=mesh, cells=4 * n if mesh == "chain" else n,
                        substeps=substeps)
    errors_chart(study)


@functools.lru_cache(None)
def overhanging_disc(inner, nu):
    """D / (q a^4) times the sag of the edge of a disc of radius a that is clamped to inner times a, under a load q per area.

    Timoshenko and Woinowsky-Krieger (1959), article 17: w = q r^4 / (64 D) + c1 + c2 log(r) + c3 r^2 + c4 r^2 log(r), with
    w = w' = 0 at the inner radius and no moment and no shear at the edge.
    """
    b = inner
    rows = [[1, np.log(b), b * b, b * b * np.log(b)], [0, 1 / b, 2 * b, 2 * b * np.log(b) + b],
            [0, nu - 1, 2 + 2 * nu, 3 + nu], [0, 0, 0, 4]]  # the third: w'' + nu w' / r, the fourth: (laplacian w)', at r = 1
    c = np.linalg.solve(rows, [-b**4 / 64, -b**3 / 16, -(12 + 4 * nu) / 64, -32 / 64])
    return abs(1 / 64 + c[0] + c[2])


@protocol("overhanging disc", "a stiff disc that is clamped to 0.6 of its radius and sags by its weight: the sag of its edge")
def overhanging(study):
    """The drape meter's disc of 30 cm over 18 cm in the limit of a stiff material; closed form of an annular plate.

    D g and the density are such that the edge sags by a hundredth of the overhang. nu = 0.3. Substeps: 1/60 s.
    """
    a, inner, density = 0.15, 0.6, 0.2

    def sagged():
        flat, faces, _ = disc(n, mesh, inner=inner)
        radius = np.hypot(*flat.T)
        flat = flat * a
        body = malha.body(lift(flat), faces, density=density, pins=np.flatnonzero(radius < inner + 0.01 / n),
                          constraints=[*membrane(1e5 * D, 0.3), {"type": "plate", "rigidity": D, "poisson_ratio": 0.3}])
        simulation = simulation_of(study, [body], {"dt": 1 / 600, "substeps": 4, "bending": "filtered"} if method != "plate, Desbrun" else
                                   {"type": "desbrun", "dt": 0.05}, gravity=[0, -G, 0])
        edge = radius > 1 - 0.01 / n
        return {"sag": -simulation.positions[edge, 1].mean()} if rest(simulation, sag) else {}

    sag = 0.01 * (1 - inner) * a
    D = overhanging_disc(inner, 0.3) * density * G * a**4 / sag
    for mesh in MESHES:
        for method in ("plate, filtered",) if study.quick else ("plate, filtered", "plate, Desbrun"):
            for n in (10,) if study.quick else (10, 20):
                results(study, sagged, {"sag": sag}, method=method, mesh=mesh, cells=n)
    errors_chart(study)


FABRICS = {  # B and W of KES, as in the tables: gf cm^2 / cm, mg / cm^2; drape coefficient (%)
    "cotton broad": (0.118, 12.38, 82.9), "wool tropical": (0.067, 16.29, 49.8),
    "polyester tropical": (0.077, 11.65, 50.7), "polyester faille": (0.019, 10.43, 28.3)}


def shadow(points, triangles):
    """The area of the shadow of a sheet that hangs from a disc, on the ground: star-shaped, by its largest radius at 720 angles."""
    weights = np.array([[i, j, 12 - i - j] for i in range(13) for j in range(13 - i)]) / 12
    flat = (weights @ points[triangles][:, :, ::2]).reshape(-1, 2)
    angle = ((np.arctan2(flat[:, 1], flat[:, 0]) / (2 * np.pi) + 1) * 720).astype(int) % 720
    radius = np.zeros(720)
    np.maximum.at(radius, angle, np.hypot(*flat.T))
    return np.pi / 720 * np.sum(radius**2)


@protocol("drape", "a circular cloth over a disc (Cusick's drape meter): the share of the overhang that its shadow covers")
def drape(study):
    """Measured fabrics of Matsudaira, Masuda, Wada and Yokura (2015), J. Textile Engineering 61, 69, tables 1 and 2.

    A specimen of 254 mm over a disc of 127 mm (JIS L 1096). Bending is linear with B, without the hysteresis 2HB that they
    measured too; stretch and shear moduli are not known to us, and taken as 1,000 and 40 N/m. The cloth starts flat, with
    random heights of 0.1 mm, and comes to rest by its own folds, which may be others than those measured. Substeps: 1/60 s.
    """
    def draped():
        flat, faces, _ = disc(n, mesh, inner=0.5)
        radius = np.hypot(*flat.T)
        points = lift(0.127 * flat)
        held = radius < 0.5 + 0.01 / n
        start = points.copy()
        start[~held, 1] += np.random.default_rng(1).uniform(-1e-4, 1e-4, (~held).sum())
        D, density = B * 9.80665e-5, W * 0.01
        body = malha.body(start, faces, density=density, pins=np.flatnonzero(held), rest={"points": points.tolist()}, constraints=[
            {"type": "membrane", "young_modulus": [1000, 1000], "shear_modulus": 40, "poisson_ratio": 0},
            {"type": "plate", "rigidity": D}])
        simulation = simulation_of(study, [body], {"dt": 1 / 240, "substeps": substeps // 4, "bending": "filtered"}, gravity=[0, -G, 0])
        if not rest(simulation, 0.06, 2e-3):
            return {}
        disc_area = np.pi * 0.0635**2
        return {"drape coefficient": (shadow(simulation.positions, simulation.triangles) - disc_area) / (3 * disc_area)}

    for fabric, (B, W, coefficient) in list(FABRICS.items())[:1 if study.quick else None]:
        for mesh in MESHES[:1 if study.quick else 2]:
            for n, substeps in ((12, 20),) if study.quick else ((16, 40), (24, 60)):
                results(study, draped, {"drape coefficient": coefficient / 100}, method="membrane and plate", mesh=mesh, cells=n,
                        substeps=substeps, case=fabric)
    errors_chart(study)


@protocol("mylar balloon", "two discs of a film that does not stretch, joined at their rims and blown up: radius and thickness")
def mylar_balloon(study):
    """Paulsen (1994): radius 4 / B(1/4, 1/2) and thickness 2 B(3/4, 1/2) / B(1/4, 1/2) of the discs' radius a = 1.

    The film wrinkles without resistance. `distance_limit` is such a film, because it only keeps edges from being longer;
    membranes and springs of 1,000 N/m have to fold. The pressure of 5 Pa is a force on the particles that follows the faces.
    """
    def blown():
        top, faces, rim = disc(n, mesh)
        bottom, below, _ = disc(n, mesh, seed=2)
        inner = rim[0]
        index = np.append(np.arange(inner) + len(top), rim)  # the bottom's inner points come last, the rim is shared
        points = np.concatenate([lift(top), lift(bottom[:inner])])
        mesh_faces = np.concatenate([faces, index[below]])
        sides = points[mesh_faces][:, :, ::2]
        up = np.linalg.det(sides[:, 1:] - sides[:, :1]) < 0  # (x, z) counter-clockwise has its normal along -y
        outwards = np.where((up == (np.arange(len(mesh_faces)) < len(faces)))[:, None], mesh_faces, mesh_faces[:, ::-1])
        start = points.copy()
        height = 0.1 * (1 - np.hypot(*points[:, ::2].T)**2)
        start[:, 1] = np.where(np.arange(len(points)) < inner, height, np.where(np.arange(len(points)) < len(top), 0, -height))
        start += np.random.default_rng(3).uniform(-2e-3, 2e-3, start.shape)  # so that the rim can fold
        body = malha.body(start, mesh_faces, density=1, rest={"points": points.tolist()}, constraints=films[method])
        simulation = simulation_of(study, [body], {"dt": 0.01, "substeps": substeps})
        steps, old, peak = 50, np.zeros(2), 0.0
        while steps <= 3200:
            for _ in range(steps):
                corners = simulation.positions[outwards]
                push = pressure * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 6
                forces = np.zeros_like(points)
                np.add.at(forces, outwards, np.repeat(push[:, None], 3, axis=1))
                simulation.set_forces(forces)
                simulation.step()
                energy = np.sum(simulation.velocities**2)
                peak = max(peak, energy)
                if energy < 0.9 * peak:
                    simulation.velocities, peak = np.zeros_like(points), 0.0
            x, steps = simulation.positions, 2 * steps
            size = np.array([np.hypot(*x[rim][:, ::2].T).mean(), x[0, 1] - x[len(top), 1]])
            if np.abs(size - old).max() < 2e-3:
                return {"radius": size[0], "thickness": size[1]}
            old = size
        return {}

    pressure = 5.0
    films = {"elongation limits": [{"type": "distance_limit", "elements": ["edges"], "limit": 0}],
             "membrane": membrane(1000.0, 0.3), "springs": [{"type": "distance", "rigidity": 1000.0}]}
    quarter = beta(0.25, 0.5)
    for mesh in MESHES[:1 if study.quick else None]:
        for method in list(films)[:1 if study.quick else None]:
            for n, substeps in ((8, 20),) if study.quick else ((8, 20), (16, 20), (16, 80)):
                results(study, blown, {"radius": 4 / quarter, "thickness": 2 * beta(0.75, 0.5) / quarter}, method=method, mesh=mesh,
                        cells=n, substeps=substeps)
    errors_chart(study)


@protocol("free top", "a square bar that turns freely about a tilted axis: how fast its own axis goes round")
def free_top(study):
    """Euler (1758), Poinsot: a symmetric body's axis goes round its angular momentum L at L / I, I its moment across the axis.

    A bar of 1 x 0.3 x 0.3 m at 1 rad/s along itself and 2 rad/s across; I is that of the particles. Substeps: 1/60 s.
    """
    def turned():
        points, tetrahedra, _ = solid((6, 2, 2), mesh, lambda p: (p - 0.5) * [1, 0.3, 0.3])
        body = malha.body(points, tetrahedra=tetrahedra, density=100, spin=[1, 2, 0], constraints=neo_hookean(1e6, 0.3))
        simulation = simulation_of(study, [body], {"dt": 1 / 60, "substeps": substeps})
        masses = particle_masses(simulation)
        x = simulation.positions - masses @ simulation.positions / masses.sum()
        along, momentum = x[:, 0].copy(), np.array(simulation.measure()["angular_momentum_kg_m2_per_s"])
        across = masses @ (x[:, 0]**2 + x[:, 1]**2)
        aim = momentum / np.linalg.norm(momentum)
        side = np.cross(aim, [0, 0, 1])
        signals, times = [], []
        for _ in range(600 if study.quick else 3600):
            axis = (masses * along) @ simulation.positions
            signals.append(axis @ np.cross(aim, side))
            times.append(simulation.time)
            simulation.step()
        signals, times = np.array(signals), np.array(times)
        k = np.flatnonzero(signals[:-1] * signals[1:] < 0)
        crossings = times[k] - signals[k] * (times[k + 1] - times[k]) / (signals[k + 1] - signals[k])
        return {"rate": np.pi / np.polyfit(np.arange(len(k)), crossings, 1)[0] / (np.linalg.norm(momentum) / across)}

    for mesh in MESHES:
        for substeps in (20,) if study.quick else (10, 40):
            results(study, turned, {"rate": 1}, method="tetrahedra", mesh=mesh, cells=6, substeps=substeps)
    errors_chart(study)


@protocol("falling plate", "a flat sheet that falls broadside through air: its terminal speed")
def falling_plate(study):
    """sqrt(2 m g / (rho C A)) for 0.2 kg/m^2, rho = 1.2 kg/m^3 and C = 1.2. Substeps are those of 1/60 s."""
    def fallen():
        points, faces, _ = square(8, 8, mesh, lambda p: lift(0.5 * p))
        body = malha.body(points, faces, density=0.2, constraints=[
            {**SPRINGS, "elements": ["edges", "shear"] if mesh == "grid" else ["edges"]}, {"type": "bending", "rigidity": 0.1}])
        simulation = simulation_of(study, [body], {"dt": 1 / 60, "substeps": substeps} | solver, gravity=[0, -G, 0],
                                   wind={"velocity": [0, 0, 0], "density": 1.2, "drag_coefficient": 1.2, "lift_coefficient": 1.2})
        simulation.step(120)
        return {"speed": -simulation.velocities[:, 1].mean()}

    for mesh in MESHES:
        for method, solver in (("springs", {}), ("springs, Desbrun", {"type": "desbrun"})):
            for substeps in (10,) if study.quick else (1, 10):
                results(study, fallen, {"speed": np.sqrt(2 * 0.2 * G / 1.2 / 1.2)}, method=method, mesh=mesh, cells=8, substeps=substeps)
    errors_chart(study)


@protocol("bounces", "a particle with a coefficient of restitution that is dropped: the heights of its bounces")
def bounces(study):
    """e^2 and e^4 of the first height, for e = 0.8 and 1 m. Substeps are those of 1/60 s."""
    def bounced():
        body = malha.body([[0, 1.0, 0]], mass=1)
        simulation = simulation_of(study, [body], {"dt": 1 / 60, "substeps": substeps} | solver, gravity=[0, -G, 0], environment=[
            {"name": "ground", "shape": {"plane": {}}, "thickness": 1e-4, "restitution": 0.8}])
        heights = []
        for _ in range(110):
            simulation.step()
            heights.append(simulation.positions[0, 1])
        heights = np.array(heights)
        peaks = np.flatnonzero((heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])) + 1
        return {f"bounce {i + 1}": heights[k] for i, k in enumerate(peaks[:2])}

    for method, solver in (("particle", {}), ("particle, Desbrun", {"type": "desbrun"})):
        for substeps in (20,) if study.quick else (5, 20, 80):
            results(study, bounced, {"bounce 1": 0.64, "bounce 2": 0.4096}, method=method, mesh="particle", cells=1, substeps=substeps)
    errors_chart(study)


@protocol("strip", "a strip that is pulled by a hundredth of its length: its force, and how far it contracts")
def strip_protocol(study):
    """Y e a width, and nu e across it (plane stress); nu = 1/3. Substeps are those in which a wave crosses a cell."""
    def pulled():
        points, faces, flat = square(4 * n, n, mesh, lambda p: lift(p * [4, 1]), aspect=4)
        constraints, kind = STRETCH[method]
        weights = np.zeros(len(points))
        for end, sign in ((0, -1), (1, 1)):
            weights[flat[:, 0] == end] = sign * shares(flat[flat[:, 0] == end, 1])
        body = malha.body(points, faces, density=1, constraints=constraints(mesh, 1.0))
        simulation = simulation_of(study, [body], method_keys(kind, 1 / n / crossing, 2))
        simulation.set_forces(np.outer(0.01 * weights, [1, 0, 0]))
        if not rest(simulation, 0.04):
            return {}
        u = simulation.positions - points
        middle = np.abs(flat[:, 0] - 0.5) < 0.26
        slope = [np.polyfit(points[middle, a], u[middle, a], 1)[0] for a in (0, 2)]
        return {"stretch": slope[0] / 0.01, "contraction": -slope[1] / slope[0]}

    for mesh in MESHES:
        for method in STRETCH:
            for n, crossing in ((4, 5),) if study.quick else ((4, 5), (8, 5)):
                results(study, pulled, {"stretch": 1, "contraction": 1 / 3}, method=method, mesh=mesh, cells=n,
                        substeps=None if "Desbrun" in method else crossing)
    errors_chart(study)


# ---- The study -------------------------------------------------------------------------------------------------------


VERDICT = ["protocol", "method", "mesh", "cells", "substeps", "", "largest error", "at"]  # columns of the tables


def verdict(rows):
    """The verdict of rows of one protocol, method and mesh: their fields, the largest error and where it is."""
    worst = max(rows, key=lambda row: np.inf if row["error"] is None else row["error"])
    one = {key: ", ".join(dict.fromkeys(studies.text(row[key]) for row in rows)) for key in VERDICT[:5]}
    percent = None if worst["error"] is None else 100 * worst["error"]
    error = worst["note"] or "none" if percent is None else f"{percent:.2g} %" if percent < 10 else f"{percent:.0f} %"
    return [*one.values(), "passed" if all(row["within"] for row in rows) else "failed", error,
            f"{worst['setting']} {studies.text(worst['at'])}"]


def counted(study, *keys):
    """The rows that count, in groups that have the values of these keys in common."""
    groups = {}
    for row in study.rows:
        if row["resolved"]:
            groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def finest(study):
    """One verdict for each protocol, method and mesh: each value of a parameter by the finest mesh, and by the most
    substeps, with which it was measured."""
    return [verdict(finest_rows(rows)) for rows in counted(study, "protocol", "method", "mesh").values()]


def overview_chart(table):
    """The largest error of each method and mesh, over its protocols."""
    names = [name for name in PROTOCOLS if any(row[0] == name for row in table)][::-1]
    figure, axes = plt.subplots(figsize=(11, 1.6 + 0.42 * len(names)))
    for passed, colour, label in ((True, "#2ca02c", "passed"), (False, "#d62728", "failed")):
        for mesh, marker in [("irregular", "^"), (None, "s")]:
            rows = [row for row in table if (row[5] == "passed") == passed and ((row[2] == mesh) if mesh else row[2] != "irregular")]
            x = [np.clip(float(row[6].split()[0]) if row[6].endswith(" %") else np.inf, 0.01, 1000) for row in rows]
            y = [names.index(row[0]) + (0.12 if mesh else -0.12) for row in rows]
            axes.plot(x, y, ls="none", marker=marker, color=colour, fillstyle="none" if mesh else "full", markersize=7,
                      label=f"{label}, {mesh or 'grids and others'}")
    axes.set(xscale="log", xlim=(0.008, 1300), yticks=range(len(names)), yticklabels=names, ylim=(-0.6, len(names) - 0.4),
             xlabel="largest error where the mesh resolves the case; at the right end: 1000 % and more, or no result")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g} %")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncol=4, fontsize=10)
    figure.subplots_adjust(left=0.18, right=0.97, top=1 - 0.5 / figure.get_figheight(), bottom=1.0 / figure.get_figheight())
    return figure


KINDS = ("grid", "irregular", "other")  # of meshes, in the table of all methods


def table_of_methods(best):
    """Lines of Markdown: the verdicts of finest(), a line for each protocol and method, a column for each kind of mesh."""
    cells = {}
    for protocol, method, mesh, finest_cells, _, passed, error, _ in best:
        kind = mesh if mesh in KINDS else "other"
        mark = "" if passed == "passed" else "*"
        words = f"{mark}{error}{mark} ({finest_cells}{'' if mesh in KINDS else ', ' + mesh})"
        cells.setdefault((protocol, method), {}).setdefault(kind, []).append(words)
    lines = ["| protocol, bar | method | grid | irregular | other meshes |", "|---|---|---|---|---|"]
    before = None
    for (protocol, method), by_kind in cells.items():
        first = "" if protocol == before else f"{protocol}, {100 * PROTOCOLS[protocol].bar:g} %"
        lines.append("| " + " | ".join([first, method, *("; ".join(by_kind.get(kind, [])) for kind in KINDS)]) + " |")
        before = protocol
    return lines


def measure(study, names):
    for name in names:
        study.protocol = name
        study.together(lambda: PROTOCOLS[name](study))  # a protocol reads its cells at once, so that a share has it as a whole
    if study.partial:
        return
    best, all_meshes = finest(study), [verdict(rows) for rows in counted(study, *VERDICT[:5]).values()]
    passed = sum(row[5] == "passed" for row in best)
    study.table = table_of_methods(best)
    study.section("All meshes", [f"{sum(row[5] == 'passed' for row in all_meshes)} of {len(all_meshes)} methods, meshes and numbers of "
                                 "substeps have passed by themselves."], VERDICT, all_meshes, first=True)
    study.section("Passed and failed",
                  [f"{passed} of {len(best)} methods and kinds of mesh have passed: no error exceeds the protocol's bar over the whole range "
                   "that the meshes resolve, each value by the finest mesh that was measured."],
                  VERDICT, best, ("overview", overview_chart(best)), first=True)


if __name__ == "__main__":
    studies.main("validation", "malha against experiments, closed forms and boundary value problems of the literature", measure,
                 only=list(PROTOCOLS))
