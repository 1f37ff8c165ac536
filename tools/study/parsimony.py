# SPDX-License-Identifier: Apache-2.0
"""Time, memory and kernel launches that each feature adds to a scene.

A feature that a scene does not use should cost it nothing, and one that it uses no more than its work. Each feature is
added alone to the smallest scene that can have it, and then all of them one after the other to a cloth (the ladder).

    PYTHONPATH=build/release /usr/bin/python3 tools/study/parsimony.py --quick

A feature that is measured is a line of single_features(): its name, and how it changes a scene.
"""
import copy
import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402

BEFORE, MEASURED = 30, 20  # steps; the cloth then has swung down onto its ball
OWNERS = ("particles", "constraints", "air", "patches", "springs", "filter", "collision", "model", "levels")  # of memory
# Passes that the chart of the ladder shows as one part of a bar.
PARTS = {"prediction, projection, state": ("fused_solve", "prediction", "projection", "state"), "air": ("air",),
         "damping": ("damping",), "reach, pins, attachments, sleep": ("long_range", "pins", "attachments", "sleep"),
         "environment": ("collision", "contact")}


# ---- Scenes ----------------------------------------------------------------------------------------------------------

DISTANCE = {"type": "distance", "elements": ["edges"]}


def body(shape, mass, *constraints):
    """The scene of a body. Levels are off, because they are one of the features to be added."""
    return {"name": "parsimony", "duration": 1, "gravity": [0, -9.81, 0], "solver": {"type": "pbd", "levels": "off"},
            "bodies": [{"name": "body", "shape": shape, "mass": mass, "constraints": list(constraints)}]}


def cloth(cells, *constraints):
    """A cloth that is pinned at one side and swings down from the horizontal."""
    return changed(body({"grid": {"size": [1, 1], "cells": [cells, cells]}}, 0.2, *constraints),
                   lambda scene, body: body.update(pins=[{"row": "first"}]))


def changed(scene, change):
    """The scene with a feature: change(scene, its body) adds it to a copy."""
    scene = copy.deepcopy(scene)
    change(scene, scene["bodies"][0])
    return scene


def add(type, **keys):
    return lambda scene, body: body["constraints"].append({"type": type} | keys)


def add_ball(y, friction=0):
    """A ball below the cloth; at y = -5 it is out of reach."""
    ball = {"name": "ball", "shape": {"sphere": {"radius": 0.3, "subdivisions": 3}}, "friction": friction,
            "transform": {"translate": [0.5, y, 0.5]}}
    return lambda scene, body: scene.update(environment=[ball])


def blow(**keys):
    return lambda scene, body: scene.update(wind={"velocity": [0, 0, 2]} | keys)


def move_pins(scene, body):
    body["pins"][0]["motion"] = [{"time": 0, "translate": [0, 0, 0]}, {"time": 10, "translate": [0, 0, 1]}]


def attach(scene, body):
    """Attaches the last row to where it is at the start."""
    body["attachments"] = [{"at": {"row": "last"}, "compliance": 0.1}]


def damp(scene, body):
    body["damping"] = 0.05


def sleep(speed, after):
    return lambda scene, body: scene.update(sleep={"speed": speed, "after": after})


def collide_with_itself(scene, body):
    scene["self_collision"] = {"thickness": 0.2 / body["shape"]["grid"]["cells"][0]}  # a fifth of an edge


def solve(**keys):
    return lambda scene, body: scene["solver"].update(keys)


def by_desbrun(refinement):
    solver = {"type": "desbrun", "substeps": 1, "filter": "sparse", "refinement_iterations": refinement}
    return lambda scene, body: scene.update(solver=solver)


LONG_RANGE = add("long_range", limit=0.02)
TOUCHED = -0.298  # y of the ball that the cloth slides over


