# SPDX-License-Identifier: Apache-2.0
"""The settings with which each method fails, how it fails, and remedies.

A part of the study is a function of PARTS. Maps run trials over two settings, judge each of them as stable, wrong or
diverged, and find the boundary between stable and failing settings by bisection. The other parts show one known failure
each, as lines over one setting.

    PYTHONPATH=build/release /usr/bin/python3 tools/study/stability.py --quick

To add a known failure, write a function of the study below the others, decorate it with @part, request its values with
`line` (one cell for each setting), and end with `lines_section`. Other integrators and plain sweeps are those of the module
_malha_reference (tools/study/reference/module.cpp), which shares the scene and its mesh with malha, no kernels and no solvers.
"""
import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

studies.require("_malha_reference")

import _malha_reference as reference  # noqa: E402
import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.colors import ListedColormap  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402
from size import SIDE, irregular_sheet  # noqa: E402

G = 9.81  # m/s^2
FRAME = 1 / 60  # s; methods divide it into substeps
STABLE, WRONG, DIVERGED = range(3)
VERDICTS = ("stable", "bounded but wrong", "diverged")
WRONG_STRAIN, WRONG_GAIN, DIVERGED_GAIN = 0.5, 0.05, 10
PARTS = {}


def part(cells, quick_cells):
    """Registers a function as a part of the study. cells, quick_cells: the number of its cells, for the progress line."""
    def register(function):
        PARTS[function] = (cells, quick_cells)
        return function
    return register


def short_number(value):
    """A number without trailing zeros, and with exponents such as 1e6 instead of 1e+06."""
    thousands = value >= 1000 and value % 1000 == 0
    if 1000 <= value < 10000 and not thousands:
        return f"{value:.0f}"
    text = f"{value:.3g}"
    if 0 < value < 0.01 or thousands or "e" in text:
        exponent = math.floor(math.log10(value) + 1e-9)
        text = f"{value / 10**exponent:.3g}e{exponent}"
    return text


# ---- Scenes ----------------------------------------------------------------------------------------------------------

LENGTHS = {"type": "distance", "elements": ["edges"]}
SHELL = {"sphere": {"radius": 0.5, "subdivisions": 2}}  # 162 particles


def spring_scene(name, shape, mass, pins, elements, compliance, **solver):
    """A scene of one body of distance constraints. compliance: m/N; 0: of stiffness 1, by PBD. solver: keys that differ
    from 10 substeps of one iteration by PBD in float."""
    constraint = {"type": "distance", "elements": elements} | ({"compliance": compliance} if compliance else {})
    return {"name": name, "solver": {"type": "pbd", "dt": FRAME, "substeps": 10, "iterations": 1} | solver,
            "gravity": [0, -G, 0], "duration": 1,
            "bodies": [{"name": name, "shape": shape, "mass": mass, "pins": pins, "constraints": [constraint]}]}


def hanging_sheet(n, side, mass, compliance, pins=({"row": "first"},), **solver):
    """A sheet of n x n particles with edges and diagonals, horizontal at the start and pinned at one row. It has no levels,
    because the boundaries are those of sweeps over the particles."""
    solver = solver if solver.get("type") == "desbrun" else {"levels": "off"} | solver
    return spring_scene("sheet", {"grid": {"size": [side, side], "cells": [n - 1, n - 1]}}, mass, list(pins),
                        ["edges", "shear"], compliance, **solver)


def corner_pinned_sheet(n, side, mass, compliance, **solver):
    """The same sheet, pinned at the two corners of that row."""
    return hanging_sheet(n, side, mass, compliance, [{"particles": [0, n - 1]}], **solver)


def pinned_chain(end, links, mass, compliance, **solver):
    """A straight chain from the origin, where it is pinned, to `end`."""
    return spring_scene("chain", {"chain": {"from": [0, 0, 0], "to": end, "segments": links}}, mass, [{"particles": [0]}],
                        ["edges"], compliance, **solver)


def body_in_vacuum(shape, constraints, substeps=10, precision="double", **body):
    return {"name": "body", "solver": {"type": "pbd", "dt": FRAME, "substeps": substeps, "precision": precision}, "duration": 1,
            "gravity": [0, 0, 0], "bodies": [{"name": "body", "shape": shape, "mass": 1, "constraints": constraints} | body]}


def simulate(scene, frames=0):
    simulation = malha.Simulation(scene, threads=1)
    simulation.step(frames)
    return simulation


# ---- Trials ----------------------------------------------------------------------------------------------------------


def reference_system(scene):
    """The springs of a scene's only body, and its start."""
    return reference.System(json.dumps(scene))


def sample_of(system, x, v, elastic=True):
    """The largest and the RMS strain, and the energy (J), with that of the springs or without."""
    strain, now = system.strains(x), system.conserved(x, v)
    return np.abs(strain).max(), np.sqrt((strain**2).mean()), now["kinetic"] + now["potential"] + elastic * now["elastic"]


def integrator_trial(system, method, h, steps, scale):
    """A trial of an integrator with steps of h (s). scale: J, the potential energy that the body can lose."""
    run = reference.Integrator(system, method, system.positions, system.velocities)
    return {"advance": lambda n: run.advance(h, n), "sample": lambda: sample_of(system, run.positions, run.velocities),
            "steps": steps, "scale": scale, "warned": False}


def sweep_trial(system, order, precision, compliance, substeps, frames, scale):
    """A trial of a plain sweep, with a number of substeps a frame."""
    run = reference.PlainSweep(system, order, precision, compliance)
    return {"advance": lambda n: run.advance(FRAME / substeps, n * substeps),
            "sample": lambda: sample_of(system, run.positions, run.velocities, elastic=False),
            "steps": frames, "scale": scale, "warned": False}


def malha_trial(scene, steps, scale):
    """A trial by malha. It is warned if `malha run` warns of the settings."""
    simulation = malha.Simulation(scene, threads=1)

    def sample():
        now = simulation.measure()
        return now["strain_max"], now["strain_rms"], now["kinetic_energy_j"] + now["potential_energy_j"]
    return {"advance": simulation.step, "sample": sample, "steps": steps, "scale": scale, "warned": bool(simulation.warnings())}


