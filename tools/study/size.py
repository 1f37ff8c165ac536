# SPDX-License-Identifier: Apache-2.0
"""Time, memory, set-up and errors of a hanging cloth, from small bodies to millions of particles, on one thread.

The cloth has 2 m x 2 m and 1 kg, and hangs by a row. Its rows, if they did not stretch, would move as the joints of a chain,
which is the truth that the errors are measured from. At last a clamped strip bends under its weight.

    PYTHONPATH=build/release /usr/bin/python3 tools/study/size.py --quick

A method that is compared is a line of METHODS (costs), HANGING (errors of the cloth) or BENDING (errors of the strip).
"""
import ctypes
import functools
import math
import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

studies.require("_malha_reference")

import _malha_reference as reference  # noqa: E402
import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import LogLocator  # noqa: E402

G = 9.81  # m/s^2
FRAME = 1 / 60  # s, a step
SIDE = 2.0  # m, of the cloth
TURNS = 5  # how often a time is measured
PBD = {"type": "pbd", "substeps": 10, "levels": "off"}
SPARSE = {"type": "desbrun", "substeps": 1, "filter": "sparse"}
DENSE = SPARSE | {"filter": "dense"}
METHODS = {"PBD, 10 substeps": PBD, "Desbrun, sparse": SPARSE, "Desbrun, dense": DENSE}
COLOURS = dict(zip(METHODS, ("#0072b2", "#009e73", "#e69f00")))
MARKS = dict(zip(METHODS, "oDs"))


# ---- The cloth -------------------------------------------------------------------------------------------------------


def cloth(shape, solver, *, elements=("edges", "shear"), more=(), **spring):
    """The scene of the hanging cloth. shape: its mesh, pinned where z = 0. solver: keys of the solver. spring: further keys
    of its distance constraints on `elements`. more: other constraints."""
    box = {"min": [-SIDE, -SIDE, 0], "max": [2 * SIDE, SIDE, 0]}
    return {"name": "a hanging cloth", "duration": 1, "gravity": [0, -G, 0], "solver": {"dt": FRAME} | solver, "bodies": [
        {"name": "cloth", "shape": shape, "mass": 1, "pins": [{"box": box}],
         "constraints": [{"type": "distance", "elements": list(elements)} | spring, *more]}]}


def grid(side):
    """A square of side x side particles."""
    return {"grid": {"size": [SIDE, SIDE], "cells": [side - 1, side - 1]}}


