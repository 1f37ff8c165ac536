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
from scipy.integrate import solve_bvp  # noqa: E402
from scipy.linalg import eigh  # noqa: E402
from scipy.optimize import brentq  # noqa: E402
from scipy.spatial import Delaunay  # noqa: E402

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
              within=error is not None and error <= PROTOCOLS[study.protocol].bar, note=note)


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
        finest = {}
        for row in sorted(rows, key=lambda row: (row["cells"], row["substeps"] or 0)):
            finest[row["setting"], row["at"]] = row
        shown = dict(color=studies.COLOURS[methods.index(method) % len(studies.COLOURS)], ls="none", markersize=7,
                     marker="s^"[MESHES.index(mesh)], fillstyle="full" if mesh == MESHES[0] else "none")
        left.plot(*zip(*map(place, finest.values())), **shown)
        counted = [row for row in finest.values() if row["resolved"]]
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
        corner = (np.arange(along + clamp)[:, None] * n + np.arange(across)).ravel()
        faces = np.stack([corner, corner + n, corner + n + 1, corner + 1], axis=1)
    else:
        random = np.random.default_rng(seed)
        moved = random.uniform(-0.3, 0.3, x.shape + (2,)) * [cell, width / across]
        moved[:clamp + 1, :, 0] = moved[-1, :, 0] = moved[:, 0, 1] = moved[:, -1, 1] = 0
        points[..., ::2] += moved
        flat = points.reshape(-1, 3)[:, ::2]
        faces = Delaunay(flat).simplices
        sides = flat[faces[:, 1:]] - flat[faces[:, :1]]
        area = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
        faces = faces[area > 1e-6 * cell * width / across]  # Delaunay's triangles between points of a straight side
        turned = random.random(len(faces)) < 0.5
        faces[turned] = faces[turned, ::-1]
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


def methods(study):
    """The names of METHODS that the study measures."""
    return FILTERED if study.quick else tuple(METHODS)


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
    s, y, load = np.linspace(0, 1, 100), np.zeros((2, 100)), min(gamma, 1.0)
    while True:
        found = solve_bvp(lambda s, y: np.stack([y[1], load * (1 - s) * np.cos(y[0])]),
                          lambda a, b: np.array([a[0], b[1]]), s, y, tol=1e-8, max_nodes=100000)
        if not found.success:
            raise RuntimeError(f"the heavy elastica of gamma {load}: {found.message}")
        if load == gamma:
            break
        s, y, load = found.x, found.y, min(gamma, 2 * load)
    theta = lambda s: found.sol(s)[0]  # noqa: E731
    nodes, weights = np.polynomial.legendre.leggauss(400)
    angle = theta((nodes + 1) / 2)
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
    gammas = np.geomspace(0.1, 1000, 60)
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
    angle = curl * s
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
        for method in methods(study):
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
    loads = np.geomspace(0.8, 36, 8)
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
        for method in methods(study):
            for depth in (0.2,) if study.quick else (0.1, 0.2, 0.5):
                if depth != 0.2 and method == "Desbrun" or depth > 0.3 and method not in FILTERED:
                    continue  # they take minutes
                for cells in (10,) if study.quick else (20, 40) if depth == 0.2 and method in FILTERED else (20,):
                    value = study.cell(f"lateral buckling, {method}, {mesh}, {cells} cells, depth {depth}, 20 substeps",
                                       lambda: measured_buckling_load(study, method, mesh, cells, depth, 20))
                    compare(study, method=method, mesh=mesh, cells=cells, substeps=20, setting="depth over L", at=depth,
                            value=value, reference=buckling_load(depth), note="" if value else "no rest, or no buckling load")
    depths = np.linspace(0.05, 0.55, 26)
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
        s, y, forces = solved.x, solved.y, solved.p
        found.append((pressed, abs(forces[1] / forces[0])))
    return np.array(found).T


def pressed_at_slip(study, method, mesh, cells, substeps, friction, gamma, width=0.2):
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
        {"time": 0}, {"time": seconds, "translate": [0, start_pressed - end_pressed, 0]}]}
    scene = sheet(flat, faces, method, D=D, Y=1e5 * D, density=DENSITY, pins=[lower], substeps=substeps,
                  gravity=(0, -gamma * D / DENSITY, 0))
    scene["environment"] = [{"name": "ground", "shape": {"plane": {}}, "friction": friction, "thickness": thick,
                             "transform": {"translate": [0, start[:, 1].min() - thick, 0]}}]
    swing = 15.4 * np.sqrt(D / DENSITY)  # 1/s, of a clamped and hinged strip; the drag is critical
    scene["wind"] = {"velocity": [0, 0, 0], "drag": 2 * swing * DENSITY * width / len(points)}
    simulation = malha.Simulation(scene, threads=study.threads)
    simulation.positions = start
    at = start[end, 0].mean()
    while simulation.time < seconds:
        simulation.step(6)
        if abs(simulation.positions[end, 0].mean() - at) > 0.002:
            return start_pressed + (end_pressed - start_pressed) * simulation.time / seconds
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
                            f"stick and slip, {method}, {mesh}, {cells} cells, 20 substeps, friction {friction}, Gamma {gamma}",
                            lambda: pressed_at_slip(study, method, mesh, cells, 20, friction, gamma))
                        compare(study, method=method, mesh=mesh, cells=cells, substeps=20, setting=f"Gamma {gamma}, friction",
                                at=friction, value=None if value is None else np.interp(value, pressed, ratio),
                                reference=friction, note="never slips" if value is None else f"pressed by {value:.4f} L")
    curves = {gamma: force_ratio(gamma) for gamma in (0, 5)}
    curve_chart(study, "pressed, as a share of L", "coefficient of friction; above the curve it sticks",
                [(f"Gamma {gamma}", *curve) for gamma, curve in curves.items()], error_over="coefficient of friction",
                place=lambda row: (np.interp(row["value"], *curves[int(row["setting"].split()[1][:-1])][::-1]), row["at"]))


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
    table = []
    for rows in counted(study, "protocol", "method", "mesh").values():
        best = {}
        for row in sorted(rows, key=lambda row: (row["cells"], row["substeps"] or 0)):
            best[row["setting"], row["at"]] = row
        table.append(verdict(list(best.values())))
    return table


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


def measure(study, names):
    for name in names:
        study.protocol = name
        PROTOCOLS[name](study)
    best, all_meshes = finest(study), [verdict(rows) for rows in counted(study, *VERDICT[:5]).values()]
    passed = sum(row[5] == "passed" for row in best)
    study.section("All meshes", [f"{sum(row[5] == 'passed' for row in all_meshes)} of {len(all_meshes)} methods, meshes and numbers of "
                                 "substeps have passed by themselves."], VERDICT, all_meshes, first=True)
    study.section("Passed and failed",
                  [f"{passed} of {len(best)} methods and kinds of mesh have passed: no error exceeds the protocol's bar over the whole range "
                   "that the meshes resolve, each value by the finest mesh that was measured."],
                  VERDICT, best, ("overview", overview_chart(best)), first=True)


if __name__ == "__main__":
    studies.main("validation", "malha against experiments, closed forms and boundary value problems of the literature", measure,
                 only=list(PROTOCOLS))
