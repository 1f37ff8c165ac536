# SPDX-License-Identifier: Apache-2.0
"""Published results, repeated with the papers' parameters, beside malha's.

Each case is one paper: a function that requests its cells (REQUEST), and one that shows them beside what is printed (SHOW).

    PYTHONPATH=build/release /usr/bin/python3 tools/study/published.py --quick

References are backward Euler by Newton's method and XPBD as printed in its paper, link after link; both are written here and
share nothing with malha. All their chains move in a plane, whose points and vectors are complex numbers: x + i y.
"""
import math
import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402

import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

PARTICLES, LINKS = 20, 19  # of all chains


def percent(part):
    return f"{100 * part:.3g} %"


def scene_of(body, dt, substeps, iterations, gravity=9.81):
    """A scene of one body by PBD in double. It has no levels, because the papers have none."""
    solver = {"type": "pbd", "dt": dt, "substeps": substeps, "iterations": iterations, "precision": "double", "levels": "off"}
    return {"name": body["name"], "solver": solver, "gravity": [0, -gravity, 0], "bodies": [body], "duration": 1}


# ---- References ------------------------------------------------------------------------------------------------------


def chain_of(mass, spacing, compliance, direction, gravity):
    """A chain that starts at rest, from the pinned particle at 0 along `direction`.

    mass: kg of each particle. spacing: m. compliance: m/N of each link. direction, gravity (m/s^2): complex numbers.
    """
    return {"inverse": [0.0] + [1 / m for m in mass[1:]], "rest": [spacing] * (len(mass) - 1), "compliance": compliance,
            "gravity": gravity, "start": [i * spacing * direction for i in range(len(mass))]}


def sweep(chain, h, iterations, x, v):
    """A step of h (s) by XPBD as in algorithm 1 of its paper: sweeps over the links from the support on, in their order.

    x, v: positions and velocities, lists of complex numbers. Returns the new ones. One iteration is a substep of the paper
    of 2019.
    """
    inverse, rest, alpha = chain["inverse"], chain["rest"], chain["compliance"] / (h * h)
    predicted = [speed + h * chain["gravity"] if w else speed for speed, w in zip(v, inverse)]
    new = [at + h * speed for at, speed in zip(x, predicted)]
    multipliers = [0.0] * len(rest)
    for _ in range(iterations):
        for k, length_at_rest in enumerate(rest):
            along, wi, wj = new[k] - new[k + 1], inverse[k], inverse[k + 1]
            length = abs(along)
            change = (length_at_rest - length - alpha * multipliers[k]) / (wi + wj + alpha)
            multipliers[k] += change
            new[k] += wi * change / length * along
            new[k + 1] -= wj * change / length * along
    return new, [(after - before) / h for after, before in zip(new, x)]


def newton(chain, h, x, v):
    """A step of h (s) of backward Euler, x' = x + h v', v' = v + h a(x'), by Newton's method, until a move is below 1e-12
    of the chain's size. Arguments and result are those of sweep()."""
    def plane(numbers):
        return np.array(numbers, dtype=complex).view(float).reshape(-1, 2)

    start, rest, k = plane(x), np.array(chain["rest"]), np.arange(len(chain["rest"]))
    mass = 1 / np.array(chain["inverse"])[1:, None]
    new = start + h * plane(v)
    inertial = new + h * h * plane([chain["gravity"]])
    for _ in range(50):
        along = np.diff(new, axis=0)
        length = np.linalg.norm(along, axis=1)
        across, stiffness = 1 - rest / length, h * h / chain["compliance"]
        residual = stiffness * across[:, None] * along  # of the particle at the far end of each link
        residual[:-1] -= residual[1:].copy()
        residual += mass * (new - inertial)[1:]
        unit = along / length[:, None]
        projector = unit[:, :, None] * unit[:, None, :]
        K = stiffness * (projector + across[:, None, None] * (np.eye(2) - projector))
        H = np.zeros((len(rest), 2, len(rest), 2))  # the Hessian, without the pinned particle
        H[k, :, k, :] += K + mass[:, :, None] * np.eye(2)
        H[k[:-1], :, k[:-1], :] += K[1:]
        H[k[1:], :, k[:-1], :] -= K[1:]
        H[k[:-1], :, k[1:], :] -= K[1:]
        move = np.linalg.solve(H.reshape(2 * len(rest), -1), residual.ravel()).reshape(-1, 2)
        new[1:] -= move
        if np.abs(move).max() < 1e-12 * np.abs(new).max():
            return (new @ [1, 1j]).tolist(), ((new - start) / h @ [1, 1j]).tolist()
    raise ArithmeticError("Newton's method has not converged in 50 iterations")


# ---- XPBD 2016, section 6.1: an oscillator ---------------------------------------------------------------------------
# The spring has the rest length 1, the initial length 1.5, the mass 1 and the compliance 0.001. The paper's figure 2 compares
# curves and states neither numbers nor the step; here it is 1/60 s.