def splitmix(first, count):
    """The random numbers first .. first + count - 1 of SplitMix64 (Steele, Lea, Flood 2014), which are the same everywhere."""
    z = np.uint64(2019) + np.arange(first + 1, first + count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@functools.lru_cache(maxsize=None)
def irregular_sheet(side):
    """An irregular mesh of side x side points, as those of scanned and modelled clothes, which is the same on every machine: a
    lattice whose points are jittered, whose diagonals are chosen at random, and many of whose edges are flipped where both
    triangles stay well-shaped. Inner points have 4 to 9 neighbours. Points (N, 3) and triangles (T, 3) are shuffled."""
    n, cells, used = side * side, side - 1, 0

    def draw(count):
        nonlocal used
        used += count
        return splitmix(used - count, count)

    # The shift of each line of the lattice, in cells. The border stays straight.
    shift = 0.2 * ((draw(2 * n) >> np.uint64(11)).astype(float) * 2.0**-52 - 1).reshape(side, side, 2)
    lines = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1)
    plane = np.where(lines == cells, SIDE, np.where(lines == 0, 0.0, (lines + shift) * (SIDE / cells))).reshape(n, 2)
    border = np.any((lines == 0) | (lines == cells), axis=-1).ravel().tolist()
    a = (np.arange(cells)[:, None] * side + np.arange(cells)).ravel()
    b, c, d = a + 1, a + side, a + side + 1
    rising = (draw(cells * cells) & np.uint64(1)).astype(bool)[:, None]
    start = np.where(rising, np.stack([a, c, b, b, c, d], axis=1), np.stack([a, c, d, a, d, b], axis=1)).ravel()

    # Half-edge 3 t + k leads from corner k of triangle t to the next corner; its twin leads back, -1 on the border.
    end = start.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    code, back = start * n + end, end * n + start
    order = np.argsort(code)
    place = order[np.minimum(np.searchsorted(code, back, sorter=order), len(code) - 1)]
    twins = np.where(code[place] == back, place, -1)
    valence = (np.bincount(start, minlength=n) + np.bincount(end[twins < 0], minlength=n)).tolist()
    corner, twin, x, z = start.tolist(), twins.tolist(), plane[:, 0].tolist(), plane[:, 1].tolist()

    def is_well_shaped(a, b, c):
        ux, uz, vx, vz, wx, wz = x[b] - x[a], z[b] - z[a], x[c] - x[b], z[c] - z[b], x[c] - x[a], z[c] - z[a]
        squares = (ux * ux + uz * uz) + (vx * vx + vz * vz) + (wx * wx + wz * wz)
        # 2 sqrt(3) times twice the area over the squares is 1 for the equilateral triangle and 0.87 for half a square.
        return 3.4641016151377544 * (uz * wx - ux * wz) > 0.5 * squares

    # An edge is flipped to the other diagonal of its two triangles, if triangles and valences stay good.
    for block in range(0, 3 * len(corner), 1_000_000):
        count = min(1_000_000, 3 * len(corner) - block)
        for h in (draw(count) % np.uint64(len(corner))).tolist():
            g = twin[h]
            if g < 0:
                continue
            s, t = h - h % 3, g - g % 3
            hn, hp, gn, gp = s + (h + 1) % 3, s + (h + 2) % 3, t + (g + 1) % 3, t + (g + 2) % 3
            a, b, c, d = corner[h], corner[g], corner[hp], corner[gp]
            if valence[c] >= 9 or valence[d] >= 9 or valence[a] <= 4 - border[a] or valence[b] <= 4 - border[b]:
                continue
            if not (is_well_shaped(c, a, d) and is_well_shaped(d, b, c)):
                continue
            valence[a], valence[b], valence[c], valence[d] = valence[a] - 1, valence[b] - 1, valence[c] + 1, valence[d] + 1
            outer = twin[hp], twin[gn], twin[gp], twin[hn]  # of c-a, a-d, d-b, b-c
            corner[s:s + 3], corner[t:t + 3] = (c, a, d), (d, b, c)
            for one, other in zip((s, s + 1, t, t + 1, s + 2), (*outer, t + 2)):
                twin[one] = other
                if other >= 0:
                    twin[other] = one

    def shuffled(count):
        places = list(range(count))
        below = (draw(count - 1) % np.arange(count, 1, -1, dtype=np.uint64)).tolist()
        for i, other in zip(range(count - 1, 0, -1), below):
            places[i], places[other] = places[other], places[i]
        return np.array(places)

    to = shuffled(n)
    points = np.zeros((n, 3), np.float32)  # as mesh files have them
    points[to] = plane[:, [0]] * [1, 0, 0] + plane[:, [1]] * [0, 0, 1]
    return points.astype(float), to[np.array(corner)].reshape(-1, 3)[shuffled(len(corner) // 3)]


# ---- Costs -----------------------------------------------------------------------------------------------------------


def memory_bytes(method, particles):
    """Estimated memory of so many particles after set-up and its peak during set-up, rounded up from measurements of this
    study, to know beforehand what fits."""
    held = (250 if METHODS[method] is PBD else 900) * particles
    if METHODS[method] is DENSE:
        held += 2 * particles**2  # a triangle of the matrix in float
    return held, held + (400 if METHODS[method] is PBD else 500) * particles


def available_bytes():
    """Bytes that can be allocated without swapping, as the system and its control group allow."""
    def number(path, key=""):
        try:
            words = pathlib.Path(path).read_text(encoding="utf-8").split()
            return int(words[words.index(key) + 1 if key else 0])
        except (OSError, ValueError):  # a control group without a limit says "max"
            return math.inf

    group = number("/sys/fs/cgroup/memory.max")
    return min(1024 * number("/proc/meminfo", "MemAvailable:"),
               group if group == math.inf else group - number("/sys/fs/cgroup/memory.current"))


def gib(size):
    return f"{size / 2**30:.3g} GiB"


def process_bytes(key):
    """A memory size of this process from Linux: VmRSS, or VmHWM, its peak."""
    words = pathlib.Path("/proc/self/status").read_text(encoding="utf-8").split()
    return 1024 * int(words[words.index(key + ":") + 1])


def resident_bytes():
    """Resident bytes of this process, after freed memory was returned to the system, where the C library can do that."""
    getattr(ctypes.CDLL(None), "malloc_trim", lambda pad: None)(0)
    return process_bytes("VmRSS")


def reset_peak():
    """Sets VmHWM to the present value. Returns whether the system can do it."""
    try:
        pathlib.Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")
    except OSError:
        return False
    return True


def seconds_of(make):
    """The result of make() and the seconds it took."""
    start = time.perf_counter()
    return make(), time.perf_counter() - start


def seconds_a_step(simulation, least):
    """Mean seconds of a step, over at least `least` seconds. Many steps are one call, so that Python takes no part."""
    start, steps, next_steps, elapsed = time.perf_counter(), 0, 1, 0.0
    while elapsed < least:
        simulation.step(next_steps)
        steps += next_steps
        elapsed = time.perf_counter() - start
        next_steps = max(1, math.ceil((least - elapsed) / elapsed * steps))
    return elapsed / steps


def sides(method, quick):
    if quick:
        return (17, 34) if METHODS[method] is DENSE else (17, 46, 100, 142)
    return (17, 46, 100, 141) if METHODS[method] is DENSE else (17, 46, 100, 141, 316, 562, 1000, 2000)


def measured_cost(method, side, quick):
    """The cell of a method and a size: times of steps and of the set-up, and memory by owner and of the process."""
    needs, has = memory_bytes(method, side * side)[1], available_bytes()
    if needs > 0.8 * has:
        return {"left_out": f"it takes {gib(needs)}, and {gib(has)} are free"}
    malha.Simulation(cloth(grid(17), METHODS[method]), threads=1).step()  # loads the code, which is not the body's memory
    scene = malha.Scene(cloth(grid(side), METHODS[method]))
    before, peak_is_known = resident_bytes(), reset_peak()
    setups = []  # short set-ups are repeated
    while len(setups) < (TURNS if setups and setups[0] < 0.3 else 1):
        simulation = None
        simulation, setup = seconds_of(lambda: malha.Simulation(scene, threads=1))
        setups.append(setup)
    simulation.step()
    peak, held = process_bytes("VmHWM"), resident_bytes()
    # All sizes are measured for as long, so that a single interrupt does not distort a small body's time.
    steps = [seconds_a_step(simulation, 0.005 if quick else 0.2) for _ in range(TURNS)]
    report = simulation.report()
    parts = {key: value for key, value in report["setup_s"].items() if key not in ("model", "constraints", "total")}
    owners = {key.removesuffix("_bytes"): value for key, value in report["memory"].items() if key.endswith("_bytes")}
    return {"projections_per_step": simulation.plan().get("projections_a_step", 0), "step_s": statistics.median(steps),
            "step_least_s": min(steps), "step_most_s": max(steps), "setup_s": statistics.median(setups),
            **{f"setup_parts_s_{name}": value for name, value in parts.items() if value > 0},
            "bytes": sum(owners.values()), **{f"bytes_by_owner_{name}": value for name, value in owners.items() if value > 0},
            "held_bytes": held - before, "peak_bytes": peak - before if peak_is_known else None}


# ---- Errors ----------------------------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=None)
def true_rows(frame):
    """Where the rows of the inextensible cloth are after half a second or a second (30 or 60 frames): a function of their
    distance from the pins. Its 100 steps a frame resolve waves over its links of 4 mm."""
    links = 500
    chain = reference.Chain(links, SIDE, G)
    chain.advance(FRAME / 100, 100 * frame)
    at, (up, away) = np.arange(links + 1) * (SIDE / links), chain.joints.T
    return lambda along: (np.interp(along, at, up), np.interp(along, at, away))


def cloth_error(rest, x, frame):
    """RMS distance (m) of a cloth from an inextensible one. rest: its positions at the start."""
    up, away = true_rows(frame)(rest[:, 2])
    return studies.rms_distance(x, np.stack([rest[:, 0], up, away], axis=1))


def hang(scene, error, frames=60):
    """What is measured of a scene after so many steps, or the reason why it is left out. error(rest, x, frame): its RMS
    distance from the truth, m."""
    simulation = malha.Simulation(scene, threads=1)
    rest = simulation.positions
    times = []
    try:
        for frame in range(1, frames + 1):
            times.append(seconds_of(simulation.step)[1])
            if frame == frames // 2:
                half = error(rest, simulation.positions, frame)
        state, x = simulation.measure(), simulation.positions
    except malha.Diverged:
        x = np.array(math.nan)
    if not np.isfinite(x).all():
        return {"left_out": "it diverges"}
    return {"step_ms": 1e3 * statistics.median(times),
            "levels": len(simulation.report().get("levels", {}).get("levels_fine_to_coarse", [])),
            "strain_rms": state["strain_rms"], "strain_max": state["strain_max"],
            "error_half_m": half, "error_m": error(rest, x, frames)}


# Methods of the cloth, with settings of about the same cost: a step with levels takes about twice as long as without, and so
# does one with a refinement or long_range. Each has the setting in words, the substeps (of Desbrun's method: refinements),
# the most particles that are run with it, the solver, and keys of cloth().
HANGING = {
    "PBD": ("20 substeps", 20, 1_000_000, PBD, {}),
    "XPBD": ("20 substeps", 20, 1_000_000, PBD, {"compliance": 1e-6}),  # m/N: a row stretches by at most 5e-6 of its length
    "levels": ("10 substeps", 10, 1_000_000, PBD | {"levels": "auto"}, {}),
    "long_range": ("7 substeps", 7, 100_000, PBD, {"more": ({"type": "long_range"},)}),
    "Desbrun": ("refine 1", 1, 100_000, SPARSE | {"spring_constant": 1e4}, {}),
}
BENDING = {
    "projected": ("10 substeps", {"type": "pbd", "substeps": 10, "bending": "projected"}),
    "filtered": ("10 substeps", {"type": "pbd", "substeps": 10, "bending": "filtered"}),
    "Desbrun": ("1 substep", SPARSE | {"spring_constant": 1e4}),
}
LINE = {"PBD": ("#0072b2", 4), "XPBD": ("#56b4e9", 1.6), "levels": ("#cc79a7", 1.6), "long_range": ("#d55e00", 1.6),
        "Desbrun": ("#009e73", 1.6), "projected": ("#0072b2", 1.6), "filtered": ("#e69f00", 1.6)}  # PBD's and XPBD's coincide
MESHES = {"grid": {"ls": "-", "marker": "o"}, "irregular": {"ls": "--", "marker": "o", "fillstyle": "none"}}
TARGET = 0.01  # the RMS strain whose cost is measured
MOST_SUBSTEPS = 1024


def hanging_scene(method, mesh, side, count):
    _, _, _, solver, more = HANGING[method]
    solver = solver | {"refinement_iterations" if method == "Desbrun" else "substeps": count}
    if mesh == "grid":
        return cloth(grid(side), solver, **more)
    return cloth(malha.shape(*irregular_sheet(side)), solver, elements=("edges",), **more)


def least_work(method, mesh, side):
    """The fewest substeps (or refinements), doubled and then halved in between, that leave an RMS strain of 1 % after 1 s."""
    results = {}

    def reaches_target(count):
        results[count] = hang(hanging_scene(method, mesh, side, count), cloth_error)
        return results[count].get("strain_rms", math.inf) <= TARGET

    first = 0 if method == "Desbrun" else 1
    low, high = first - 1, first
    while high <= MOST_SUBSTEPS and not reaches_target(high):
        low, high = high, max(1, 2 * high)
    if high > MOST_SUBSTEPS:
        return {"left_out": f"more than {MOST_SUBSTEPS} substeps"}
    while high - low > max(1, low // 8):
        middle = (low + high) // 2
        low, high = (low, middle) if reaches_target(middle) else (middle, high)
    result = results[high]
    del result["error_half_m"]
    return {"count": high} | result


def bent_strip(method, cells):
    """The cell of a clamped strip of 1 m x 0.25 m that comes to rest in air as a heavy elastica."""
    density, width, gamma, across = 0.1, 0.25, 10, cells // 4  # kg/m^2, m
    length = 1 - 1 / cells  # its first two rows are clamped
    drag = 2 * 3.5 * density * width / ((across + 1) * (cells + 1))  # N s/m: damps the slowest mode, 3.5 rad/s, critically
    scene = {"name": "cantilever", "duration": 1, "gravity": [0, -G, 0], "wind": {"velocity": [0, 0, 0], "drag": drag},
             "solver": {"dt": FRAME} | BENDING[method][1], "bodies": [{
                 "name": "cantilever", "shape": {"grid": {"size": [width, 1], "cells": [across, cells]}},
                 "mass": density * width, "pins": [{"particles": list(range(2 * (across + 1)))}],
                 "constraints": [{"type": "distance", "elements": ["edges", "shear"], "compliance": 1 / 1e5},
                                 {"type": "bending", "rigidity": density * G * length**3 / gamma}]}]}
    line = length * reference.heavy_elastica(gamma, cells - 1)
    z, y = np.append(0, 1 / cells + line[:, 0]), np.append(0, -line[:, 1])
    truth = np.stack(np.broadcast_arrays(width * np.arange(across + 1) / across, y[:, None], z[:, None]), axis=-1).reshape(-1, 3)
    return hang(scene, lambda rest, x, frame: studies.rms_distance(x, truth), frames=300)


def error_cases(quick):
    """Measures ("error", "work" or "bending"), method, mesh, particles a side or edges along, and particles of each cell."""
    for measures in ("error", "work"):
        for method, (_, _, most, _, _) in HANGING.items():
            for mesh in MESHES:
                if quick:
                    all_sides = (17, 33) if measures == "work" else (17, 46, 80)
                else:  # without levels the substeps needed are some 0.3 of the particles a side: hours for a million
                    million = most >= 1_000_000 and (measures == "error" or method == "levels")
                    all_sides = (17, 46, 100, 316) + (1000,) * million
                for side in all_sides:
                    yield measures, method, mesh, side, side * side
    for method in BENDING:
        for along in (12, 36) if quick else (24, 48, 96, 192):
            yield "bending", method, "grid", along, (along + 1) * (along // 4 + 1)


def key_of_error(case):
    measures, method, mesh, _, particles = case
    setting = (BENDING if measures == "bending" else HANGING)[method][0]
    return f"{'work for 1 %' if measures == 'work' else measures}, {method}, {setting}, {mesh} of {particles:,}"


def measured_error(case):
    measures, method, mesh, side, _ = case
    if measures == "bending":
        return bent_strip(method, side)
    if measures == "work":
        return least_work(method, mesh, side)
    return hang(hanging_scene(method, mesh, side, HANGING[method][1]), cloth_error)


# ---- Sections --------------------------------------------------------------------------------------------------------


def run_rows(rows, **fields):
    """The rows with these fields that were run."""
    return [row for row in rows if not row["left_out"] and all(row.get(key) == value for key, value in fields.items())]


def log_chart(title, horizontal, vertical, ticks):
    """A figure and its axes; sizes are marked at `ticks`."""
    figure, axes = plt.subplots()
    axes.set(title=title, xlabel=horizontal, ylabel=vertical, xscale="log", yscale="log")
    axes.set_xticks(ticks, [f"{tick:,}" for tick in ticks])
    axes.minorticks_off()
    figure.subplots_adjust(left=0.1, right=0.77, top=0.93)
    return figure, axes


def finish(axes, handles=None):
    """Adds the legend, and ticks on the vertical axis, of which a short one needs more than a decade has."""
    low, high = axes.get_ylim()
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 300 * low else (1,)))
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1, 1), fontsize=11)