def single_features(quick):
    """(feature, name of the scene that it is added to, scene without it, scene with it) of each feature alone. The first one
    adds nothing, and shows by how much the times of the same scene differ."""
    cells, side = (31, 9) if quick else (99, 21)
    plain = cloth(cells, DISTANCE)
    closed = body({"sphere": {"radius": 0.5, "subdivisions": 3 if quick else 5}}, 0.5, DISTANCE)
    solid = body({"tet_box": {"size": [1, 1, 1], "cells": [side, side, side]}}, 1)
    free = changed(plain, lambda scene, body: body.pop("pins"))
    to_cloth = {
        "nothing": lambda scene, body: None,
        "distance on diagonals": lambda scene, body: body["constraints"][0].update(elements=["edges", "shear"]),
        "compliance": lambda scene, body: body["constraints"][0].update(compliance=1e-6),
        "distance_limit": add("distance_limit", elements=["edges"], limit=0.1),
        "bending": add("bending", stiffness=0.1),
        "isometric_bending": add("isometric_bending", stiffness=0.1),
        "drag on particles": blow(drag=1e-6),
        "air on faces": blow(density=1.2),
        "damping": damp,
        "long_range": LONG_RANGE,
        "levels": solve(levels=30),
        "moved pins": move_pins,
        "attachments": attach,
        "environment (out of reach)": add_ball(-5),
        "environment (touched)": add_ball(TOUCHED),
        "self-collision (flat)": collide_with_itself,
        "tear (not reached)": lambda scene, body: body.update(tear={"strain": 1e6}),  # only the checks cost time
        "sleep (awake)": sleep(1e-9, 0.5),  # likewise
        "sleep (asleep)": sleep(1e9, 0),
        "double": solve(precision="double")}
    more = {  # the feature before which it is shown, the scene that it is added to, and its name
        "distance on edges": ("distance on diagonals", cloth(cells), "particles", add(**DISTANCE)),
        "corrector": ("long_range", free, "free cloth", solve(corrector="inertia")),
        "friction": ("self-collision (flat)", changed(plain, add_ball(TOUCHED)), "cloth on a ball", add_ball(TOUCHED, 0.5)),
        "pressure": (None, closed, "closed surface", add("pressure")),
        "volume": (None, solid, "tetrahedra without constraints", add("volume")),
        "neo_hookean": (None, solid, "tetrahedra without constraints", add("neo_hookean", young_modulus=1e4, poisson_ratio=0.4)),
        "refine = 1": (None, changed(plain, by_desbrun(0)), "springs by Desbrun, sparse", by_desbrun(1))}
    features = []
    for name in [*to_cloth, None]:
        features += [(feature, base, scene, changed(scene, change))
                     for feature, (before, scene, base, change) in more.items() if before == name]
        if name:
            features.append((name, "cloth", plain, changed(plain, to_cloth[name])))
    return features


def feature_ladder(quick):
    """The same of a cloth with more and more features: every rung has the features of all rungs before it."""
    scene, base, rungs = cloth(31 if quick else 99), "particles", []
    for feature, change in (("distance", add(**DISTANCE)), ("+ bending", add("bending", stiffness=0.1)),
                            ("+ air on faces", blow(density=1.2)), ("+ damping", damp), ("+ long_range", LONG_RANGE),
                            ("+ moved pins", move_pins), ("+ attachments", attach), ("+ environment", add_ball(TOUCHED)),
                            ("+ friction", add_ball(TOUCHED, 0.5)), ("+ sleep", sleep(1e-9, 0.5)),
                            ("+ self-collision", collide_with_itself)):
        rungs.append((feature, base, scene, changed(scene, change)))
        base, scene = feature, rungs[-1][3]
    return rungs


# ---- Measuring -------------------------------------------------------------------------------------------------------


def pass_ms(simulation):
    """The time of each pass since the start, ms."""
    timing = simulation.report()["timing"]
    return {name.removesuffix("_ms"): ms * timing["steps"] for name, ms in timing["step_ms_by_pass"].items()}


def measured(scenes, quick):
    """Times, bytes and launches of a step of each scene, on one thread.

    The scenes run in turns, step by step, so that other load of the machine affects them alike, and repeatedly through the
    same simulated period. Times are medians of processor time over the steps, and passes their shares of it; bytes and
    launches are those of a further step. added_ms: the median difference to the scene before in the same turn.
    """
    ms, passes = [[] for _ in scenes], [{} for _ in scenes]
    for _ in range(1 if quick else 12):
        runs = [malha.Simulation(scene, threads=1) for scene in scenes]
        for run in runs:
            run.step(BEFORE)
        before = [pass_ms(run) for run in runs]
        for _ in range(MEASURED):
            for run, times in zip(runs, ms):
                start = time.thread_time()
                run.step()
                times.append(1e3 * (time.thread_time() - start))
        for run, old, sums in zip(runs, before, passes):
            for name, spent in pass_ms(run).items():
                sums[name] = sums.get(name, 0) + spent - old.get(name, 0)
        if sum(map(sum, ms)) > 500 * len(scenes):
            break
    all_facts = []
    for k, run in enumerate(runs):
        launches = run.trace_step()
        memory = run.report()["memory"]
        median, sums = statistics.median(ms[k]), passes[k]
        all_facts.append({
            "particles": len(run.positions), "ms_a_step": median,
            "passes_ms": {name: spent / sum(sums.values()) * median for name, spent in sums.items() if spent > 1e-6},
            "bytes": {owner: memory.get(f"{owner}_bytes", 0) for owner in OWNERS},
            "launches": {one["kernel"]: one["launches"] for one in launches},
            "added_ms": statistics.median(own - other for own, other in zip(ms[k], ms[max(k - 1, 0)]))})
    return all_facts