COMPLIANCE = 0.001
OMEGA = math.sqrt(1 / COMPLIANCE)


def backward_euler_period(dt):
    return 2 * np.pi * dt / math.atan(OMEGA * dt)


def period_and_damping(a, dt):
    """The period and what is left of the amplitude after one; None for both where the motion does not oscillate.

    a: the elongation after each step, which obeys a(n+1) = p a(n) + q a(n-1) exactly. Least squares yield p and q.
    """
    aa = ab = bb = ay = by = 0.0
    for old, now, new in zip(a, a[1:], a[2:]):
        aa, ab, bb, ay, by = aa + now * now, ab + now * old, bb + old * old, ay + new * now, by + new * old
    p, q = (ay * bb - by * ab) / (aa * bb - ab * ab), (by * aa - ay * ab) / (aa * bb - ab * ab)
    shrinks = math.sqrt(-q) if q < 0 else 0
    if not shrinks or abs(p / 2 / shrinks) >= 1:
        return None, None
    steps = 2 * np.pi / math.acos(p / 2 / shrinks)
    return steps * dt, shrinks**steps


def run_spring(setting):
    body = {"name": "spring", "shape": {"chain": {"from": [0, 0, 0], "to": [1.5, 0, 0], "segments": 1}}, "mass": 2,  # 1 kg each
            "pins": [{"particles": [0]}],
            "constraints": [{"type": "distance", "elements": ["edges"], "rest_scale": 1 / 1.5} | setting["constraint"]]}
    dt = 1 / 60 / setting["substeps"]  # substeps are steps, so that each is recorded
    simulation = malha.Simulation(scene_of(body, dt, 1, setting["iterations"], gravity=0), threads=1)
    a = [0.5]
    for _ in range(60 * setting["substeps"]):
        simulation.step()
        a.append(simulation.positions[1, 0] - 1)
    period, left = period_and_damping(a, dt)
    return {"period_s": period, "left_after_a_period": left, "a_m": a}


def spring_settings(quick):
    """XPBD, and PBD of 2006, which leaves (1 - k) of an error per projection. malha's stiffness is that of all projections of
    a step together."""
    def setting(what, constraint, substeps, iterations):
        return {"what": what, "constraint": constraint, "substeps": substeps, "iterations": iterations}

    xpbd, counts = {"compliance": COMPLIANCE}, (1, 5, 10)
    return ([setting("XPBD, " + studies.counted(n, "iteration"), xpbd, 1, n) for n in counts] +
            [setting(f"XPBD, {n} substeps", xpbd, n, 1) for n in ([10] if quick else [10, 100])] +
            [setting("PBD, k = 0.1, " + studies.counted(n, "iteration"), {"stiffness": 1 - 0.9**n}, 1, n) for n in counts])


def request_springs(study):
    settings = spring_settings(study.quick)
    return list(zip(settings, study.cells(settings, lambda setting: "spring: " + setting["what"], run_spring)))


def show_springs(study, springs):
    exact = 2 * np.pi / OMEGA
    table = [["closed form", f"{exact:.5f}", "", "1"]]
    figure, panels = plt.subplots(1, 2, sharey=True)
    time_s = np.linspace(0, 0.6, 601)
    for panel, title in zip(panels, ("XPBD", "PBD")):
        panel.plot(time_s, 1 + 0.5 * np.cos(OMEGA * time_s), color="black", label="closed form")
        panel.set(title=f"{title}, steps of 1/60 s", xlabel="time (s)", xlim=(0, 0.6))
    panels[0].set_ylabel("length (m)")
    xpbd, pbd = [], []
    for setting, cell in springs:
        dt, period = 1 / 60 / setting["substeps"], cell["period_s"]
        euler = backward_euler_period(dt)
        study.row(case="spring of 2016", what=setting["what"], substeps=setting["substeps"], iterations=setting["iterations"],
                  period_s=period, left_after_a_period=cell["left_after_a_period"], exact_period_s=exact,
                  backward_euler_period_s=euler, **studies.machine(cell))
        is_xpbd = "compliance" in setting["constraint"]
        (xpbd if is_xpbd else pbd).append((setting, period, euler))
        table.append([setting["what"], "none" if period is None else f"{period:.5f}", f"{euler:.5f}" if is_xpbd else "",
                      "none" if period is None else f"{cell['left_after_a_period']:.3f}"])
        if setting["substeps"] < 100:
            curve = len(xpbd if is_xpbd else pbd) - 1  # XPBD's first three coincide: smaller marks lie on larger ones
            panels[0 if is_xpbd else 1].plot(dt * np.arange(len(cell["a_m"])), 1 + np.array(cell["a_m"]), lw=1,
                                             label=setting["what"].split(", ", 1)[1], color=studies.COLOURS[curve],
                                             marker="osD,"[curve], markersize=(10, 6.5, 3, 1)[curve] if is_xpbd else 5)
    for panel in panels:
        panel.legend(loc="upper right", ncol=2, fontsize=10)
    panels[0].set_ylim(0.45, 1.85)
    figure.subplots_adjust(left=0.08, right=0.98, top=0.93, wspace=0.09)
    apart = max(abs(period / exact - 1) for setting, period, _ in xpbd if setting["substeps"] == 1)
    study.section(
        "XPBD 2016, section 6.1: an oscillator",
        [f"The period is {exact:.5f} s in closed form. The paper prints curves and no number: XPBD's period does not depend on "
         "the iterations, PBD's does.",
         f"malha: the error of XPBD with 1, 5 and 10 iterations is {100 * apart:.2g} % for all of them, because it is that of "
         f"backward Euler, whose period agrees to {max(abs(period / euler - 1) for _, period, euler in xpbd):.1e}; with the "
         f"finest substeps it is {100 * (xpbd[-1][1] / exact - 1):.2g} %.",
         "PBD with k = 0.1 a projection and 1, 5 and 10 iterations has the periods " +
         ", ".join("none" if period is None else f"{period:.3f} s" for _, period, _ in pbd) + "."],
        ["method", "period, s", "backward Euler's, s", "swing left after a period"], table, ("spring", figure))