def add_costs(study, rows):
    """The sections about time, memory and set-up per particle."""
    def ranges(form, value):
        """The first, the smallest and the last value of each method: "PBD, 10 substeps: 80 at 289, 30 at 1,000,000"."""
        lines = []
        for method in METHODS:
            if own := run_rows(rows, method=method):
                ends = [own[0], min(own, key=value), own[-1]]
                shown = [row for k, row in enumerate(ends) if row not in ends[:k]]
                lines.append(f"{method}: " + ", ".join(f"{value(row):{form}} at {row['particles']:,}"
                                                       for row in sorted(shown, key=lambda row: row["particles"])))
        return "; ".join(lines)

    def chart(title, axis, value, bars=None):
        figure, axes = log_chart(title, "particles", axis, [row["particles"] for row in run_rows(rows, method="Desbrun, sparse")])
        for method in METHODS:
            if own := run_rows(rows, method=method):
                x, y = [row["particles"] for row in own], [value(row) for row in own]
                ends = None if bars is None else np.abs([[bars(row)[k] - value(row) for row in own] for k in (0, 1)])
                axes.errorbar(x, y, yerr=ends, capsize=3, marker=MARKS[method], color=COLOURS[method], label=method)
        finish(axes)
        return figure

    def time_of(row):
        return 1e9 * row["step_s"] / row["particles"]

    def bytes_of(row, key="bytes"):
        return "-" if row[key] is None else row[key] / row["particles"]

    def setup_of(row):
        return 1e6 * row["setup_s"] / row["particles"]

    left_out = "".join(f" {row['method']} with {row['particles']:,} particles is left out: {row['left_out']}."
                       for row in rows if row["left_out"])
    own = run_rows(rows)
    study.section(
        "Time per particle", [f"ns a particle and step of 1/60 s on one thread: {ranges('.3g', time_of)}.{left_out}"],
        ["method", "particles", "ms a step", "least", "most", "ns a particle", "ns a projection", "steps of 1/60 s in real time"],
        [[row["method"], f"{row['particles']:,}", *(1e3 * row[key] for key in ("step_s", "step_least_s", "step_most_s")),
          f"{time_of(row):.3g}",
          f"{1e9 * row['step_s'] / row['projections_per_step']:.3g}" if row["projections_per_step"] else "-",
          f"{FRAME / row['step_s']:.3g}"] for row in own],
        ("time", chart(f"A hanging cloth: time a particle, one thread (bars: least and most of {TURNS} turns)",
                       "ns a particle and step", time_of,
                       lambda row: [1e9 * row[key] / row["particles"] for key in ("step_least_s", "step_most_s")])))

    sentences = [f"Bytes a particle, summed over all owners: {ranges('.4g', bytes_of)}."]
    largest = [run_rows(rows, method=method)[-1] for method in METHODS if run_rows(rows, method=method)]
    grown = "; ".join(f"{row['method']} by {bytes_of(row, 'held_bytes'):.4g}, and by {bytes_of(row, 'peak_bytes'):.4g} at most "
                      "while it was set up" for row in largest if row["peak_bytes"] is not None)
    if grown:
        sentences.append(f"With the most particles the process grew, bytes a particle: {grown}.")
    for row in largest:
        owners = ", ".join(f"{key.removeprefix('bytes_by_owner_')} {value / row['particles']:.3g}" for key, value in row.items()
                           if key.startswith("bytes_by_owner_"))
        sentences.append(f"{row['method']} at {row['particles']:,}: {owners}.")
    study.section(
        "Memory per particle", sentences,
        ["method", "particles", "MiB", "bytes a particle", "the process grew by", "at most, in set-up"],
        [[row["method"], f"{row['particles']:,}", row["bytes"] / 2**20,
          *(bytes_of(row, key) for key in ("bytes", "held_bytes", "peak_bytes"))] for row in own],
        ("memory", chart("A hanging cloth: memory a particle", "bytes a particle", bytes_of)))
    study.section(
        "Set-up time per particle", [f"Microseconds a particle on one thread: {ranges('.3g', setup_of)}."],
        ["method", "particles", "s", "microseconds a particle", "steps that take as long"],
        [[row["method"], f"{row['particles']:,}", f"{row['setup_s']:.3g}", f"{setup_of(row):.3g}",
          f"{row['setup_s'] / row['step_s']:.3g}"] for row in own],
        ("setup", chart("A hanging cloth: set-up a particle, one thread", "microseconds a particle", setup_of)))


