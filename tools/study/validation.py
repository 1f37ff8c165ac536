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
from scipy.optimize import brentq  # noqa: E402
from scipy.spatial import Delaunay  # noqa: E402

G = 9.81  # m/s^2
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


def relax(simulation, size, tolerance=1e-5, most=3000):
    """Steps to rest by kinetic damping: wherever the kinetic energy has a maximum, all velocities become 0.

    size: a length of the body (m). It rests when no particle has moved by more than `tolerance` of it between two such
    maxima, twice. Returns whether it does after at most `most` steps.
    """
    before, last, calm = simulation.positions, 0.0, 0
    while simulation.steps < most:
        simulation.step(2)
        energy = np.sum(simulation.velocities**2)
        if not np.isfinite(energy):
            return False
        if energy >= last:
            last = energy
            continue
        simulation.velocities = np.zeros_like(before)
        now, last = simulation.positions, 0.0
        calm = calm + 1 if np.abs(now - before).max() < tolerance * size else 0
        before = now
        if calm == 2:
            return True
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
                             {"type": "desbrun", "dt": 1 / 60, "precision": "double", "refinement_iterations": 10}),
}


def sheet(points, faces, method, *, D, Y, density, pins, substeps, gravity=(0, -G, 0), **body):
    """The scene of a sheet by one of METHODS. D (N m), Y (N/m), density (kg/m^2); further keys are the body's."""
    constraints, solver = METHODS[method](D, Y)
    if len(faces[0]) == 3:  # triangles have no diagonals
        constraints = [{**one, "elements": ["edges"]} if one["type"] == "distance" else one for one in constraints]
    return {"name": "sheet", "duration": 1, "gravity": list(gravity), "solver": solver | {"substeps": substeps},
            "bodies": [malha.body(points, faces, density=density, pins=pins, constraints=constraints, **body)]}


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
    D, density = 0.1 * G / gamma, 0.1
    scene = sheet(points, faces, method, D=D, Y=1e5 * D, density=density, pins=clamped, substeps=substeps)
    simulation = malha.Simulation(scene, threads=study.threads)
    if not relax(simulation, 1):
        return None
    tip = simulation.positions[end].mean(axis=0)
    return -tip[1] / tip[0]


@protocol("cantilever", "a clamped strip that bends under its weight: drop over reach of its end, over Gamma = density g L^3 / D")
def cantilever(study):
    for mesh in ("grid", "irregular"):
        for method in METHODS:
            for cells in (24,) if study.quick else (24, 48):
                for gamma in (1, 100) if study.quick else (0.1, 1, 10, 100, 1000):
                    value = study.cell(f"cantilever, {method}, {mesh}, {cells} cells, 20 substeps, Gamma {gamma}",
                                       lambda: drop_over_reach(study, method, mesh, cells, 20, gamma))
                    compare(study, method=method, mesh=mesh, cells=cells, substeps=20, setting="Gamma", at=gamma,
                            value=value, reference=heavy_elastica(gamma), resolved=cells / np.sqrt(gamma) >= 2,
                            note="" if value is not None else "does not come to rest")


# ---- The study -------------------------------------------------------------------------------------------------------


def verdicts(study):
    """One row for each protocol, method, mesh and number of cells: its largest error where the mesh resolves the case."""
    groups = {}
    for row in study.rows:
        if row["resolved"]:
            groups.setdefault(tuple(row[key] for key in ("protocol", "method", "mesh", "cells", "substeps")), []).append(row)
    table = []
    for group, rows in groups.items():
        worst = max(rows, key=lambda row: np.inf if row["error"] is None else row["error"])
        passed = all(row["within"] for row in rows)
        error = worst["note"] or "none" if worst["error"] is None else f"{100 * worst['error']:.1f} %"
        table.append([*group, "passed" if passed else "failed", error, f"{worst['setting']} {studies.text(worst['at'])}"])
    return table


def measure(study, names):
    for name in names:
        study.protocol = name
        PROTOCOLS[name](study)
    table = verdicts(study)
    passed = sum(row[5] == "passed" for row in table)
    study.section("Passed and failed", [f"{passed} of {len(table)} passed: no error above the bar where the mesh resolves the case."],
                  ["protocol", "method", "mesh", "cells", "substeps", "", "largest error", "at"], table, first=True)


if __name__ == "__main__":
    studies.main("validation", "malha against experiments, closed forms and boundary value problems of the literature", measure,
                 only=list(PROTOCOLS))