# ---- XPBD 2016, section 6.2: a chain ---------------------------------------------------------------------------------
# A chain of 20 particles of 1 kg, compliance 1e-8, falls for 100 frames of one step. The force at its support is compared
# with that of Newton's method on the same equations. The paper states neither step nor spacing, nor what its errors are
# relative to.


PRINTED_ERRORS = {50: 0.06, 100: 0.02, 1000: 0.005}  # by iterations


def chain_settings(quick):
    """Steps (s) and spacings (m)."""
    return [(1 / 60, 0.2)] if quick else [(dt, spacing) for dt in (1 / 60, 0.008) for spacing in (0.05, 0.1, 0.2, 0.5, 1.0)]


def horizontal_chain(dt, spacing, iterations):
    """malha's chain starts horizontal and swings down. Its last particle has half a kilogram, as masses follow segment
    lengths."""
    body = {"name": "chain", "shape": {"chain": {"from": [0, 0, 0], "to": [LINKS * spacing, 0, 0], "segments": LINKS}},
            "density": 1 / spacing, "pins": [{"particles": [0]}],
            "constraints": [{"type": "distance", "elements": ["edges"], "compliance": 1e-8}]}
    return malha.Simulation(scene_of(body, dt, 1, iterations), threads=1)


def support_forces(chain, dt, step):
    """The force (N) at the support in each frame: that which explains the change of momentum of all movable particles.

    step: a function of positions and velocities that returns those of the next frame.
    """
    mass = 1 / np.array(chain["inverse"][1:])
    x, v, forces = chain["start"], [0j] * PARTICLES, []
    for _ in range(100):
        before = np.array(v[1:])
        x, v = step(x, v)
        forces.append(abs(np.sum(mass * ((np.array(v[1:]) - before) / dt - chain["gravity"]))))
    return np.array(forces)


def run_chain(setting):
    dt, spacing = setting

    def errors(force, truth):
        """The largest errors relative to the run's largest force and to the frame's own, and the error of the largest force."""
        return {"of_most": np.max(abs(force - truth)) / truth.max(), "of_own": np.max(abs(force - truth) / truth),
                "of_peak": abs(force.max() / truth.max() - 1), "pull_n": force}

    def by_malha(x, v):
        simulation.step()
        return tuple((now[:, 0] + 1j * now[:, 1]).tolist() for now in (simulation.positions, simulation.velocities))

    start = horizontal_chain(dt, spacing, 1)
    x = (start.positions[:, 0] + 1j * start.positions[:, 1]).tolist()
    chain = chain_of([1.0] * PARTICLES, spacing, 1e-8, 1, -9.81j)
    rope = chain | {"inverse": start.inverse_masses.tolist(), "rest": np.abs(np.diff(x)).tolist(), "start": x}
    truth, chain_truth = (support_forces(one, dt, lambda x, v: newton(one, dt, x, v)) for one in (rope, chain))
    cell = {"newton_n": truth}
    for n in PRINTED_ERRORS:
        simulation = horizontal_chain(dt, spacing, n)
        cell[str(n)] = {"malha": errors(support_forces(rope, dt, by_malha), truth)} | {
            name: errors(support_forces(one, dt, lambda x, v: sweep(one, dt, n, x, v)), one_truth)
            for name, one, one_truth in (("in_order", rope, truth), ("in_order_1kg", chain, chain_truth))}
    return cell


def request_chains(study):
    settings = chain_settings(study.quick)
    return list(zip(settings, study.cells(settings, lambda at: f"chain: step {at[0]:.9g} s, spacing {at[1]:g} m", run_chain)))