def add_errors(study, rows):
    """The sections about errors over the number of particles, and the cost of a given error."""
    def time_of(row):
        return 1e6 * row["step_ms"] / row["particles"]

    def ranges(measures, mesh, form, value):
        """The values at the first and the last side: "levels 0.0025 at 17, 0.0035 at 316"."""
        lines = []
        for method in BENDING if measures == "bending" else HANGING:
            if own := run_rows(rows, measures=measures, method=method, mesh=mesh):
                lines.append(f"{method} " + ", ".join(f"{value(row):{form}} at {row['side']}" for row in
                                                      (own[:1] if len(own) == 1 else (own[0], own[-1]))))
        return "; ".join(lines)

    def chart(measures, title, axis, value):
        bends = measures == "bending"
        figure, axes = log_chart(title, "edges along" if bends else "particles a side (irregular: square root of their number)",
                                 axis, sorted({row["side"] for row in run_rows(rows, measures=measures)}))
        handles = []
        for method, (setting, *_) in (BENDING if bends else HANGING).items():
            colour, width = LINE[method]
            handles.append(Line2D([], [], color=colour, lw=width, label=method if measures == "work" else f"{method}, {setting}"))
            for mesh, style in MESHES.items():
                if own := run_rows(rows, measures=measures, method=method, mesh=mesh):
                    axes.plot([row["side"] for row in own], [value(row) for row in own], color=colour, lw=width, **style)
        if not bends:
            handles += [Line2D([], [], color="#555555", label=name, **style) for name, style in
                        zip(("grids", "irregular triangles"), MESHES.values())]
        finish(axes, handles)
        return figure

    def table(measures, columns):
        """Fields of the rows of a kind; those that were left out have the reason."""
        lines = []
        for row in rows:
            if row["measures"] != measures:
                continue
            line = [row["method"], row["mesh"], row["side"]]
            fields = [f"{time_of(row):.3g}" if key == "time" else row.get(key) for key in columns] if not row["left_out"] else [
                row["left_out"]] + ["-"] * (len(columns) - 1)
            lines.append(line + [f"{field:.3g}" if isinstance(field, float) else field for field in fields])
        return lines

    def strain(row):
        return row["strain_rms"]

    def error(row):
        return row["error_m"]

    columns = ["time", "levels", "strain_rms", "strain_max", "error_half_m", "error_m"]
    study.section(
        "How much a hanging cloth stretches, at about the same cost",
        ["RMS strain of a cloth of 2 m and 1 kg, pinned at a row, 1 s after its release from the horizontal, by particles a "
         f"side: {ranges('error', 'grid', '.2g', strain)}.",
         f"Irregular triangles: {ranges('error', 'irregular', '.2g', strain)}.",
         f"ns a particle and step of 1/60 s on one thread, grids: {ranges('error', 'grid', '.3g', time_of)}."],
        ["method", "mesh", "a side", "ns a particle", "levels", "RMS strain", "largest strain", "m off after 0.5 s",
         "m off after 1 s"], table("error", columns),
        ("strain", chart("error", "A hanging cloth after 1 s: its strain, at about the same cost", "RMS strain", strain)))
    study.section(
        "How far off a hanging cloth is, at about the same cost",
        ["The reference is an inextensible cloth: its rows move as the joints of a chain (SHAKE, in double, 500 links). RMS "
         f"distance to it after 1 s, m: {ranges('error', 'grid', '.2g', error)}.",
         f"Irregular triangles: {ranges('error', 'irregular', '.2g', error)}."],
        chart=("error", chart("error", "A hanging cloth after 1 s: distance to one that does not stretch, at about the same cost",
                              "RMS distance to the truth, m", error)))
    study.section(
        "What a strain of 1 % costs",
        ["Time of the fewest substeps (Desbrun: refinements of one substep) that leave an RMS strain of 1 % after 1 s, in ns a "
         f"particle and step: {ranges('work', 'grid', '.3g', time_of)}.",
         f"Irregular triangles: {ranges('work', 'irregular', '.3g', time_of)}."],
        ["method", "mesh", "a side", "substeps or refinements", "levels", "ns a particle", "RMS strain", "largest strain",
         "m off after 1 s"], table("work", ["count", "levels", "time", "strain_rms", "strain_max", "error_m"]),
        ("work", chart("work", "A hanging cloth after 1 s: what an RMS strain of 1 % costs", "ns a particle and step", time_of)))
    study.section(
        "How far off a clamped strip is that bends under its weight",
        ["The cantilever of the study accuracy, a heavy elastica of Gamma 10, after 5 s in air. PBD projects or filters its "
         "bending, with levels where they help. RMS distance to the elastica, m, by edges along: "
         f"{ranges('bending', 'grid', '.2g', error)}.",
         f"ns a particle and step of 1/60 s on one thread: {ranges('bending', 'grid', '.3g', time_of)}."],
        ["method", "mesh", "edges along", "ns a particle", "levels", "RMS strain", "largest strain", "m off after 2.5 s",
         "m off after 5 s"], table("bending", columns),
        ("bending", chart("bending", "A clamped strip at rest under its weight: distance to the heavy elastica",
                          "RMS distance to the truth, m", error)))


def measure(study):
    costs = [(method, side) for method in METHODS for side in sides(method, study.quick)]
    errors = list(error_cases(study.quick))
    study.plan(len(costs) + len(errors))
    cost_cells = study.cells(costs, lambda case: f"{case[0]}, {case[1]**2:,} particles",
                             lambda case: measured_cost(*case, study.quick))
    error_cells = study.cells(errors, key_of_error, measured_error)
    if study.partial:
        return
    for (method, side), cell in zip(costs, cost_cells):
        study.row(method=method, side=side, particles=side * side, **{"left_out": None} | cell)
    add_costs(study, study.rows[:])
    for (measures, method, mesh, side, particles), cell in zip(errors, error_cells):
        study.row(measures=measures, method=method, mesh=mesh, side=side, particles=particles, **{"left_out": None} | cell)
    add_errors(study, study.rows[len(costs):])


if __name__ == "__main__":
    studies.main("size", "Time, memory and set-up per particle, and errors, from 289 particles to 4 million", measure)