def added_launches(own, other):
    """The launches of `own` beyond those of `other`: "Predict<float> 10, UpdateState<float> 10"."""
    return ", ".join(f"{kernel} {count - other.get(kernel, 0)}" for kernel, count in own.items() if count > other.get(kernel, 0))


def add_row(study, kind, feature, base, without, own):
    all_bytes, before = own["bytes"], without["bytes"]
    study.row(kind=kind, feature=feature, base=base, particles=own["particles"], ms_a_step=own["ms_a_step"],
              ms_a_step_without=without["ms_a_step"], added_ms=own["added_ms"],
              added_percent=100 * own["added_ms"] / without["ms_a_step"], bytes=sum(all_bytes.values()),
              added_bytes=sum(all_bytes.values()) - sum(before.values()),
              launches_a_step=sum(own["launches"].values()), launches_a_step_without=sum(without["launches"].values()),
              kernels=added_launches(own["launches"], {}), kernels_added=added_launches(own["launches"], without["launches"]),
              kernels_gone=added_launches(without["launches"], own["launches"]),
              **{f"pass_{name}_ms": ms for name, ms in own["passes_ms"].items()},
              **{f"{owner}_bytes": count for owner, count in all_bytes.items()},
              **{f"{owner}_bytes_added": count - before[owner] for owner, count in all_bytes.items()},
              **studies.machine(own))


# ---- Sections --------------------------------------------------------------------------------------------------------


def names(rows, belongs, say=lambda row: row["feature"]):
    """The features of the rows that belong to a list, but "nothing"; "none" if there are none."""
    return ", ".join(say(row) for row in rows if row["feature"] != "nothing" and belongs(row)) or "none"


def bars(rows, values, least, title, words, colour):
    """A chart of a bar for each row, the first on top, with its value beside it. Values below `least` have no bar."""
    figure, axes = plt.subplots(figsize=(11, 0.6 + 0.32 * len(rows)))
    axes.barh([row["feature"] for row in rows], [max(value, least) for value in values], log=True, color=colour)
    for number, value in enumerate(values):
        axes.text(max(value, least), number, f" {value:+.3g}", va="center", fontsize=9, color="#444444")
    axes.set(xlabel=words, title=title, xlim=(least, 2 * max(values)), ylim=(len(rows) - 0.4, -0.6))
    axes.grid(axis="y", visible=False)
    return figure, axes


def time_section(study, rows):
    whole = rows[0]["ms_a_step_without"]
    by_cost = sorted(rows, key=lambda row: row["added_percent"])
    say = lambda row: f"{row['feature']} {row['added_percent']:+.0f} %"  # noqa: E731
    figure, axes = bars(rows, [row["added_ms"] for row in rows], whole / 100, "Each feature alone: time added to a step",
                        "added ms a step", studies.COLOURS[0])
    axes.axvline(whole, color=studies.COLOURS[1], ls="--", zorder=0, label="the whole step of the cloth")
    axes.legend(loc="lower right")
    figure.tight_layout()
    study.section(
        "What each feature adds to a step",
        [f"A cloth of {rows[0]['particles']} particles with distances along its edges takes {whole:.3g} ms a step (10 substeps of "
         "1 iteration, one thread, processor time); two simulations of this scene, in turns, differ by "
         f"{abs(rows[0]['added_percent']):.2g} %.",
         f"Features that add less than a tenth of the scene's time: {names(by_cost, lambda row: row['added_percent'] < 10, say)}.",
         f"Features that add more than twice the scene's time: {names(by_cost, lambda row: row['added_percent'] > 200, say)}."],
        ["feature", "added to", "particles", "ms without", "ms with", "added ms", "added %"],
        [[row["feature"], row["base"], row["particles"], row["ms_a_step_without"], row["ms_a_step"], f"{row['added_ms']:+.3g}",
          f"{row['added_percent']:+.1f}"] for row in rows], ("time", figure))