def show_chains(study, chains):
    table, differences, distances = [], [], []
    for (dt, spacing), cell in chains:
        for n, printed in PRINTED_ERRORS.items():
            by = cell[str(n)]
            study.row(case="chain of 2016", what="largest error of the force at the support, relative to its largest", dt_s=dt,
                      spacing_m=spacing, iterations=n, printed=printed, ours=by["malha"]["of_most"],
                      ours_of_the_frames_own=by["malha"]["of_own"], ours_of_the_largest_pull=by["malha"]["of_peak"],
                      plain_sweep=by["in_order"]["of_most"], plain_sweep_last_1kg=by["in_order_1kg"]["of_most"],
                      **studies.machine(cell))
            table.append([f"{dt:.4g}", f"{spacing:g}", n, *map(percent, (
                printed, by["malha"]["of_most"], by["in_order"]["of_most"], by["in_order_1kg"]["of_most"],
                by["malha"]["of_peak"], by["malha"]["of_own"]))])
            differences.append(abs(math.log(by["malha"]["of_most"] / by["in_order"]["of_most"])))
        distances.append(sum(abs(math.log(cell[str(n)]["malha"]["of_most"] / printed)) for n, printed in PRINTED_ERRORS.items()))
    (dt, spacing), best = chains[int(np.argmin(distances))]

    def three(by, what):
        return "{}, {} and {}".format(*(percent(best[str(n)][by][what]) for n in PRINTED_ERRORS))

    figure, axes = plt.subplots()
    frames = np.arange(1, 101)
    for n in PRINTED_ERRORS:
        axes.plot(frames, best[str(n)]["malha"]["pull_n"], label=f"malha, {n} iterations")
    axes.plot(frames, best["newton_n"], color="black", ls="--", label="Newton")
    axes.set(xlabel="frame", ylabel="force at the support (N)", xlim=(0, 100), ylim=(0, None),
             title=f"A chain of 20 particles swings down (step {dt:.4g} s, spacing {spacing:g} m)")
    axes.legend()
    study.section(
        "XPBD 2016, section 6.2: the force at the support of a falling chain",
        ["Printed: errors of at most 6, 2 and 0.5 % with 50, 100 and 1000 iterations. The paper states neither step nor spacing "
         "nor start; here the chain starts horizontal. The force at the support is that which balances the change of momentum of "
         "all particles, and errors are relative to the largest force of the run.",
         f"Of {studies.counted(len(chains), 'setting')} the closest is a step of {dt:.4g} s and a spacing of {spacing:g} m: malha's "
         f"errors are {three('malha', 'of_most')}; those of a plain sweep from the support on are {three('in_order', 'of_most')}"
         f"; and with 1 kg at the free end instead of half of that {three('in_order_1kg', 'of_most')}.",
         "malha projects every other link and then the rest, not from the support on: its errors differ from the plain sweep's "
         f"by a factor of {math.exp(max(differences)):.2f} at most.",
         f"Relative to the force of the same frame, which is almost 0 in the first one, malha's errors are up to "
         f"{three('malha', 'of_own')}; the errors of its largest force are {three('malha', 'of_peak')}."],
        ["step, s", "spacing, m", "iterations", "printed", "malha", "plain sweep from the support",
         "the same, last particle 1 kg", "malha, error of the largest force", "malha, relative to the same frame"],
        table, ("chain", figure))


# ---- A weight at the end of a chain, for two papers ------------------------------------------------------------------
# A chain of particles of 1 kg with a heavier last one hangs straight down at its rest length and is released.


FRAMES = 900


def swing_of(hanging, step):
    """{most_m, still_m, frame}: the largest distance of the weight below its initial position in the first swing, its
    distance at rest (the mean over that swing), and the frame in which it is lowest.

    step: a function without arguments that simulates a frame and returns the weight's height.
    """
    down = [-step() - LINKS * hanging["spacing"]]
    lowest = None
    while len(down) < FRAMES and (lowest is None or len(down) <= 2 * lowest):  # until the first swing ends
        down.append(-step() - LINKS * hanging["spacing"])
        if lowest is None and down[-1] < down[-2]:
            lowest = len(down) - 2
    lowest = len(down) - 1 if lowest is None else lowest
    swing = down[:2 * lowest + 1]
    return {"most_m": down[lowest], "still_m": sum(swing) / len(swing), "frame": lowest + 1}