def judge(trial):
    """The outcome of a trial, by about 200 samples: its verdict, the largest strain and RMS strain, the largest gain of energy
    since the start over the scale, and whether malha warns. Diverged: no longer finite, or a gain above DIVERGED_GAIN. Wrong:
    a strain above WRONG_STRAIN or a gain above WRONG_GAIN."""
    outcome = {"verdict": DIVERGED, "strain": 0.0, "rms": 0.0, "gain": 0.0, "warned": trial["warned"]}
    start, steps = trial["sample"]()[2], trial["steps"]
    every = -(-steps // 200)
    try:
        for done in range(0, steps, every):
            trial["advance"](min(every, steps - done))
            strain, rms, energy = (math.nan if value is None else value for value in trial["sample"]())
            gain = (energy - start) / trial["scale"]
            if not math.isfinite(rms) or not gain <= DIVERGED_GAIN:
                return outcome
            for key, value in (("strain", strain), ("rms", rms), ("gain", gain)):
                outcome[key] = max(outcome[key], value)
    except malha.Diverged:
        return outcome
    wrong = outcome["strain"] > WRONG_STRAIN or outcome["gain"] > WRONG_GAIN
    return outcome | {"verdict": WRONG if wrong else STABLE}


# ---- Maps ------------------------------------------------------------------------------------------------------------


def column(values, whole, outcome_at):
    """The outcomes of the trials outcome_at(y) for all values of y, from the safest to the least safe. Between a stable value
    and a failing neighbour the boundary is found by bisection, in whole numbers if `whole`.

    A dict of verdicts, strains, rms, gains, warned (a value for each y) and edges: [[y, y], ...]; stable_to, fails_from and
    fails_as of the last boundary from stable to failing, stable_from of the last one from failing to stable.
    """
    outcomes = [outcome_at(y) for y in values]
    found = {plural: [one[key] for one in outcomes] for plural, key in (
        ("verdicts", "verdict"), ("strains", "strain"), ("rms", "rms"), ("gains", "gain"), ("warned", "warned"))} | {"edges": []}
    for (low, before), (high, after) in zip(zip(values, found["verdicts"]), zip(values[1:], found["verdicts"][1:])):
        stable_first, how = before == STABLE, max(before, after)
        if stable_first == (after == STABLE):
            continue
        for _ in range(6):
            middle = round(math.sqrt(low * high)) if whole else math.sqrt(low * high)
            if middle in (low, high):
                break
            verdict = outcome_at(middle)["verdict"]
            low, high = (middle, high) if stable_first == (verdict == STABLE) else (low, middle)
            how = how if verdict == STABLE else verdict
        found["edges"].append([low, high])
        found |= {"stable_to": low, "fails_from": high, "fails_as": VERDICTS[how]} if stable_first else {"stable_from": high}
    return found


def panel_of(study, key, title, x, y, outcome_at, unit="", whole=True, theory=(), ours=True):
    """A panel of a map with its columns, one cell each. x, y: (name, values), those of y from the safest to the least safe.
    outcome_at: the outcome of the trial at x and y. theory: (title, y at each x) of predicted boundaries. ours: true for a
    method of malha."""
    columns = study.cells(x[1], lambda at: f"{key}{at:g}{unit}", lambda at: column(y[1], whole, lambda y: outcome_at(at, y)))
    return {"title": title, "x": x, "y": y, "columns": columns, "theory": theory, "ours": ours}


def map_section(study, name, title, chart_title, panels, across, sentences):
    """Adds the section of a map, with a chart of all panels, and a row for each setting."""
    counts, table = {(fails, warned): 0 for fails in (False, True) for warned in (False, True)}, []
    for panel in panels:
        for x, found in zip(panel["x"][1], panel["columns"]):
            everywhere = "stable_to" not in found and found["verdicts"][-1] == STABLE
            stable_to = f"{found['stable_to']:.3g}" if "stable_to" in found else "all" if everywhere else "nowhere"
            fails_from = f"{found['fails_from']:.3g}" if "fails_from" in found else "nowhere" if everywhere else "all"
            table.append([panel["title"], short_number(x), panel["y"][0], stable_to, fails_from, found.get("fails_as", "")])
            for y, verdict, strain, rms, gain, warned in zip(panel["y"][1], *(found[key] for key in (
                    "verdicts", "strains", "rms", "gains", "warned"))):
                counts[verdict != STABLE, warned] += panel["ours"]
                study.row(map=name, panel=panel["title"], x_name=panel["x"][0], x=float(x), y_name=panel["y"][0],
                          **{key: found.get(key) for key in ("stable_to", "fails_from", "fails_as")}, y=float(y),
                          verdict=VERDICTS[verdict], largest_strain=strain, rms_strain=rms, energy_gain=gain, warned=warned,
                          **studies.machine(found))
    warned = (f"malha run warns (dots) of {counts[True, True]} of the {counts[True, False] + counts[True, True]} settings that "
              f"fail with malha's methods, and of {counts[False, True]} of the {counts[False, False] + counts[False, True]} that "
              "are stable, which lie near the boundary or beyond that of another chart (the filter's damping, rounding).")
    study.section(title, [*sentences, warned], ["", "at", "of", "stable to", "fails from", "as"], table,
                  (name, map_chart(chart_title, panels, across)))


COLOURS = ("#b8dfc0", "#f3c96b", "#d9584b")  # of the verdicts


def place(values, value):
    """Where a value is drawn on an axis: the smallest of `values` at 0, the next at 1; by logarithms between them."""
    values = sorted(values)
    k = np.clip(np.searchsorted(values, value), 1, len(values) - 1)
    return k - 1 + math.log(value / values[k - 1]) / math.log(values[k] / values[k - 1])


def map_chart(title, panels, across):
    """Panels of coloured cells, with dots for warnings, boundaries, and those of theory."""
    down = -(-len(panels) // across)
    wide, high = (max(len(panel[axis][1]) for panel in panels) for axis in "xy")
    longest = max(len(panel["title"]) for panel in panels)
    size = (max(9.5, 0.6 + across * max(0.9 + 0.42 * wide, 0.095 * longest)), 1.7 + down * (1.0 + 0.28 * high))
    figure, all_axes = plt.subplots(down, across, figsize=size, squeeze=False)
    lines = {}
    for axes, panel in zip(all_axes.ravel(), panels):
        (x_name, xs), (y_name, ys) = panel["x"], panel["y"]
        ascending = np.argsort(ys)
        verdicts, warned = (np.array([one[key] for one in panel["columns"]])[:, ascending].T for key in ("verdicts", "warned"))
        axes.pcolormesh(verdicts, cmap=ListedColormap(COLOURS), vmin=STABLE, vmax=DIVERGED, edgecolors="white", linewidth=1)
        axes.plot(*(np.argwhere(warned).T[::-1] + 0.5), ls="none", marker="o", markersize=3, color="#222222", zorder=4)
        for k, found in enumerate(panel["columns"]):
            for edge in found["edges"]:
                axes.hlines(sum(place(ys, y) for y in edge) / 2 + 0.5, k + 0.02, k + 0.98, color="#222222", lw=2)
        for line, at in panel["theory"]:
            middle = np.array([place(ys, y) for y in at]) + 0.5
            x = np.arange(len(xs)) + 0.5  # half a cell is added at both ends
            ends = [middle[0] - (middle[1] - middle[0]) / 2, middle[-1] + (middle[-1] - middle[-2]) / 2]
            lines[line] = axes.plot([0, *x, len(xs)], [ends[0], *middle, ends[1]], ls="--", lw=2, zorder=3,
                                    color=lines[line].get_color() if line in lines else ("#1f4e9c", "#8856a7")[len(lines)])[0]
        axes.set(xlim=(0, len(xs)), ylim=(0, len(ys)), xticks=np.arange(len(xs)) + 0.5, yticks=np.arange(len(ys)) + 0.5)
        axes.set_xticklabels(map(short_number, xs), fontsize=8)
        axes.set_yticklabels(map(short_number, np.sort(ys)), fontsize=8)
        axes.set_title(panel["title"], loc="left", fontsize=10)
        axes.set_xlabel(x_name, fontsize=9), axes.set_ylabel(y_name, fontsize=9)
        axes.grid(False), axes.tick_params(length=0)
    for axes in all_axes.ravel()[len(panels):]:
        axes.axis("off")
    figure.suptitle(title, fontsize=13)
    found = {verdict for panel in panels for one in panel["columns"] for verdict in one["verdicts"]}
    handles = [Patch(color=COLOURS[verdict], label=VERDICTS[verdict]) for verdict in sorted(found)]
    handles += [Line2D([], [], ls="none", marker="o", markersize=4, color="#222222", label="malha run warns"),
                Line2D([], [], color="#222222", lw=2, label="boundary, by bisection")]
    for line, drawn in lines.items():
        drawn.set_label(line)
    figure.tight_layout(rect=(0, 1 / size[1], 1, 1 - 0.1 / size[1]))
    figure.legend(handles=handles + list(lines.values()), loc="lower center", ncol=3, fontsize=9,
                  bbox_to_anchor=(0.5, 0.22 / size[1]))
    return figure


# ---- Lines -----------------------------------------------------------------------------------------------------------


def value(run):
    """The cell of a value: {"y": run()}, None if the simulation diverged."""
    try:
        return {"y": run()}
    except malha.Diverged:
        return {"y": None}


def line(study, name, title, settings, run, scale=1):
    """A line of a chart: points (x, cell) at x = scale * setting, one cell for each setting."""
    return title, [(scale * at, study.cell(f"{name}, {title}, {at:g}", lambda: value(lambda: run(at)))) for at in settings]


def finish(figure, title):
    """Gives the chart of several lines its title, and a legend at the right."""
    figure.suptitle(title, fontsize=13)
    figure.legend(loc="center right", fontsize=10)
    figure.subplots_adjust(left=0.09, right=0.74, top=0.92)


def lines_section(study, name, title, x_name, y_name, lines, sentences):
    """Adds the section of lines over one setting, with chart, table and rows. lines: (title, points); sentences: made from
    {title: [(x, y), ...]}, where y is NaN if the run was no longer finite."""
    shown = {}
    figure, axes = plt.subplots(figsize=(12, 6.2))
    for k, (line_title, points) in enumerate(lines):
        shown[line_title] = [(x, math.nan if cell["y"] is None else cell["y"]) for x, cell in points]
        for (x, y), (_, cell) in zip(shown[line_title], points):
            study.row(map=name, panel=line_title, x_name=x_name, x=x, y_name=y_name, y=y, **studies.machine(cell))
        positive = [point for point in shown[line_title] if point[1] > 0]
        axes.plot(*zip(*positive), marker="sovDP^X"[k % 7], label=line_title, markersize=7) if positive else None
    axes.set(xscale="log", yscale="log", xlabel=x_name, ylabel=y_name)
    finish(figure, title)
    table = []
    for x in sorted({x for points in shown.values() for x, _ in points}):
        values = [dict(points).get(x) for points in shown.values()]
        table.append([short_number(x), *("" if y is None else f"{y:.2g}" if math.isfinite(y) else "not finite" for y in values)])
    study.section(title, sentences(shown), [x_name, *shown], table, (name, figure))


# ---- Irregular meshes ------------------------------------------------------------------------------------------------


def mt19937(seed):
    """The numbers of the Mersenne Twister with 32 bits, as in C++."""
    random = np.random.RandomState(seed)
    while True:
        yield int(random.randint(0, 2**32, dtype=np.uint32))


def irregular_shell(seed, subdivisions=2):
    """Points and triangles of a closed mesh of about 1 m that resembles a scan: a sphere that is, depending on the seed,
    stretched and bumpy, jittered by up to 0.4 edges, with half of its points removed, with flipped edges and with slivers of
    1:50. It stays closed, oriented, and without doubled edges."""
    random = mt19937(seed)
    sphere = simulate(body_in_vacuum({"sphere": {"radius": 0.5, "subdivisions": subdivisions}}, [LENGTHS]))
    points, faces = sphere.positions.tolist(), sphere.faces[:, :3].tolist()

    def unit():
        return 2 * (next(random) / 2**32) - 1

    def neighbours():
        found = [set() for _ in points]
        for a, b, c in faces:
            found[a] |= {b, c}
            found[b] |= {a, c}
            found[c] |= {a, b}
        return found

    size, wave = [1 + 0.5 * unit() for _ in range(3)], [unit() for _ in range(6)]
    for p in points:
        r = 1 + 0.25 * (wave[0] * math.sin(9 * p[0] + 6 * wave[1]) + wave[2] * math.sin(8 * p[1] + 6 * wave[3]) +
                        wave[4] * math.sin(10 * p[2] + 6 * wave[5]))
        p[:] = [a * (r * s) for a, s in zip(p, size)]
    for p in points:
        p[:] = [a + seed % 5 * 0.1 * 0.55 / 2**subdivisions * unit() for a in p]
    if seed % 2:  # as many edges as half of the points are collapsed, where the surface stays closed
        for _ in range(len(points) // 2):
            near = neighbours()
            face, k = faces[next(random) % len(faces)], next(random) % 3
            a, b = face[k], face[(k + 1) % 3]
            both = near[a] & near[b]
            if len(both) != 2 or len(near[a]) + len(near[b]) > 14 or any(len(near[i]) <= 4 for i in both):
                continue
            points[a] = [(u + v) / 2 for u, v in zip(points[a], points[b])]
            faces = [[a if i == b else i for i in face] for face in faces]
            faces = [face for face in faces if len(set(face)) == 3]
        kept = list(dict.fromkeys(i for face in faces for i in face))
        number = {i: k for k, i in enumerate(kept)}
        points, faces = [points[i] for i in kept], [[number[i] for i in face] for face in faces]
    if seed % 3:  # edges are flipped to the other diagonal of their two triangles
        for _ in range(len(faces) * 3 // 10):
            one, k = next(random) % len(faces), next(random) % 3
            a, b, c = (faces[one][(k + i) % 3] for i in range(3))
            two, d = next((two, face[(face.index(b) + 2) % 3]) for two, face in enumerate(faces)
                          if b in face and face[(face.index(b) + 1) % 3] == a)
            near = neighbours()
            if d != c and d not in near[c] and min(len(near[a]), len(near[b])) >= 5 and max(len(near[c]), len(near[d])) <= 9:
                faces[one], faces[two] = [a, d, c], [d, b, c]
    if seed % 4:  # a share of the triangles is split by a point at 1/50 of the height above a side
        whole, used = len(faces), set()
        for _ in range(int(0.1 * (seed % 4) * whole)):
            f, k = next(random) % whole, next(random) % 3
            if f in used:
                continue
            used.add(f)
            a, b, c = (faces[f][(k + i) % 3] for i in range(3))
            along, height = 0.3 + 0.2 * unit(), 1 / 50
            points.append([height * z + (1 - height) * (along * x + (1 - along) * y)
                           for x, y, z in zip(points[a], points[b], points[c])])
            i = len(points) - 1
            faces[f] = [a, b, i]
            faces += [[b, c, i], [c, a, i]]
    return np.array(points), faces


# ---- Time step and stiffness -----------------------------------------------------------------------------------------


def failure_range(panel, scales):
    """The smallest and the largest time step from which columns fail, each times its scale."""
    found = [one["fails_from"] * scale for one, scale in zip(panel["columns"], scales) if "fails_from" in one]
    return (min(found), max(found)) if found else None


def steps_sentence(panel):
    found = failure_range(panel, [1] * len(panel["columns"]))
    if found is None:
        return f"{panel['title']}: stable everywhere."
    nowhere = sum("fails_from" not in one for one in panel["columns"])
    diverged = sum(one["verdicts"].count(DIVERGED) for one in panel["columns"])
    return (f"{panel['title']}: wrong or worse from steps of " +
            (f"{found[0]:.3g} s on" if found[0] == found[1] else f"{found[0]:.3g} to {found[1]:.3g} s on, by stiffness") +
            (f", at {nowhere} nowhere" if nowhere else "") +
            (f"; {diverged} cells diverged." if diverged else "; nothing diverged."))


@part(60, 20)
def steps_map(study):
    """Time step and stiffness, for malha's methods and other integrators."""
    n, most, newton = (5, 400, 60) if study.quick else (7, 4000, 200)
    scale = 0.2 * G  # J
    y = ("time step (s)", [1e-4, 1e-3, 1e-2, 1e-1] if study.quick else [1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3])
    x = ("stiffness (N/m)", [1e3, 1e5] if study.quick else [1e2, 1e3, 1e4, 1e5, 1e6, 1e7])
    systems = {k: reference_system(hanging_sheet(n, 1, 0.2, 1 / k)) for k in x[1]}
    omegas = [systems[k].largest_frequency() for k in x[1]]
    desbrun = {"type": "desbrun", "filter": "sparse"}
    solvers = {"XPBD, 1 iteration": {}, "XPBD, 10 iterations": {"iterations": 10}, "Desbrun, sparse": desbrun,
               "Desbrun, dense": desbrun | {"filter": "dense"},
               "Desbrun, int16": desbrun | {"filter": "dense", "storage": "int16"},
               "Desbrun, refine 8": desbrun | {"refinement_iterations": 8}}
    limits = {"symplectic Euler": 2, "RK4": 2.828, "backward Euler": None}  # of omega_max h, by theory

    def steps_of(h, most=most):  # for 2 s
        return int(np.clip(math.ceil(2 / h), min(200, most), most))

    def by_malha(scene, h):
        scene["solver"] |= {"dt": h, "substeps": 1}
        return judge(malha_trial(scene, steps_of(h), scale))

    panels = []
    for title, solver in solvers.items():
        panels.append(panel_of(study, f"steps: {title}, ", title, x, y,
                               lambda k, h: by_malha(hanging_sheet(n, 1, 0.2, 1 / k, **solver), h), " N/m", whole=False))
    for title, limit in limits.items():
        theory = [(f"omega h = {limit:.2f}, from the spectrum", [limit / omega for omega in omegas])] if limit else []
        panels.append(panel_of(study, f"steps: {title}, ", title, x, y, lambda k, h: judge(integrator_trial(
            systems[k], title, h, steps_of(h, most if limit else newton), scale)), " N/m", whole=False, theory=theory,
            ours=False))

    def by_pbd(stiffness, h):
        scene = hanging_sheet(n, 1, 0.2, 0)
        scene["bodies"][0]["constraints"][0]["stiffness"] = stiffness
        return by_malha(scene, h)

    stiffnesses = ("PBD stiffness", [0.01, 1] if study.quick else [1e-4, 1e-3, 0.01, 0.1, 0.5, 1])
    pbd = panel_of(study, "steps: PBD, ", "PBD, 1 iteration", stiffnesses, y, by_pbd, whole=False)
    if study.partial:
        return
    sentences = [f"A sheet of {n} x {n} particles (1 m, 0.2 kg), pinned at one row, is released from the horizontal for 2 s (at "
                 f"least 200 steps, at most {most}, with Newton's method {newton}). Wrong: some strain exceeds 50 %, or the "
                 "energy grows by more than 5 % of the potential energy that the sheet can lose; diverged: no longer finite, or "
                 "grown by more than ten times that energy.", steps_sentence(pbd)]
    for panel in panels:
        limit, found = limits.get(panel["title"]), failure_range(panel, omegas)
        sentences.append(steps_sentence(panel) if limit is None else f"{panel['title']} fails " + (
            "nowhere on the map." if found is None
            else f"from omega_max h = {found[0]:.2f} to {found[1]:.2f}; theory says {limit:.2f}."))
    map_section(study, "steps", "Time step and stiffness", "Time step and stiffness: where each method holds", [pbd, *panels], 5,
                sentences)


# ---- Heavy weights, and many particles -------------------------------------------------------------------------------


def substeps_for(load, length, strain=WRONG_STRAIN):
    """The number of substeps with which one sweep per substep leaves this strain. A link between particles of mass m that
    bears `load` times their weight stays 2 load g h^2 too long: each end moves by half of the excess length, which must
    compensate load g h^2."""
    return FRAME * math.sqrt(2 * load * G / (length * strain))


def boundary_sentence(panel):
    found = []
    for x, one in zip(panel["x"][1], panel["columns"]):
        fewest = (f"{one['stable_to']:g}" if "stable_to" in one else "1" if one["verdicts"][-1] == STABLE
                  else f"more than {panel['y'][1][0]:g}")
        found.append(f"{short_number(x)}: {fewest}" + (f" (and at most {one['stable_from']:g})" if "stable_from" in one else ""))
    return f"{panel['title']}: the fewest {panel['y'][0]} that are stable, by {panel['x'][0]}: {', '.join(found)}."


@part(36, 12)
def masses_map(study):
    """A weight at the end of a chain: mass ratio, and iterations or substeps."""
    links, light = 20, 0.01  # kg; the chain is 1 m long
    x = ("mass ratio", [10, 1e3] if study.quick else [1, 10, 100, 1e3, 1e4, 1e5])
    counts = [1024, 64, 16, 4, 1] if study.quick else [1024, 512, 256, 128, 64, 32, 16, 8, 4, 2, 1]
    theory = [("one sweep leaves 2 (3 R) g h^2 / l = 50 %", [substeps_for(3 * ratio, 1 / links) for ratio in x[1]])]
    double = {"precision": "double", "levels": "off"}
    desbrun = {"precision": "double", "type": "desbrun"}

    def outcome(ratio, springs, solver):
        """Of a chain that is horizontal at the start, whose last particle is `ratio` times as heavy as the others."""
        compliance = 0.01 / links / ((ratio + links) * light * G) if springs else 0
        scene = pinned_chain([1, 0, 0], links, None, compliance, **solver)
        body, masses = scene["bodies"][0], np.array([light] * links + [light * ratio])
        del body["mass"]
        body |= {"density": 1, "pins": []}
        map_of_masses = masses * simulate(scene).inverse_masses
        body |= {"pins": [{"particles": [0]}], "density_map": {"values": map_of_masses.tolist()}}
        return judge(malha_trial(scene, 120, light * (links + ratio) * G))

    panels = []
    for title, counted, springs, solver in (
            ("PBD, double", "substeps", False, double), ("PBD, float", "substeps", False, {"levels": "off"}),
            ("PBD, 1 substep", "iterations", False, double | {"substeps": 1}), ("PBD, 10 substeps", "iterations", False, double),
            ("XPBD, 1 % springs", "substeps", True, double), ("Desbrun, 1 % springs", "substeps", True, desbrun)):
        panels.append(panel_of(study, f"masses: {title}, 1:", title, x, (counted, counts),
                               lambda ratio, count: outcome(ratio, springs, solver | {counted: count}),
                               theory=theory if counted == "substeps" and solver is not desbrun else ()))
    if study.partial:
        return
    map_section(study, "masses", "Mass ratio, by substeps and by iterations", "A weight at the end of a chain", panels, 3, [
        f"A chain of {links} links (1 m) is released from the horizontal for 2 s in steps of 1/60 s. Its last particle is R "
        "times as heavy as each of the others. With one sweep per substep h, a link that bears the weight of n particles stays "
        "2 n g h^2 too long: each of its ends moves by half of that, which must compensate the fall. A link of a body that "
        "swings down bears up to three times its weight.", *map(boundary_sentence, panels)])


@part(30, 12)
def resolution_map(study):
    """A hanging sheet: particles a side, and substeps or iterations."""
    x = ("particles a side", [9, 33] if study.quick else [9, 17, 33, 65, 129])
    counts = [16, 4, 1] if study.quick else [64, 32, 16, 8, 4, 2, 1]
    theory = [("one sweep leaves 2 (n / 3) g h^2 / l = 50 %, at rest", [substeps_for(n / 3, 2 / (n - 1)) for n in x[1]])]
    desbrun = {"type": "desbrun", "filter": "sparse"}
    panels = []
    for title, sheet, compliance, counted, solver in (
            ("PBD, held at one row", hanging_sheet, 0, "substeps", {}),
            ("PBD, two corners", corner_pinned_sheet, 0, "substeps", {}),
            ("PBD, 1 substep, one row", hanging_sheet, 0, "iterations", {"substeps": 1}),
            ("XPBD 10 kN/m, one row", hanging_sheet, 1e-4, "substeps", {}),
            ("XPBD 10 kN/m, two corners", corner_pinned_sheet, 1e-4, "substeps", {}),
            ("Desbrun 10 kN/m, two corners", corner_pinned_sheet, 1e-4, "substeps", desbrun)):
        panels.append(panel_of(study, f"resolution: {title}, ", title, x, (counted, counts), lambda n, count: judge(
            malha_trial(sheet(n, 2, 1, compliance, **solver | {counted: count}), 120, 2 * G)), theory=() if panels else theory))
    if study.partial:
        return
    map_section(study, "resolution", "Resolution, by substeps", "A hanging sheet: particles a side and substeps", panels, 3, [
        "A sheet of 2 m and 1 kg is released from the horizontal for 2 s in steps of 1/60 s. The edge and the two diagonals that "
        "support each particle next to the row bear a column of n particles.", *map(boundary_sentence, panels)])


# ---- The order of the sweep ------------------------------------------------------------------------------------------

SOFT = 1e-4  # m/N
SWEEPS = {"plain, from the pins, double": ("pins", "double", 0), "plain, from the pins, float": ("pins", "float", 0),
          "plain, colours, double": ("colours", "double", 0), "plain, colours, float": ("colours", "float", 0),
          "malha, double": (None, "double", 0), "malha, float": (None, "float", 0),
          "plain, from the pins, 10 kN/m": ("pins", "float", SOFT), "malha, 10 kN/m": (None, "float", SOFT)}


def order_trial(title, n, substeps, systems):
    """A trial of one of SWEEPS: a sheet of 2 m and 1 kg, pinned at two corners. systems: those made so far, by n."""
    order, precision, compliance = SWEEPS[title]
    frames, scale = 60, 2 * G
    if order is None:
        return malha_trial(corner_pinned_sheet(n, 2, 1, compliance, substeps=substeps, precision=precision), frames, scale)
    if n not in systems:
        systems[n] = reference_system(corner_pinned_sheet(n, 2, 1, 1))  # sweeps do not use its compliance
    springs = (reference.order_from_pins if order == "pins" else reference.order_by_colour)(systems[n])
    return sweep_trial(systems[n], springs, precision, compliance, substeps, frames, scale)


def strains_over_time(trial):
    """RMS strain after each frame, as long as it is finite."""
    strains = []
    try:
        for _ in range(trial["steps"]):
            trial["advance"](1)
            rms = trial["sample"]()[1]
            if rms is None or not math.isfinite(rms):
                break
            strains.append(rms)
    except malha.Diverged:
        pass
    return {"rms": strains}


@part(48, 24)
def order_map(study):
    """The order in which a sweep projects constraints."""
    x = ("particles a side", [9, 33] if study.quick else [9, 17, 33, 65, 100])
    y = ("substeps", [40, 10] if study.quick else [160, 80, 40, 20, 10])
    systems = {}
    panels = [panel_of(study, f"order: {title}, ", title, x, y,
                       lambda n, substeps: judge(order_trial(title, n, substeps, systems)), ours=sweep[0] is None)
              for title, sweep in SWEEPS.items()]
    n, substeps = (33, 10) if study.quick else (100, 40)
    case = f"{n} x {n} particles, {substeps} substeps of 1 iteration"
    kept = study.cells(SWEEPS, lambda title: f"order over time: {title}, {n}, {substeps}",
                       lambda title: strains_over_time(order_trial(title, n, substeps, systems)))
    if study.partial:
        return
    sentences = ["A sheet of 2 m and 1 kg, pinned at two corners, is released from the horizontal for 1 s; hard constraints, or "
                 "springs of 10 kN/m, one sweep per substep. Plain: one constraint after the other, in order of the graph "
                 "distance from the pins, or by colours."]
    for panel in panels:
        verdicts, gains, strains = (sum((one[key] for one in panel["columns"]), []) for key in ("verdicts", "gains", "rms"))
        sentences.append(f"{panel['title']}: {verdicts.count(STABLE)} of {len(verdicts)} stable, {verdicts.count(WRONG)} bounded "
                         f"but wrong, {verdicts.count(DIVERGED)} diverged; what did not diverge gained at most {max(gains):.2g} "
                         f"times the energy of the fall, at an RMS strain of at most {max(strains):.2g}.")
    map_section(study, "order", "Order of the sweep, by resolution and substeps", "Order of the sweep: one iteration a substep",
                panels, 4, sentences)
    figure, axes = plt.subplots(figsize=(12, 6.2))
    sentences, table = [], []
    for k, (title, cell) in enumerate(zip(SWEEPS, kept)):
        strains = cell["rms"]
        last, finite = strains[-1] if strains else 0, len(strains) == 60
        # Later lines are drawn over earlier ones, and thinner, so that all are visible where they coincide.
        axes.plot(FRAME * np.arange(1, len(strains) + 1), strains, lw=1.5 + 0.7 * (len(SWEEPS) - k), label=title,
                  ls="--" if k % 4 == 1 else "-")
        study.row(map="order_time", panel=title, x=n, y=substeps, rms_strain=last, frames=len(strains), **studies.machine(cell))
        table.append([title, f"{last:.2g}", "" if finite else len(strains)])
        sentences.append(f"{title}: RMS strain {last:.2g} after 1 s." if finite else
                         f"{title}: no longer finite after {len(strains)} frames, RMS strain {last:.2g} before.")
    axes.set(yscale="log", xlabel="time (s)", ylabel="RMS strain")
    axes.set_ylim(1e-4, min(1e15, 10 * max(max(cell["rms"], default=1) for cell in kept)))
    finish(figure, case)
    study.section(f"Order of the sweep: {case}", sentences,
                  ["sweep", "RMS strain at the end", "frames until it was no longer finite"], table, ("order_time", figure))


# ---- Growth of small motions -----------------------------------------------------------------------------------------


def growth_of(scene, steps=180):
    """The growth rate (1/s) of small motions of a body about rest, by power iteration, as `malha plan` measures it; NaN if the
    body does not come to rest."""
    simulation = malha.Simulation(scene, threads=1)
    moves = simulation.inverse_masses[:, None] > 0
    rest = np.array(simulation.positions)
    small = 1e-6 * np.ptp(rest, axis=0).max() / math.sqrt(len(rest))  # m

    def step(x, v):
        simulation.positions, simulation.velocities = x, v
        simulation.step()
        return simulation.positions, simulation.velocities

    x_at_rest, v_at_rest = step(rest, 0 * rest)
    at_first = np.abs(x_at_rest - rest).max()
    if at_first > small:  # steps from velocity zero bring the body to rest, such as one that pressure inflates
        rest[len(rest) // 2] += 1e4 * small  # an equilibrium that a perturbation ends does not count
        x_at_rest, v_at_rest = step(rest, 0 * rest)
        for _ in range(steps):
            if np.abs(x_at_rest - rest).max() <= 1e-3 * at_first:
                break
            rest = np.array(x_at_rest)
            x_at_rest, v_at_rest = step(rest, 0 * rest)
        if np.abs(x_at_rest - rest).max() > 1e-3 * at_first:
            return math.nan

    def advance(x, v):
        """The linearised step, and the logarithm of the factor by which it multiplies the velocities."""
        x, v = (one * small / max(np.abs(x).max(), FRAME * np.abs(v).max()) for one in (x, v))
        after = [one - at_rest for one, at_rest in zip(step(rest + moves * x, moves * v), (x_at_rest, v_at_rest))]
        return *after, np.log(np.linalg.norm(after[1]) / np.linalg.norm(v))

    numbers, random = [], 1  # Numerical Recipes' linear congruence
    for _ in range(rest.size):
        random = (random * 1664525 + 1013904223) % 2**32
        numbers.append(random / 2**31 - 1)
    v = np.reshape(numbers, rest.shape) * moves
    v *= small / (FRAME * np.abs(v).max())
    v = advance(0 * v, v)[1] - v  # the difference removes zero modes, which keep their velocities
    growth, length = 0.0, steps // 3
    for _ in range(3):
        x, velocities, logs = 0 * v, [v], [0.0]
        for _ in range(length):
            x, v, change = advance(x, v)
            velocities.append(v)
            logs.append(logs[-1] + change)
            if not math.isfinite(logs[-1]):  # all motion has ended
                return growth
        # The velocities of a mode oscillate. From rest they exceed their start only if the mode grows, and then their peaks
        # grow. The rate of a decaying mode follows from the peaks of the last two quarters.
        parts = ((0, length // 2 + 1), (length // 2 + 1, 3 * length // 4 + 1), (3 * length // 4 + 1, length + 1))
        early, third, last = (first + int(np.argmax(logs[first:end])) for first, end in parts)
        late = third if logs[third] > logs[last] else last
        grows = logs[late] > logs[early]
        before, after = (early, late) if grows else (third, last)
        rate = (logs[after] - logs[before]) / (after - before) / FRAME
        growth, v = rate if grows else min(0.0, rate), velocities[last]
    return growth


@part(9, 4)
def growth_by_order(study):
    """Growth of small motions about rest, by the order of the sweep."""
    name, least = "amplification", 0.1  # 1/s; smaller and negative growth is drawn there
    system = reference_system(body_in_vacuum(SHELL, [LENGTHS | {"compliance": 1}]))  # which sweeps do not use
    by_colours = reference.order_by_colour(system)
    in_order = sorted(by_colours)
    shuffled, random = in_order.copy(), mt19937(1)
    for k in range(len(shuffled), 1, -1):
        other = next(random) % k
        shuffled[k - 1], shuffled[other] = shuffled[other], shuffled[k - 1]
    orders = {"one way, in order": in_order, "one way, shuffled": shuffled, "one way, by colours": by_colours,
              "there and back, in order": in_order + in_order[::-1]}
    if study.quick:
        orders = {title: orders[title] for title in ("one way, in order", "there and back, in order")}
    counts = [10, 160] if study.quick else [10, 20, 40, 80, 160]
    of_substep = study.cells(orders, lambda title: f"{name}, {title}",
                             lambda title: {"y": reference.amplification_of_sweep(system, orders[title])})
    malha_line = line(study, name, "malha", counts, lambda n: max(least, growth_of(body_in_vacuum(SHELL, [LENGTHS], n))))
    if study.partial:
        return
    lines = [(title, [(n, cell | {"y": max(least, math.log(cell["y"]) * n / FRAME)}) for n in counts])
             for title, cell in zip(orders, of_substep)] + [malha_line]

    def sentences(shown):
        yield ("Hard constraints on the lengths of the edges. For the plain orders the growth is the spectral radius from the "
               "eigenvalues of the whole linearised sweep; for malha it is measured as by malha plan.")
        for title, points in shown.items():
            n, growth = points[0]
            yield title + (f": with {n} substeps motion grows by {growth:.3g} a second, {math.exp(growth * FRAME / n):.3g} times "
                           "a substep." if growth > least else ": it does not grow.")
    lines_section(study, name, "Growth of small motions about rest, by the order of the sweep: a shell of 162 particles",
                  "substeps a frame of 1/60 s", "growth a second (0.1: none)", lines, sentences)


@part(63, 7)
def growth_by_kind(study):
    """Growth of small motions about rest, for all kinds of constraints."""
    bending = {"rigidity": 1e-3}
    kinds = {"distance": [LENGTHS], "distance, bending of stiffness 0.02": [LENGTHS, {"type": "bending", "stiffness": 0.02}],
             "distance, bending of 1e-3 N m": [LENGTHS, {"type": "bending"} | bending],
             "distance, isometric_bending of 1e-3 N m": [LENGTHS, {"type": "isometric_bending"} | bending],
             "distance, plate of 1e-3 N m": [LENGTHS, {"type": "plate", "poisson_ratio": 0} | bending],
             "membrane of 1 kN/m": [{"type": "membrane", "young_modulus": 1000, "poisson_ratio": 0.3}]}
    points, faces = irregular_sheet(17)
    points = points / SIDE
    order = np.lexsort((points[:, 0], np.round(16 * points[:, 2])))
    meshes = {"grid of 17 x 17": {"grid": {"size": [1, 1], "cells": [16, 16]}},
              "irregular, by rows": malha.shape(points[order], sorted(np.argsort(order)[faces].tolist())),
              "irregular, shuffled": malha.shape(points, faces)}
    if study.quick:
        del kinds["membrane of 1 kN/m"], meshes["grid of 17 x 17"], meshes["irregular, by rows"]
    cases = [(kind, mesh, (meshes[mesh], kinds[kind]), {}) for kind in kinds for mesh in meshes]
    cases += [("distance, pressure", "shell", (SHELL, [LENGTHS, {"type": "pressure"}]), {}),
              ("neo_hookean of 1 kPa", "cells of five tetrahedra", ({"tet_box": {"size": [1, 0.3, 0.3], "cells": [9, 3, 3]}}, [
                  {"type": "neo_hookean", "young_modulus": 1000, "poisson_ratio": 0.3}]), {})]
    if not study.quick:
        cases.append(("distance, with levels", "grid of 47 x 47, pinned by a row", (
            {"grid": {"size": [1, 1], "cells": [46, 46]}}, [LENGTHS]), {"pins": [{"row": "first"}]}))
    counts = [10] if study.quick else [10, 40, 160]
    found = [line(study, "growth", f"{kind}, {mesh}", counts, lambda n: growth_of(body_in_vacuum(*body, substeps=n, **more)))
             for kind, mesh, body, more in cases]
    if study.partial:
        return
    for title, points in found:
        for n, cell in points:
            study.row(map="growth", panel=title, x_name="substeps", x=n, y_name="growth a second", y=cell["y"],
                      **studies.machine(cell))
    most = max(cell["y"] for _, points in found for _, cell in points if cell["y"] is not None)
    study.section("Growth of small motions about rest: kinds, meshes, numberings", [
        "Undamped bodies of 1 m in vacuum, by malha in double, as malha plan measures them over 3 s.",
        f"The largest growth of all is {most:.2g} a second: {'none adds energy' if most < 0.5 else 'some add energy'}."],
        ["constraints", "mesh", *(f"growth a second, {n} substeps" for n in counts)],
        [[kind, mesh, *("not at rest" if cell["y"] is None else f"{cell['y']:.2g}" for _, cell in points)]
         for (kind, mesh, *_), (_, points) in zip(cases, found)])


@part(3, 3)
def minute_in_vacuum(study):
    """Conservation of energy and both momenta of a free body over a minute."""
    times = [1, 10] if study.quick else [1, 2, 5, 10, 20, 60]
    motion = {"transform": {"scale": [1, 2, 0.5]}, "velocity": [0.3, 0.2, -0.1], "spin": [2, 3, -1]}  # so that it tumbles
    system = reference_system(body_in_vacuum(SHELL, [LENGTHS | {"compliance": 1}], **motion))
    then = system.conserved(system.positions, system.velocities)

    def changes(advance, state):
        """Changes of energy, momentum and angular momentum, over what there was, at all times."""
        found, frames = [], 0
        for time in times:
            advance(round(time / FRAME) - frames)
            frames = round(time / FRAME)
            now = system.conserved(*state())
            found.append([np.linalg.norm(np.subtract(now[key], then[key])) / np.linalg.norm(then[key]) for key in keys])
        return {"at": found}

    def by_malha(precision):
        simulation = malha.Simulation(body_in_vacuum(SHELL, [LENGTHS], precision=precision, **motion), threads=1)
        return changes(simulation.step, lambda: (simulation.positions, simulation.velocities))

    def one_way():
        sweep = reference.PlainSweep(system, reference.order_by_colour(system))
        return changes(lambda n: sweep.advance(FRAME / 10, 10 * n), lambda: (sweep.positions, sweep.velocities))

    keys, quantities = ("kinetic", "momentum", "angular_momentum"), ("energy", "momentum", "angular momentum")
    methods = [("one way", (0, 2), one_way), ("malha, float", (1, 2), lambda: by_malha("float")),
               ("malha, double", (0, 1, 2), lambda: by_malha("double"))]
    cells = study.cells(methods, lambda method: f"minute: {method[0]}", lambda method: method[2]())
    if study.partial:
        return
    lines = [(f"{title}: {quantities[k]}", [(time, cell | {"y": at[k]}) for time, at in zip(times, cell["at"])])
             for (title, shown, _), cell in zip(methods, cells) for k in shown]
    lines_section(study, "minute", "A free shell that turns, in vacuum, 10 substeps: what it keeps", "time (s)",
                  "change, over what it had", lines, lambda shown: [
                      f"After {times[-1]} s, over what there was: " +
                      ", ".join(f"{title} {points[-1][1]:.2g}" for title, points in shown.items()) + ".",
                      "One way: a plain sweep in double by colours, along current gradients. malha's sweeps are symmetric (there "
                      "and back), along the gradients at the start of the substep."])


# ---- Stiffness that depends on the step, and rounding ----------------------------------------------------------------


@part(32, 12)
def stiffness_failure(study):
    """A chain of ten links of 0.1 m and 0.1 kg in all, which hangs at rest and is damped."""
    strain = 0.05  # mean over the links
    compliance = strain * 0.1 / (0.1 / 11 * G * 5.5)  # over the mean load of a link

    def elongation(material, **solver):
        scene = pinned_chain([0, -1, 0], 10, 0.1, 0, precision="double", **solver)
        scene["bodies"][0] |= {"damping": 0.3, "constraints": [LENGTHS | material]}
        return abs(simulate(scene, 300).positions[-1, 1] + 1)

    counts = [1, 8, 64] if study.quick else [2**k for k in range(8)]
    lines = [line(study, "stiffness", f"{method}, {counted}", counts,
                  lambda n: elongation(material, **{"substeps": 1, "iterations": 1} | {counted: n}))
             for method, material in (("PBD, stiffness 0.5", {"stiffness": 0.5}), ("compliance", {"compliance": compliance}))
             for counted in ("substeps", "iterations")]
    if study.partial:
        return

    def sentences(shown):
        for title, points in shown.items():
            low, high = (of(y for _, y in points) for of in (min, max))
            yield f"{title}: {low:.2g} to {high:.2g} m, {high / low:.1f} times."
        yield (f"Springs of that compliance stretch by {strain:.3g} m. Remedy: \"compliance\" or \"rigidity\" instead of "
               "\"stiffness\".")
    lines_section(study, "stiffness", "PBD stiffness depends on the step, compliance does not", "sweeps a frame of 1/60 s",
                  "elongation of a hanging chain of 1 m (m)", lines, sentences)


def sheet_positions(precision, substeps, distance=0):
    """After half a second, of a sheet at the distance from the origin along all axes; relative to there."""
    scene = hanging_sheet(17, 1, 0.2, 0, precision=precision, substeps=substeps)
    scene["bodies"][0]["transform"] = {"translate": [distance] * 3}
    return simulate(scene, 30).positions - distance


@part(14, 6)
def substeps_failure(study):
    """Float with many substeps."""
    system = reference_system(hanging_sheet(17, 1, 0.2, 1))  # sweeps do not use its compliance

    def swept(precision, substeps):
        sweep = reference.PlainSweep(system, reference.order_by_colour(system), precision)
        sweep.advance(FRAME / substeps, 30 * substeps)
        return sweep.positions

    counts = [1, 32, 1024] if study.quick else [4**k for k in range(7)]
    plain = "plain sweep, v = (p - x) / h"
    lines = [line(study, "substeps", "malha", counts,
                  lambda n: studies.rms_distance(sheet_positions("float", n), sheet_positions("double", n))),
             line(study, "substeps", plain, counts, lambda n: studies.rms_distance(swept("float", n), swept("double", n)))]
    if study.partial:
        return
    lines_section(study, "substeps", "Float with many substeps: 17 x 17 particles pinned at one row, after 0.5 s",
                  "substeps a frame of 1/60 s", "RMS distance of float from double (m)", lines, lambda shown: [
                      f"With {counts[-1]} substeps float is {shown['malha'][-1][1]:.2g} m from double in malha and "
                      f"{shown[plain][-1][1]:.2g} m in a plain sweep, whose velocities are differences of rounded positions; the "
                      f"sheet itself falls by {0.5 * G * 0.25:.2g} m.",
                      "Remedies: malha computes displacements, which are small in a substep, and carries the rounding remainders "
                      "of positions; \"precision\": \"double\"."])


@part(12, 6)
def distance_failure(study):
    """Float far from the origin."""
    truth = sheet_positions("double", 10)
    distances = [1, 100, 10000] if study.quick else [10**k for k in range(6)]
    lines = [line(study, "distance", precision, distances, lambda far: studies.rms_distance(sheet_positions(precision, 10, far), truth))
             for precision in ("float", "double")]
    if study.partial:
        return
    far = distances[-1]
    lines_section(study, "distance", "Far from the origin: 17 x 17 particles after 0.5 s, 10 substeps",
                  "distance from the origin (m)", "RMS distance from double at the origin (m)", lines, lambda shown: [
                      f"At {short_number(far)} m the error of float is {shown['float'][-1][1]:.2g} m, where its numbers are "
                      f"{np.spacing(np.float32(far)):.2g} m apart, and that of double is {shown['double'][-1][1]:.2g} m.",
                      "Remedies: malha computes displacements and carries the rounding remainders of positions. Contacts and "
                      "Desbrun's method use positions only; run, plan and reports warn if a thousandth of an edge is lost to "
                      "rounding. Then \"precision\": \"double\" helps, or a scene that is moved to the origin."])


# ---- Collapsed starts, and thin surfaces -----------------------------------------------------------------------------


@part(12, 12)
def start_failure(study):
    """Random and collapsed initial states of a sheet that is pinned at two corners: RMS strains at the start, after 0.5 s and
    after 3 s (None if no longer finite), and the number of constraints without a direction."""
    n, half, end = 7 if study.quick else 17, 30, 180  # frames

    def start_positions(scene, start):
        random = mt19937(7)
        x = np.array(simulate(scene).positions)
        for i in range(n * n):
            if i in (0, n - 1):
                continue
            x[i] = 0.5, -0.5, 0.5
            if start != "one point":
                unit = np.array([next(random) / 2**32 for _ in range(3)])
                x[i] = unit - [0, 0.5, 0] if start == "anywhere in 1 m^3" else x[i] + 1e-6 * unit
        return x

    def by_malha(scene, start):
        simulation = malha.Simulation(scene, threads=1)
        simulation.positions = start_positions(scene, start)
        strains = [simulation.measure()["strain_rms"]]
        for frames in (half, end - half):
            simulation.step(frames)
            strains.append(simulation.measure()["strain_rms"])
        return {"strain": strains, "degenerate": simulation.measure()["degenerate_constraints_skipped"]}

    def by_euler(scene, start):
        system = reference_system(scene)
        h = 0.5 / system.largest_frequency()
        x = start_positions(scene | {"solver": scene["solver"] | {"precision": "double"}}, start)
        run = reference.Integrator(system, "symplectic Euler", x, 0 * x)
        strains = [sample_of(system, x, 0 * x)[1]]
        for steps in (int(half * FRAME / h), int(end * FRAME / h) - int(half * FRAME / h)):
            run.advance(h, steps)
            strains.append(sample_of(system, run.positions, run.velocities)[1])
        return {"strain": strains, "degenerate": None}

    def unfold(case):
        start, method = case
        solver = {"type": "desbrun"} if "Desbrun" in method else {}
        scene = corner_pinned_sheet(n, 1, 0.2, 0 if method == "PBD" else 1e-3, **solver)
        return (by_euler if "Euler" in method else by_malha)(scene, start)

    cases = [(start, method) for start in ("anywhere in 1 m^3", "within 1e-6 m", "one point")
             for method in ("PBD", "XPBD, 1 kN/m", "Desbrun, 1 kN/m", "symplectic Euler, 1 kN/m")]
    kept = study.cells(cases, lambda case: f"start: {n}, {case[0]}, {case[1]}", unfold)
    if study.partial:
        return
    sentences, table = [], []
    for (start, method), cell in zip(cases, kept):
        strains = ["not finite" if strain is None else f"{strain:.2g}" for strain in cell["strain"]]
        table.append([start, method, *strains, cell["degenerate"]])
        study.row(map="start", panel=method, x_name=start, rms_strain=cell["strain"][-1], **studies.machine(cell))
        sentences.append(f"{method}, {start}: RMS strain {strains[0]} at the start and {strains[-1]} after 3 s.")
    sentences.append("Remedy: a constraint between coincident particles has no direction. It is skipped, and counted in the "
                     "report (degenerate_constraints_skipped), until other constraints separate its ends.")
    study.section(f"Random and collapsed starts: {n} x {n} particles pinned at two corners", sentences, [
        "start", "method", "RMS strain at the start", "after 0.5 s", "after 3 s", "without a direction"], table)


@part(5, 2)
def thickness_failure(study):
    """Surfaces that are thinner than the displacement of a particle in a step."""
    thickness = 0.002  # m

    def tunnelled(speed):
        """Of 11 x 11 free particles that are thrown at a wall, the number that are behind it in the end."""
        lattice = {"min": [-1, -0.5, -0.5], "max": [-1, 0.5, 0.5], "count": [1, 11, 11]}
        bullets = {"name": "bullets", "shape": {"lattice": lattice}, "mass": 1, "velocity": [speed, 0, 0]}
        wall = {"name": "wall", "shape": {"grid": {"size": [10, 10], "cells": [4, 4]}}, "sides": "two_sided",
                "thickness": thickness, "transform": {"translate": [0, -5, -5], "rotate": {"axis": [0, 0, 1], "degrees": 90}}}
        scene = {"name": "bullets", "solver": {"type": "pbd", "dt": FRAME, "substeps": 1}, "bodies": [bullets],
                 "environment": [wall], "duration": 1}
        return int((simulate(scene, max(2, math.ceil(2 / speed / FRAME))).positions[:, 0] > 0).sum())

    def intersections(speed):
        """The number of intersections of edges and triangles after one sheet was thrown at another."""
        scene = hanging_sheet(9, 0.5, 0.05, 0, substeps=1, iterations=4) | {"gravity": [0, 0, 0],
                                                                           "self_collision": {"thickness": thickness}}
        scene["bodies"][0]["pins"] = []
        scene["bodies"].append(scene["bodies"][0] | {"name": "other", "transform": {"translate": [0.03, 0.3, 0.02]},
                                                     "velocity": [0, -speed, 0]})
        return simulate(scene, max(2, math.ceil(0.6 / speed / FRAME))).measure()["crossings"]

    def tunnels_through_end_test(speed, phase):
        """Whether a particle passes the wall where a test at the end of each step finds particles within the thickness. phase:
        offset of the start, in steps."""
        x = -1 - phase * speed * FRAME
        while x < -thickness:
            x += speed * FRAME
        return x > thickness

    speeds = [1, 100] if study.quick else [0.1, 1, 10, 100, 1000]  # m/s
    kept = study.cells(speeds, lambda speed: f"thickness: {speed:g} m/s",
                       lambda speed: {"passed": tunnelled(speed), "crossings": intersections(speed)})
    if study.partial:
        return
    table = []
    for speed, cell in zip(speeds, kept):
        unseen = sum(tunnels_through_end_test(speed, k / 100) for k in range(100))
        table.append([short_number(speed), f"{speed * FRAME / thickness:.3g}", cell["passed"], f"{unseen} %", cell["crossings"]])
        study.row(map="thickness", x_name="speed (m/s)", x=float(speed), passed=cell["passed"], passed_unseen_percent=unseen,
                  crossings=cell["crossings"], **studies.machine(cell))
    most = max(max(cell["passed"], cell["crossings"]) for cell in kept)
    study.section("Thickness smaller than the displacement in a step", [
        f"121 particles fly at a wall {thickness:g} m thick, and a sheet at another, one substep per step: a discrete test at "
        f"the ends of steps lets up to {max(int(row[3][:-2]) for row in table)} % pass; with malha, {most} pass or intersect.",
        "Remedy: collisions are detected along the whole motion (Embree's rays, swept boxes, division planes)."],
        ["speed, m/s", "displacement in a step, thicknesses", "passed, malha, of 121", "passed, discrete test",
         "intersections of two sheets, malha"], table)


# ---- Stiff shells on impact ------------------------------------------------------------------------------------------


@part(8, 4)
def impact_failure(study):
    """Irregular closed meshes with stiff bending are dropped on the ground."""
    meshes, drop = 4 if study.quick else 20, 0.5  # m

    def worst(bending):
        """The largest speed, over that of a fall from the highest point to the ground, and the largest strain."""
        speed = strain = 0
        try:
            for seed in range(meshes):
                points, faces = irregular_shell(seed)
                shell = {"name": "shell", "shape": malha.shape(points, faces), "mass": 1, "constraints": [LENGTHS, bending],
                         "transform": {"translate": [0, drop - points[:, 1].min(), 0]}}
                ground = {"name": "ground", "shape": {"grid": {"size": [20, 20], "cells": [1, 1]}}, "sides": "one_sided",
                          "friction": 0.3, "transform": {"translate": [-10, 0, -10]}}
                simulation = simulate({"name": "impact", "solver": {"type": "pbd", "dt": FRAME, "substeps": 10}, "duration": 1,
                                       "gravity": [0, -G, 0], "bodies": [shell], "environment": [ground]})
                top = simulation.positions[:, 1].max()
                for _ in range(60):
                    simulation.step()
                    now = simulation.measure()
                    speed = max(speed, now["speed_max_m_per_s"] / math.sqrt(2 * G * top))
                    strain = max(strain, now["strain_max"])
        except malha.Diverged:
            return {"speed": None, "strain": None}
        return {"speed": speed, "strain": strain}

    bendings = {f"stiffness {k:g}": {"stiffness": k} for k in ([1, 1e-4] if study.quick else [1, 1e-2, 1e-4, 1e-6])}
    bendings |= {f"compliance {a:g} rad/(N m)": {"compliance": a} for a in ([1e-2, 1e2] if study.quick else [1e-4, 1e-2, 1, 1e2])}
    kept = study.cells(bendings, lambda title: f"impact: {meshes}, {title}",
                       lambda title: worst({"type": "bending"} | bendings[title]))
    if study.partial:
        return
    for title, cell in zip(bendings, kept):
        study.row(map="impact", panel=title, speed=cell["speed"], strain=cell["strain"],
                  verdict=VERDICTS[DIVERGED if cell["speed"] is None else STABLE], **studies.machine(cell))
    most = {key: max(math.inf if cell[key] is None else cell[key] for cell in kept) for key in ("speed", "strain")}
    study.section(f"Stiff shells on impact: {meshes} irregular closed meshes dropped by {drop:g} m, 10 substeps", [
        f"No particle is faster than {most['speed']:.2g} times the speed of a free fall, and no edge is strained by more than "
        f"{most['strain']:.2g}.",
        f"Remedy: one projection of bending moves no particle farther than {math.pi / 64:.2g} of the smaller height of its hinge "
        "at rest, because the angle is only linear for small displacements; the remaining error is corrected by later "
        "projections. Distances are linear along their own direction and need no bound."],
        ["bending", "largest speed / speed of a free fall", "largest strain"],
        [[title, *("diverged" if cell[key] is None else f"{cell[key]:.2g}" for key in ("speed", "strain"))]
         for title, cell in zip(bendings, kept)])


# ---- Desbrun's linear filter -----------------------------------------------------------------------------------------


def filtered(corrector, refinements, **more):
    return {"type": "desbrun", "substeps": 1, "precision": "double", "filter": "sparse", "corrector": corrector,
            "refinement_iterations": refinements} | more


@part(50, 20)
def torque_failure(study):
    """The filter takes angular momentum from a free sheet of 0.2 kg, which rotates about all axes without gravity; its springs
    start a tenth longer than at rest."""
    def relative_change(k, solver):
        scene = hanging_sheet(9, 1, 0.2, 1 / k, **solver) | {"gravity": [0, 0, 0]}
        scene["bodies"][0] |= {"pins": [], "spin": [1, 2, -3]}
        scene["bodies"][0]["constraints"][0]["rest_scale"] = 0.9
        simulation = malha.Simulation(scene, threads=1)
        before = np.array(simulation.measure()["angular_momentum_kg_m2_per_s"])
        simulation.step(10)
        return np.linalg.norm(simulation.measure()["angular_momentum_kg_m2_per_s"] - before) / np.linalg.norm(before)

    stiffnesses = [1e-3, 0.1, 10, 1e3] if study.quick else [10.0**k for k in range(-3, 7)]
    lines = [line(study, "torque", title, stiffnesses, lambda k: relative_change(k, filtered(corrector, refinements)),
                  FRAME * FRAME / (0.2 / 81)) for title, corrector, refinements in (
        ("corrector paper", "paper", 0), ("corrector off", "off", 0), ("corrector inertia (default)", "inertia", 0),
        ("corrector off, refine 8", "off", 8), ("corrector off, refine 32", "off", 32))]
    if study.partial:
        return

    def sentences(shown):
        for title, points in shown.items():
            x, y = points[2 if study.quick else 4]
            yield f"{title}: " + (f"{y:.2g}" if math.isfinite(y) else "not finite") + f" at k h^2 / m = {x:.2g}."
        yield ("Remedy: the default corrector, which uses the body's inertia; run and plan warn if the scene has another one and "
               "too few refinements, so that half of the angular momentum would be lost in 10 steps.")
    lines_section(study, "torque", "Torque of the linear filter: a free rotating sheet, 10 steps of 1/60 s", "k h^2 / m",
                  "relative change of angular momentum", lines, sentences)


@part(35, 14)
def turning_failure(study):
    """The filter damps parts that rotate: a straight chain of 1 m, pinned at one end, falls from the horizontal."""
    stiffnesses, frames = [1e3, 1e5] if study.quick else [1e2, 1e3, 1e4, 1e5, 1e6], 15

    def falling_chain(k, **solver):
        return pinned_chain([1, 0, 0], 10, 0.1, 1 / k, **solver)

    def true_positions(k):
        system = reference_system(falling_chain(k))
        steps = math.ceil(frames * FRAME / (0.5 / system.largest_frequency()))
        run = reference.Integrator(system, "RK4", system.positions, system.velocities)
        run.advance(frames * FRAME / steps, steps)
        return run.positions.ravel()

    def measure():  # errors need the reference solution
        truth = {k: np.reshape(study.cell(f"turning: truth, {k:g}", lambda: true_positions(k)), (-1, 3)) for k in stiffnesses}
        solvers = {"refine 0": filtered("off", 0), "refine 4": filtered("off", 4), "refine 16": filtered("off", 16),
                   "16 substeps": filtered("off", 0, substeps=16), "256 substeps": filtered("off", 0, substeps=256),
                   "XPBD, 16 substeps": {"substeps": 16, "precision": "double"}}
        for title, solver in solvers.items():
            lines.append(line(study, "turning", title, stiffnesses, lambda k: studies.rms_distance(
                simulate(falling_chain(k, **solver), frames).positions, truth[k]), FRAME * FRAME / 0.01))

    lines = []
    study.together(measure)
    if study.partial:
        return
    lines_section(study, "turning", "Rotating parts: a chain falls about its pin for 0.25 s, steps of 1/60 s", "k h^2 / m",
                  "RMS distance from the true springs (m)", lines, lambda shown: [
                      *(f"{title}: error {points[-1][1]:.2g} m at k h^2 / m = {points[-1][0]:.2g}."
                        for title, points in shown.items()),
                      "The corrector of a body's total momentum does not act on parts that rotate against each other, nor on "
                      "pinned bodies. Remedies: \"refinement_iterations\" if k h^2 / m is small, substeps, or XPBD; run and plan "
                      "warn if the filter damps oscillations about the pins by more than a fifth of critical damping."])


@part(12, 4)
def weight_failure(study):
    """Gravity that is not filtered stretches springs next to pins: a sheet that hangs at rest by a row."""
    def strain_at_rest(n, filters, h):
        scene = hanging_sheet(n, 1, 0.2, 1e-4, **filtered("inertia", 0, dt=h, filter_external_forces=filters))
        scene["bodies"][0]["transform"] = {"rotate": {"axis": [1, 0, 0], "degrees": 90}}
        return simulate(scene, int(3 / h)).measure()["strain_max"]

    sheets = [(5, FRAME), (17, 0.1)] if study.quick else [(5, FRAME), (17, FRAME), (65, FRAME), (17, 0.05), (17, 0.1), (17, 0.2)]
    titles = {"filter_external_forces: false": False, "filter_external_forces: true (default)": True}
    lines = [(title, [(G * h * h * (n - 1), study.cell(f"weight, {title}, {n}, {h:g} s", lambda: value(
        lambda: strain_at_rest(n, filters, h)))) for n, h in sheets]) for title, filters in titles.items()]
    if study.partial:
        return

    def sentences(shown):
        (x, without), (_, by_default) = (points[-1] for points in shown.values())
        yield (f"At g h^2 / l = {x:.2g} the largest strain is {without:.2g} if gravity is not filtered and {by_default:.2g} if "
               "all forces are.")
        yield ("Remedy: all forces are filtered by default; run and plan warn if \"filter_external_forces\": false would stretch "
               "springs by more than 40 %.")
    lines_section(study, "weight", "Gravity that is not filtered: a sheet of 1 m hanging at rest by a row", "g h^2 / l",
                  "largest strain after 3 s", lines, sentences)


# ---- The study -------------------------------------------------------------------------------------------------------


def measure(study):
    study.plan(sum(quick_cells if study.quick else cells for cells, quick_cells in PARTS.values()))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of what diverges
        for function in PARTS:
            function(study)


if __name__ == "__main__":
    studies.main("stability", "Settings with which each method fails, how it fails, and remedies", measure)