def memory_section(study, rows):
    first = rows[0]
    by_owner = lambda row, end, form: ", ".join(  # noqa: E731
        f"{owner} {row[owner + end] / row['particles']:{form}}" for owner in OWNERS if row[owner + end])
    figure, _ = bars(rows, [row["added_bytes"] / row["particles"] for row in rows], 0.01, "Each feature alone: memory added",
                     "added bytes a particle", studies.COLOURS[2])
    figure.tight_layout()
    study.section(
        "What each feature adds to memory",
        [f"Bytes a particle of the cloth with distance constraints only: {by_owner(first, '_bytes', '.3g')}. Memory that Embree "
         "allocates is not counted.",
         f"Features that add no memory: {names(rows, lambda row: row['added_bytes'] == 0)}."],
        ["feature", "added to", "added bytes a particle", "of them"],
        [[row["feature"], row["base"], f"{row['added_bytes'] / row['particles']:+.4g}", by_owner(row, "_bytes_added", "+.3g")]
         for row in rows], ("memory", figure))


def launch_section(study, rows):
    split = lambda row: ", Predict<" in ", " + row["kernels_added"]  # noqa: E731
    study.section(
        "What each feature launches",
        [f"The cloth with distance constraints only launches in a step: {rows[0]['kernels']}, and nothing else.",
         f"Features that add no launch: {names(rows, lambda row: not row['kernels_added'])}.",
         "Features that work between prediction and velocity update, which therefore run as separate launches instead of within "
         f"the patch solve: {names(rows, split)}."],
        ["feature", "added to", "launches without", "with", "kernels added", "kernels gone"],
        [[row["feature"], row["base"], row["launches_a_step_without"], row["launches_a_step"], row["kernels_added"],
          row["kernels_gone"]] for row in rows])


def ladder_section(study, rows):
    first, before, last = rows[0], rows[-2], rows[-1]
    figure, axes = plt.subplots(figsize=(11, 5.4))
    left = [0.0] * (len(rows) - 1)  # the last rung, which would dwarf all others, is only named in the title
    for title, passes in PARTS.items():
        ms = [sum(row.get(f"pass_{name}_ms", 0) for name in passes) for row in rows[:-1]]
        if any(ms):
            axes.barh([row["feature"] for row in rows[:-1]], ms, left=left, label=title)
        left = [start + part for start, part in zip(left, ms)]
    axes.set(xlabel="ms a step", ylim=(len(rows) - 1.4, -0.6),
             title=f"A cloth with more and more features ({last['feature']}: {last['ms_a_step']:.3g} ms, off the chart)")
    axes.grid(axis="y", visible=False)
    axes.legend(loc="upper right")
    figure.tight_layout()
    a_particle = [row["bytes"] / row["particles"] for row in rows]
    study.section(
        "A cloth with more and more features",
        [f"From {first['ms_a_step']:.3g} ms a step with distance constraints only to {before['ms_a_step']:.3g} ms with everything but "
         f"self-collision, and {last['ms_a_step']:.3g} ms with self-collision too; from {a_particle[0]:.0f} to {a_particle[-2]:.0f} "
         f"and {a_particle[-1]:.0f} bytes a particle; from {first['launches_a_step']} to {before['launches_a_step']} and "
         f"{last['launches_a_step']} launches a step."],
        ["scene", "ms a step", "bytes a particle", "launches a step", "ms by pass"],
        [[row["feature"], row["ms_a_step"], row["bytes"] / row["particles"], row["launches_a_step"],
          ", ".join(f"{key[5:-3]} {value:.3g}" for key, value in row.items() if key.startswith("pass_"))] for row in rows],
        ("ladder", figure))


def measure(study):
    singles, ladder = single_features(study.quick), feature_ladder(study.quick)
    study.plan(len(singles) + 1)
    pairs = study.cells(singles, lambda single: f"{single[1]}, {single[0]}", lambda single: measured(single[2:], study.quick))
    rungs = study.cell("ladder", lambda: measured([ladder[0][2], *(rung[3] for rung in ladder)], study.quick))
    if study.partial:
        return
    for (feature, base, *_), (without, own) in zip(singles, pairs):
        add_row(study, "single", feature, base, without, own)
    for (feature, base, *_), without, own in zip(ladder, rungs, rungs[1:]):
        add_row(study, "ladder", feature, base, without, own)
    rows = {kind: [row for row in study.rows if row["kind"] == kind] for kind in ("single", "ladder")}
    time_section(study, rows["single"])
    memory_section(study, rows["single"])
    launch_section(study, rows["single"])
    ladder_section(study, rows["ladder"])


if __name__ == "__main__":
    studies.main("parsimony", "Time, memory and kernel launches that each feature adds to a scene", measure)