def malha_swing(hanging):
    """Masses follow the lengths of segments. The weight is therefore the last particle together with one more far below it,
    connected by a segment that is as long as its mass requires."""
    spacing = hanging["spacing"]
    points = np.zeros((PARTICLES + 1, 3))
    points[:, 1] = -spacing * np.arange(PARTICLES + 1)
    points[-1, 1] = -LINKS * spacing - (hanging["weight"] - 0.5) * spacing
    constraints = [{"type": "distance", "elements": ["edges"]}]
    if hanging["compliance"]:
        constraints[0]["compliance"] = hanging["compliance"]
    if hanging["long_range"]:
        constraints.append({"type": "long_range", "limit": 0.02})
    body = malha.body(points, lines=[[i, i + 1] for i in range(PARTICLES)], name="chain", pins=[0], density=1 / spacing,
                      constraints=constraints)
    simulation = malha.Simulation(scene_of(body, hanging["dt"], hanging["substeps"], hanging["iterations"], hanging["gravity"]),
                                  threads=1)

    def step():
        simulation.step()
        return simulation.positions[PARTICLES - 1, 1]

    return swing_of(hanging, step)


def reference_swing(hanging, one_step):
    """By a reference, of which one_step(chain, x, v) simulates a frame."""
    chain = chain_of([1.0] * LINKS + [hanging["weight"]], hanging["spacing"], hanging["compliance"], -1j,
                     -1j * hanging["gravity"])
    state = [chain["start"], [0j] * PARTICLES]

    def step():
        state[:] = one_step(chain, *state)
        return state[0][-1].imag

    return swing_of(hanging, step)


def plain_swing(hanging):
    def frame(chain, x, v):
        for _ in range(hanging["substeps"]):
            x, v = sweep(chain, hanging["dt"] / hanging["substeps"], hanging["iterations"], x, v)
        return x, v

    return reference_swing(hanging, frame)


def newton_swing(hanging):
    return reference_swing(hanging, lambda chain, x, v: newton(chain, hanging["dt"], x, v))


def key_of(hanging):
    stiffness = 1 / hanging["compliance"] if hanging["compliance"] else math.inf
    return (f"{hanging['weight']:g} kg, k = {stiffness:g}, step {hanging['dt']:.9g} s, g = {hanging['gravity']:g}, "
            f"{hanging['substeps']}x{hanging['iterations']}" + (", long range" if hanging["long_range"] else ""))


def swings(study, name, hanging):
    """The cell of a setting: malha's swing, and that of a plain sweep from the support on."""
    return study.cell(f"{name}: {key_of(hanging)}", lambda: {"malha": malha_swing(hanging), "plain": plain_swing(hanging)})


def swing_row(study, case, hanging, method, swing, cell, **more):
    study.row(case=case, what="how far the weight gets below its place", method=method, dt_s=hanging["dt"],
              gravity_m_per_s2=hanging["gravity"], substeps=hanging["substeps"], iterations=hanging["iterations"],
              **swing, **more, **studies.machine(cell))


# ---- Small Steps 2019, section 6.1 -----------------------------------------------------------------------------------
# Masses are 1 kg and at the end 100,000 kg, 0.01 m apart. The paper prints a stretch of 322.1 m with 100 iterations and of
# 3.2 m with 100 substeps, and does not state the step.


PRINTED_STRETCH = {"100 iterations": 322.1, "100 substeps": 3.2}  # m


def small_steps(dt, gravity, way, **more):
    substeps, iterations = (1, 100) if way == "100 iterations" else (100, 1)
    return {"weight": 1e5, "spacing": 0.01, "compliance": 0.0, "dt": dt, "gravity": gravity, "substeps": substeps,
            "iterations": iterations, "long_range": False} | more


def request_weights(study):
    """{(dt, gravity): {way: cell}}, and beside them the step that reaches the printed stretch, and a run by long_range. The
    last two depend on the first."""
    found = {"tried": {}}

    def both_ways(dt, gravity):
        return {way: swings(study, "weight", small_steps(dt, gravity, way)) for way in PRINTED_STRETCH}

    def work():
        for gravity in (9.81, 10.0):
            for dt in ((1 / 60, 0.03) if study.quick else (1 / 120, 1 / 60, 0.02, 0.025, 0.03, 1 / 30, 0.04, 1 / 24)):
                found["tried"][dt, gravity] = both_ways(dt, gravity)

        def off(at):
            return abs(found["tried"][at]["100 iterations"]["malha"]["most_m"] / PRINTED_STRETCH["100 iterations"] - 1)

        found["best"] = dt, gravity = min(found["tried"], key=off)
        # The stretch grows with the square of the step.
        at_60 = found["tried"][1 / 60, 9.81]["100 iterations"]["malha"]["most_m"]
        found["matching_step"] = math.sqrt(PRINTED_STRETCH["100 iterations"] / at_60) / 60
        found["matching"] = both_ways(found["matching_step"], 9.81)
        found["tethered"] = small_steps(dt, gravity, "100 substeps", substeps=10, long_range=True)
        found["tethered_swing"] = study.cell("weight: " + key_of(found["tethered"]), lambda: malha_swing(found["tethered"]))

    study.together(work)
    return found


def show_weights(study, found):
    table, differences, curves = [], [], {}
    for (dt, gravity), by_way in found["tried"].items():
        for way, printed in PRINTED_STRETCH.items():
            cell = by_way[way]
            most, plain = cell["malha"]["most_m"], cell["plain"]["most_m"]
            for method, by in (("malha", "malha"), ("plain sweep", "plain")):
                swing_row(study, "weight of 2019", small_steps(dt, gravity, way), method, cell[by], cell, printed_m=printed)
            table.append([f"{dt:.5g}", f"{gravity:g}", way, f"{printed:g}", f"{most:.4g}", f"{plain:.4g}",
                          f"{cell['malha']['still_m']:.4g}"])
            differences.append(abs(most / plain - 1))
            curves.setdefault((way, gravity), []).append((dt, most))
    tethered = found["tethered_swing"]
    swing_row(study, "weight of 2019", found["tethered"], "malha with long_range", tethered, tethered)
    figure, axes = plt.subplots()
    for (way, gravity), points in curves.items():
        axes.plot(*zip(*points), marker="o", ls="-" if gravity != 10 else "--", label=f"{way}, g = {gravity:g}",
                  color=studies.COLOURS[list(PRINTED_STRETCH).index(way)], fillstyle="full" if gravity != 10 else "none")
    for printed in PRINTED_STRETCH.values():
        axes.axhline(printed, color="black", ls=":", lw=1.2)
        axes.text(0.0082, printed * 1.04, f"printed: {printed:g} m", va="bottom")
    axes.set(xscale="log", yscale="log", xlabel="time step (s)", ylabel="most stretch (m)", xlim=(0.008, 0.05),
             title="Small Steps 2019, 6.1: a weight of 100,000 on 19 links")
    axes.xaxis.set_major_locator(plt.FixedLocator([0.01, 0.02, 0.03, 0.04, 0.05]))
    axes.xaxis.set_minor_locator(plt.NullLocator())
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.legend(loc="center right")

    def both(by_way):
        return [by_way[way]["malha"]["most_m"] for way in PRINTED_STRETCH]

    dt, gravity = found["best"]
    best, matching, at_60 = both(found["tried"][dt, gravity]), both(found["matching"]), both(found["tried"][1 / 60, 9.81])[0]
    study.section(
        "Small Steps 2019, section 6.1: a weight of 100,000 on a chain",
        ["Printed: 322.1 m of stretch with 100 iterations and 3.2 m with 100 substeps of one; neither the step is stated, nor "
         "when the stretch is measured. Here it is the largest of the first swing.",
         f"Of all steps and gravities below, a step of {dt:.4g} s with g = {gravity:g} m/s^2 is closest: {best[0]:.1f} m with "
         f"iterations and {best[1]:.2f} m with substeps.",
         f"With g = 9.81 m/s^2 the step would have to be {found['matching_step']:.5f} s ({matching[0]:.1f} m and "
         f"{matching[1]:.2f} m), which is unusual; a step of 1/60 s leads to {at_60:.1f} m.",
         "At any step the stretch with substeps is a hundredth of that with iterations. malha, which projects every other link "
         f"and then the rest, and a plain sweep from the support on agree to {max(differences):.1e}.",
         "With long-range attachments and a tenth of the work the stretch is at most "
         f"{tethered['most_m']:.2g} m (of a chain of 0.19 m)."],
        ["step, s", "g, m/s^2", "", "printed, m", "malha, most, m", "plain sweep, most, m", "malha, hanging still, m"], table,
        ("weight", figure))


# ---- Vertex Block Descent 2024: a strand -----------------------------------------------------------------------------
# The strand has 20 vertices, the last one of mass 1000, and a stiffness of 1e8; the paper takes 100 iterations in 1/60 s.


def strand(substeps, iterations):
    return {"weight": 1000, "spacing": 0.1, "compliance": 1e-8, "dt": 1 / 60, "gravity": 9.81, "substeps": substeps,
            "iterations": iterations, "long_range": False}


def request_strands(study):
    schedules = [(1, 100), (10, 10), (100, 1)] if study.quick else [(1, 100), (1, 1000), (1, 10000), (10, 10), (100, 1)]
    found = {"runs": {}}

    def work():  # it is too short to be divided
        found["newton"] = study.cell("strand: Newton", lambda: newton_swing(strand(1, 1)))
        for schedule in schedules:
            found["runs"][schedule] = swings(study, "strand", strand(*schedule))

    study.together(work)
    return found


def show_strands(study, found):
    newton_most, summary = found["newton"]["most_m"], []
    table = [["backward Euler, Newton", f"{newton_most:.4g}", "", "1"]]
    swing_row(study, "strand of 2024", strand(1, 1), "Newton", found["newton"], found["newton"])
    for (substeps, iterations), cell in found["runs"].items():
        most = cell["malha"]["most_m"]
        for method, by in (("malha", "malha"), ("plain sweep", "plain")):
            swing_row(study, "strand of 2024", strand(substeps, iterations), method, cell[by], cell)
        table.append([f"malha, {substeps} x {iterations}", f"{most:.4g}", f"{cell['plain']['most_m']:.4g}",
                      f"{most / newton_most:.3g}"])
        if substeps * iterations == 100:
            summary.append(f"{most:.3g} m by {substeps} x {iterations}")
    hanging = strand(1, 1)
    still = LINKS * hanging["weight"] * hanging["gravity"] * hanging["compliance"]
    study.section(
        "Vertex Block Descent 2024: a strand with a weight of 1000",
        ["The paper shows a picture: XPBD's strand is too long after 100 iterations, and prints no length; spacing and the other "
         "masses, here 1 kg, are not known to us.",
         f"In equilibrium the weight is {still:.2g} m below its initial position; with backward Euler by Newton's method it is "
         f"at most {newton_most:.2g} m below. malha's XPBD, with the work of 100 sweeps (substeps x iterations): "
         f"{', '.join(summary)}."],
        ["method", "most stretch, m", "plain sweep's, m", "times Newton's"], table)


# ---- A thesis of 2008: frame rates -----------------------------------------------------------------------------------
# They were measured on a Core 2 Duo at 2.2 GHz with rendering.


SHEETS = [("Desbrun, 289 particles, dense", [16, 16], "dense", "50 frames/s"),
          ("Desbrun, 506 particles, dense", [21, 22], "dense", "precomputation very slow beyond 500"),
          ("Desbrun, 506 particles, sparse", [21, 22], "sparse", ""),
          ("Desbrun, 2025 particles, dense", [44, 44], "dense", ""),
          ("PBD, 2025 particles", [44, 44], None, "50 frames/s (over 2000)")]  # name, cells, filter, what is printed


def timed(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def time_sheet(sheet, quick):
    """A sheet of 1 m and 0.2 kg hangs by two corners; a step is a frame of 1/50 s."""
    _, cells, filter_kind, _ = sheet
    body = {"name": "sheet", "shape": {"grid": {"size": [1, 1], "cells": cells}}, "mass": 0.2,
            "pins": [{"particles": [0, cells[0]]}], "constraints": [{"type": "distance", "elements": ["edges", "shear"]}]}
    scene = scene_of(body, 1 / 50, 10, 1)
    scene["solver"]["precision"] = "float"
    if filter_kind:
        scene["solver"] = {"type": "desbrun", "dt": 1 / 50, "filter": filter_kind, "spring_constant": 1000, "substeps": 1,
                           "iterations": 10}
    scene = malha.Scene(scene)
    setups = []
    for _ in range(1 if quick else 5):
        start = time.perf_counter()
        simulation = malha.Simulation(scene, threads=1)
        setups.append(time.perf_counter() - start)
    frames = [timed(lambda: simulation.step(5)) / 5 for _ in range(4 if quick else 100)]  # their loop is malha's
    return {"particles": len(simulation.positions), "setup_s": statistics.median(setups), "frame_s": statistics.median(frames),
            "strain_max": simulation.measure()["strain_max"]}


def request_sheets(study):
    return list(zip(SHEETS, study.cells(SHEETS, lambda sheet: "sheet: " + sheet[0],
                                        lambda sheet: time_sheet(sheet, study.quick))))


def show_sheets(study, sheets):
    table, summary = [], []
    for (what, _, _, printed), cell in sheets:
        frame, setup = cell["frame_s"], cell["setup_s"]
        study.row(case="sheets of 2008", what=what, particles=cell["particles"], printed=printed, frames_per_s=1 / frame,
                  frame_ms=1e3 * frame, setup_s=setup, strain_max=cell["strain_max"], **studies.machine(cell))
        table.append([what, printed, f"{1 / frame:.4g}", f"{1e3 * frame:.3g}", f"{1e3 * setup:.3g}"])
        if printed:
            summary.append(f"{1 / frame:,.0f} frames/s after {1e3 * setup:.2g} ms of set-up ({what})")
    study.section(
        "A thesis of 2008: both methods side by side",
        ["Printed, on a Core 2 Duo at 2.2 GHz and with a rendering engine: 289 particles by Desbrun's method and over 2000 by "
         "PBD at 50 frames/s each, and a precomputation that is too slow beyond 500 particles.",
         f"malha on one thread and without rendering, a frame of 1/50 s each: {'; '.join(summary)}."],
        ["case", "printed", "malha, frames/s", "ms a frame", "set-up, ms"], table)


# ---- PBD 2006, figure 6: a self-colliding cloth ----------------------------------------------------------------------
# The paper has 1,364 vertices and 2,562 triangles at 30 frames/s on a Pentium 4 at 3 GHz, with detection, handling and
# rendering.


def cloth_of_2006(drapes, substeps):
    """A cloth that drapes over a ball, or falls on edge onto the ground and folds to a heap; frames of 1/30 s."""
    environment = [{"name": "ground", "shape": {"grid": {"size": [8, 8], "cells": [1, 1]}},
                    "transform": {"translate": [-4, 0, -4]}, "sides": "one_sided", "thickness": 0.005, "friction": 0.5}]
    if drapes:
        transform = {"translate": [-0.43, 0.55, -0.3]}
        environment.append({"name": "ball", "shape": {"sphere": {"radius": 0.2, "subdivisions": 4}},
                            "transform": {"translate": [0, 0.3, 0]}, "thickness": 0.005, "friction": 0.3})
    else:
        transform = {"rotate": {"axis": [0, 0, 1], "degrees": 84}, "translate": [-0.04, 0.02, -0.3]}
    body = {"name": "cloth", "shape": {"grid": {"size": [0.86, 0.6], "cells": [43, 30]}}, "transform": transform, "density": 0.3,
            "constraints": [{"type": "distance", "elements": ["edges", "shear"]}, {"type": "bending", "stiffness": 0.3}]}
    return {"name": "drape" if drapes else "heap", "gravity": [0, -9.81, 0], "bodies": [body], "environment": environment,
            "self_collision": {"thickness": 0.01, "friction": 0.2}, "duration": 1,
            "solver": {"type": "pbd", "dt": 1 / 30, "substeps": substeps, "levels": "off"}}


def motion_name(drapes, substeps):
    return ("drapes over a ball" if drapes else "folds on the ground") + f", {substeps} substeps"


def time_cloth(drapes, substeps, threads, quick):
    simulation = malha.Simulation(cloth_of_2006(drapes, substeps), threads=threads)
    frames, states = [], []
    for _ in range(8 if quick else 60):
        frames.append(timed(simulation.step))
        states.append(simulation.measure())
    return {"particles": len(simulation.positions), "mean_frame_s": sum(frames) / len(frames), "slowest_frame_s": max(frames),
            "most_contacts": max(state["self_contacts"] for state in states),
            "strain_rms": max(state["strain_rms"] for state in states), "crossings": max(state["crossings"] for state in states)}


def request_cloths(study):
    motions = [(False, 2)] if study.quick else [(True, 20), (False, 10), (False, 20)]
    settings = [(*motion, threads) for motion in motions for threads in ([1] if study.quick else sorted({1, study.cores}))]
    return list(zip(settings, study.cells(settings, lambda at: f"cloth: {motion_name(*at[:2])}, {studies.counted(at[2], 'thread')}",
                                          lambda at: time_cloth(*at, study.quick))))


def show_cloths(study, cloths):
    table, summary = [], []
    for (drapes, substeps, threads), cell in cloths:
        motion, mean, slowest = motion_name(drapes, substeps), 1 / cell["mean_frame_s"], 1 / cell["slowest_frame_s"]
        study.row(case="cloth of 2006", what=motion, particles=cell["particles"], threads=threads, printed=30, frames_per_s=mean,
                  slowest_frames_per_s=slowest, most_contacts=cell["most_contacts"], strain_rms=cell["strain_rms"],
                  crossings=cell["crossings"], **studies.machine(cell))
        table.append([motion, threads, 30, f"{mean:.3g}", f"{slowest:.3g}", cell["most_contacts"], percent(cell["strain_rms"]),
                      cell["crossings"]])
        summary.append(f"{mean:.3g}, the slowest frame {slowest:.3g} ({motion}, {studies.counted(threads, 'thread')})")
    best = max(1 / cell["mean_frame_s"] for _, cell in cloths)
    study.section(
        "PBD 2006, figure 6: a self-colliding cloth of 1,364 vertices",
        ["Printed: 30 frames/s on average on a Pentium 4 at 3 GHz, with detection, handling and rendering, of a cloth that ends "
         "up folded; the motion is not described. Here a cloth of as many vertices falls, and nothing is drawn.",
         f"malha, frames of 1/30 s a second: {'; '.join(summary)}.",
         f"At best that is {best / 30:.2g} times the printed rate: malha {'reaches' if best >= 30 else 'does not reach'} the "
         f"frame rate of 2006. Intersections after every frame: {max(cell['crossings'] for _, cell in cloths)} at most; every "
         "pair of primitives that could intersect is tested, and its displacements are truncated."],
        ["motion", "threads", "printed, frames/s", "malha, mean", "slowest frame", "most contacts", "RMS strain, most",
         "crossings, most"], table)


# ---- The study -------------------------------------------------------------------------------------------------------


CASES = [(request_springs, show_springs), (request_chains, show_chains), (request_weights, show_weights),
         (request_strands, show_strands), (request_sheets, show_sheets), (request_cloths, show_cloths)]


def measure(study):
    study.plan(28 if study.quick else 73)
    measured = [(show, request(study)) for request, show in CASES]
    if study.partial:
        return
    for show, cells in measured:
        show(study, cells)


if __name__ == "__main__":
    studies.main("published", "Published results, repeated with the papers' parameters, beside malha's", measure)
