# SPDX-License-Identifier: Apache-2.0
"""Speed-up of the hanging cloth of size.py by more threads: of the same body (strong scaling), and of one that grows with them
(weak scaling); pass by pass, beside the bandwidth of memory and the time to start threads. On a device size alone varies.

    PYTHONPATH=build/release /usr/bin/python3 tools/study/scaling.py --quick
    PYTHONPATH=build/cuda /usr/bin/python3 tools/study/scaling.py --backend cuda

A body's simulations on all numbers of threads are measured in turns, so that other load of the machine affects all of them.
"""
import ctypes
import functools
import math
import os
import pathlib
import statistics
import sys
import threading
import time
import timeit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import study as studies  # noqa: E402
from size import DENSE, METHODS, PBD, available_bytes, cloth, gib, grid, memory_bytes, seconds_a_step, seconds_of  # noqa: E402

import malha  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import NullLocator  # noqa: E402

WARM_UP = 3  # steps, after which the states are compared
PARTICLE_BYTES = 52  # per particle and substep of PBD: x, w and v are read, x and v written, in float
CACHE_BYTES, MEMORY_BYTES = 2**16, 384 * 2**20  # working sets in a core's cache and beyond any cache
SHADES = {"PBD, 10 substeps": "Blues", "Desbrun, sparse": "Greens", "Desbrun, dense": "Oranges"}  # matplotlib's, by method


def thread_counts(cores):
    """1, 2, 4 and so on, and the number of cores; 1 and 2 on a single core."""
    counts = [1]
    while 2 * counts[-1] < cores:
        counts.append(2 * counts[-1])
    return counts + [max(2, cores)]


def threads_text(count):
    return f"{count} thread" + ("s" if count > 1 else "")


# ---- The machine -----------------------------------------------------------------------------------------------------


def launch_costs(threads, quick):
    """Times of an empty parallel region and of a barrier in it, by the OpenMP library of malha's module. Minima of several
    windows, because other programs on the cores only add to them."""
    library = ctypes.PyDLL(sys.modules["_malha"].__file__)  # its symbols, and those of the libraries that it names
    region, barrier, nothing = library.GOMP_parallel, library.GOMP_barrier, library.omp_get_thread_num
    region.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint, ctypes.c_uint]
    address = [ctypes.cast(function, ctypes.c_void_p) for function in (nothing, barrier)]

    def windows(function, *arguments):
        """Microseconds of a call in each window, less those that the call from Python takes."""
        calls, seconds = 1000, 0.002 if quick else 0.02
        timer = timeit.Timer(functools.partial(function, *arguments))
        calls = max(1, int(seconds / timer.timeit(calls) * calls))
        return 1e6 * np.array(timer.repeat(5 if quick else 25, calls)) / calls

    call = library.omp_get_max_active_levels  # which does nothing
    call.argtypes = region.argtypes
    from_python = windows(call, address[0], None, threads, 0).min()
    alone, with_barrier = (windows(region, one, None, threads, 0) for one in address)
    return {"threads": threads, "fork_join_us": alone.min() - from_python,
            "fork_join_median_us": np.median(alone) - from_python,
            "barrier_us": max(0.0, with_barrier.min() - alone.min())}


def triad_gb_per_s(size, threads):
    """Bandwidth of a = b + c in float, two arrays read and one written as by the STREAM triad (McCalpin 1995), of `size` bytes
    together: the best of several rounds. Each thread has arrays of its own, and is bound to a core."""
    n = max(8192, size // (12 * threads) // 16 * 16)  # floats, in whole cache lines; numpy is slow on shorter rows
    passes = max(1, int(1e8 / (12 * n * threads)))  # a round takes some milliseconds, so that its start does not count
    cores = sorted(os.sched_getaffinity(0), key=lambda cpu: (is_second_of_its_core(cpu), cpu))
    start, rounds = threading.Barrier(threads), 15
    begins, ends = np.zeros((2, rounds, threads))

    def work(thread):
        if 2 <= threads <= len(cores):
            os.sched_setaffinity(0, {cores[thread]})  # of this thread
        memory = np.ones(3 * (n + 80) + 16, np.float32)  # an odd number of lines keeps the arrays in different cache sets
        first = -memory.ctypes.data % 64 // 4
        a, b, c = (np.lib.stride_tricks.as_strided(memory[first + k * (n + 80):], (passes, n), (0, 4)) for k in range(3))
        for turn in range(rounds):
            start.wait()
            begins[turn, thread] = time.perf_counter()
            np.add(b, c, out=a)
            ends[turn, thread] = time.perf_counter()

    workers = [threading.Thread(target=work, args=(thread,)) for thread in range(threads)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return 12e-9 * n * threads * passes / (ends.max(axis=1) - begins.min(axis=1)).min()


def is_second_of_its_core(cpu):
    """Whether another logical CPU of the same core has a smaller number."""
    try:
        siblings = pathlib.Path(f"/sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list").read_text(encoding="utf-8")
    except OSError:
        return False
    return int(siblings.replace("-", ",").split(",")[0]) != cpu


def device():
    """The name of the first CUDA device, and the bandwidth of a copy within its memory, reads and writes, in GB/s."""
    cuda, size = ctypes.CDLL("libcuda.so.1"), 2**28  # bytes: larger than its caches

    def check(status):
        if status != 0:
            raise OSError(f"CUDA: the device cannot be measured: error {status} of its driver")

    name, context, blocks = ctypes.create_string_buffer(256), ctypes.c_void_p(), [ctypes.c_uint64(), ctypes.c_uint64()]
    check(cuda.cuInit(0))
    check(cuda.cuDeviceGetName(name, len(name), 0))
    check(cuda.cuDevicePrimaryCtxRetain(ctypes.byref(context), 0))  # the one that malha uses
    check(cuda.cuCtxSetCurrent(context))
    for block in blocks:
        check(cuda.cuMemAlloc_v2(ctypes.byref(block), ctypes.c_size_t(size)))

    def copy():
        check(cuda.cuMemcpyDtoD_v2(*blocks, ctypes.c_size_t(size)))
        check(cuda.cuCtxSynchronize())

    copy()
    seconds = min(timeit.repeat(copy, number=1, repeat=10))
    for block in blocks:
        check(cuda.cuMemFree_v2(block))
    check(cuda.cuDevicePrimaryCtxRelease(0))
    return name.value.decode(), 2e-9 * size / seconds


# ---- Cells -----------------------------------------------------------------------------------------------------------


def cases(quick, on_device):
    """Kind, method and particles a side of each body; in weak scaling, a side of the body of one thread."""
    strong = {method: (17, 46, 100, 316, 1000) for method in METHODS} | {"Desbrun, dense": (17, 46, 100)}
    if quick:
        strong = {method: (17, 100) for method in METHODS} | {"Desbrun, dense": (17,)}
    # The work of a dense filter grows with the square of the particles; a device has one number of threads.
    weak = {} if on_device else {method: (50,) if quick else (100, 316) for method in METHODS if METHODS[method] is not DENSE}
    return [(kind, method, side) for kind, bodies in (("strong", strong), ("weak", weak))
            for method, all_sides in bodies.items() for side in all_sides]


def pass_seconds(simulation):
    """Seconds of all steps so far, by pass."""
    timing = simulation.report()["timing"]
    return {key.removesuffix("_ms"): 1e-3 * value * timing["steps"] for key, value in timing["step_ms_by_pass"].items()}


def measured(study, kind, method, side, threads, on_device):
    """The cell of a body: times of its simulations on all numbers of threads."""
    all_sides = [round(side * math.sqrt(t)) if kind == "weak" else side for t in threads]
    needs = sum(memory_bytes(method, n * n)[0] for n in all_sides) + memory_bytes(method, max(all_sides)**2)[1]
    if needs > 0.8 * (has := available_bytes()):
        return {"left_out": f"all together take {gib(needs)}, and {gib(has)} are free"}
    cell, lines, simulations = {"load_average": os.getloadavg()[0], "lines": []}, [], []
    for t, n in zip(threads, all_sides):
        scene = malha.Scene(cloth(grid(n), METHODS[method]))
        simulation, setup = seconds_of(lambda: malha.Simulation(scene, threads=t, adaptive_threads=False, timed_passes=True,
                                                                 **study.on))
        simulation.step(WARM_UP)
        simulations.append(simulation)
        lines.append({"threads": t, "particles": n * n, "setup_s": setup, "hash": simulation.state_hash, "step_s": [],
                      "turns": []})
    least = 0.005 if study.quick else 0.2
    for _ in range(3 if study.quick else 7):
        for line, simulation in zip(lines, simulations):
            simulation.step()  # OpenMP ends and starts threads if the last team had another number of them
            before, steps = pass_seconds(simulation), simulation.steps
            line["step_s"].append(seconds_a_step(simulation, least))
            line["turns"].append({key: (value - before.get(key, 0)) / (simulation.steps - steps)
                                  for key, value in pass_seconds(simulation).items()})
    if on_device:
        cell["device"], copy_speed = device()
    for line, simulation in zip(lines, simulations):
        report = simulation.report()
        turns = line.pop("turns")
        passes = {key: statistics.median(turn.get(key, 0) for turn in turns) for key in turns[-1]}
        must_move = PARTICLE_BYTES * PBD["substeps"] * line["particles"]
        if "filter" in report:
            must_move = 4 * report["filter"]["nonzeros"] * (1 if METHODS[method] is DENSE else 2)
        # The bandwidth of as many bytes as one substep or one product reads and writes: beyond the caches that of memory.
        working_set = must_move if "filter" in report else must_move // PBD["substeps"]
        working_set = min(max(working_set, CACHE_BYTES), CACHE_BYTES if study.quick else MEMORY_BYTES)
        cell["lines"].append(line | {
            "least_step_s": 1e-3 * report["timing"]["step_ms_min"],
            "passes_s": {key: value for key, value in passes.items() if value > 0},
            "patches": report["patches"]["count"], "patch_colors": report["patches"]["patch_colors"],
            "must_move_bytes": must_move,
            "triad_gb_per_s": copy_speed if on_device else triad_gb_per_s(working_set, line["threads"])})
    return cell


# ---- Rows ------------------------------------------------------------------------------------------------------------


def serial_fraction(threads, seconds):
    """The share s of the work that is serial: seconds(t) = seconds(1) (s + (1 - s) / t), by least squares (Amdahl 1967). The
    first number of threads is 1. None if the best s is not in [0, 1]: speed-ups are larger than the number of threads, or more
    threads are slower than one."""
    part = 1 / np.array(threads[1:])
    share = np.sum((np.array(seconds[1:]) / seconds[0] - part) * (1 - part)) / np.sum((1 - part)**2)
    return min(max(float(share), 0.0), 1.0) if -1e-12 <= share <= 1 + 1e-12 else None


def imbalance(patches, colors, threads):
    """Patches of the busiest thread over the mean, if those of a colour are distributed in equal numbers; 1: balanced."""
    if patches == 0 or colors == 0:
        return 1
    each = patches / colors / threads
    return math.ceil(each - 1e-9) / each


def rows_of(kind, method, side, cell):
    """The rows of a cell, one for each number of threads, with the speed-up over one; a single one if it was left out."""
    base = {"kind": kind, "method": method, "side": side, "left_out": cell.get("left_out")}
    if base["left_out"]:
        return [base]
    base |= {key: cell[key] for key in ("load_average", "device") if key in cell} | studies.machine(cell)
    one, rows = cell["lines"][0], []
    for line in cell["lines"]:
        t, step = line["threads"], statistics.median(line["step_s"])
        turns = [a / b for a, b in zip(one["step_s"], line["step_s"])]
        faster = statistics.median(turns)
        row = base | {"threads": t, "particles": line["particles"], "step_ms": 1e3 * step,
                      "times_as_fast": faster, "efficiency": faster if kind == "weak" else faster / t,
                      "least_times_as_fast": min(turns), "most_times_as_fast": max(turns),
                      "undisturbed_step_s": line["least_step_s"],
                      "undisturbed_times_as_fast": one["least_step_s"] / line["least_step_s"],
                      "setup_s": line["setup_s"], "hash": line["hash"],
                      "imbalance_by_patches": imbalance(line["patches"], line["patch_colors"], t) if line["patches"] else None}
        largest = line["passes_s"].get("fused_solve" if METHODS[method] is PBD else "filter", step)
        row |= {"gb_per_s": 1e-9 * line["must_move_bytes"] / largest, "triad_gb_per_s": line["triad_gb_per_s"],
                "patch_colors": line["patch_colors"]}
        for key, seconds in line["passes_s"].items():
            row[f"{key}_ms"] = 1e3 * seconds
            if key in one["passes_s"]:
                row[f"{key}_times_as_fast"] = one["passes_s"][key] / seconds
        rows.append(row)
    if kind == "strong" and len(rows) > 1:
        share = serial_fraction([row["threads"] for row in rows], [row["step_ms"] for row in rows])
        rows = [row | {"serial_share": share} for row in rows]
    return rows


# ---- Sections --------------------------------------------------------------------------------------------------------

MUST_MOVE = ("PBD must read x, w and v and write x and v of every particle in every substep, 52 bytes; Desbrun's pass through "
             "the filter reads a sparse factor twice, a dense one once.")


def groups(rows, kind):
    """The rows of a kind that were run, in a list for each method and side."""
    found = {}
    for row in rows:
        if row["kind"] == kind and not row["left_out"]:
            found.setdefault((row["method"], row["side"]), []).append(row)
    return list(found.values())


def name_of(row):
    return f"{row['method']}, {row['particles']:,}"


def left_out(rows, kind):
    return "".join(f" {row['method']}, N = {row['side']}, is left out: {row['left_out']}." for row in rows
                   if row["kind"] == kind and row["left_out"])


def on_most_threads(all_groups, words):
    """What words(row) says of each body on the most threads: "1.8 (PBD, 10 substeps, 289), ..."."""
    return ", ".join(f"{words(group[-1])} ({name_of(group[-1])})" for group in all_groups)


def threads_chart(all_groups, title, axis, key, ideal):
    figure, axes = plt.subplots()
    counts = sorted({row["threads"] for group in all_groups for row in group})
    for method in METHODS:
        own = [group for group in all_groups if group[0]["method"] == method]
        for nth, group in enumerate(own):  # darker for more particles
            value, least, most = (np.array([row[name] for row in group])
                                  for name in (key, "least_times_as_fast", "most_times_as_fast"))
            beside = 1.012**(len(axes.containers) - (len(all_groups) - 1) / 2)  # so that bars do not cover each other
            axes.errorbar([row["threads"] * beside for row in group], value, yerr=[value - least, most - value], marker="o",
                          color=plt.get_cmap(SHADES[method])(0.4 + 0.6 * (nth + 1) / (len(own) + 1)), capsize=3,
                          label=name_of(group[0]))
    if ideal:
        axes.plot(counts, counts, "--", color="black", lw=1, label="as many times")
    axes.set(title=title, xlabel="threads (bars: least and most of the turns)", ylabel=axis, xscale="log")
    if ideal and counts[-1] > 8:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.set_xticks(counts, map(str, counts))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1), fontsize=10)
    figure.subplots_adjust(left=0.08, right=0.74, top=0.93)
    return figure


def bandwidth_fields(row):
    moved, memory = row["gb_per_s"], row["triad_gb_per_s"]
    return [f"{moved:.1f}", f"{memory:.1f}", f"{100 * moved / memory:.0f} %"]


def add_strong(study, rows):
    all_groups = groups(rows, "strong")
    runs = [row for group in all_groups for row in group]
    most, load = max(row["threads"] for row in runs), max(row["load_average"] for row in runs)
    same = all(row["hash"] == group[0]["hash"] for group in all_groups for row in group)

    def fraction(row):
        return "not fitted" if row["serial_share"] is None else f"{row['serial_share']:.2f}"

    pinning = ", ".join(f"{name}={os.environ[name]}" if name in os.environ else f"{name} not set"
                        for name in ("OMP_PROC_BIND", "OMP_PLACES"))
    study.section(
        "Strong scaling: the same cloth on more threads",
        [f"{pinning}; the load average before a case was at most {load:.1f}, including this study's threads." +
         (" Other programs used the cores too, and affect the medians." if load > 1.2 * most else ""),
         f"Times as fast on {most} threads as on one, medians of the turns: "
         f"{on_most_threads(all_groups, lambda row: format(row['times_as_fast'], '.2f'))}.{left_out(rows, 'strong')}",
         "Times as fast by the shortest step of each, which other programs disturb least: "
         f"{on_most_threads(all_groups, lambda row: format(row['undisturbed_times_as_fast'], '.2f'))}.",
         "The serial fraction, fitted to all numbers of threads (if there are two, computed from the second): "
         f"{on_most_threads(all_groups, fraction)}. Not fitted: the best fraction is not between 0 and 1, because speed-ups are "
         "larger than the number of threads, or more threads are slower than one.",
         f"The states after the same steps are {'the same bits' if same else 'NOT the same bits'} on every number of threads."],
        ["method", "particles", "threads", "ms a step", "times as fast", "by the least step", "efficiency", "serial fraction",
         "GB/s that must move", "triad, GB/s", "imbalance by patches", "set-up, s"],
        [[row["method"], f"{row['particles']:,}", row["threads"], row["step_ms"], f"{row['times_as_fast']:.2f}",
          f"{row['undisturbed_times_as_fast']:.2f}", f"{100 * row['efficiency']:.0f} %", fraction(row),
          *bandwidth_fields(row)[:2], "" if row["imbalance_by_patches"] is None else f"{row['imbalance_by_patches']:.2f}",
          f"{row['setup_s']:.3g}"] for row in runs],
        ("strong", threads_chart(all_groups, "Strong scaling: the same cloth on more threads",
                                 "times as fast as one thread", "times_as_fast", True)))


def add_passes(study, rows):
    table, slowest = [], None
    for group in groups(rows, "strong"):
        one, last = group[0], group[-1]
        for key in [key for key in one if key.endswith("_ms") and key != "step_ms" and key in last]:
            name = key.removesuffix("_ms")
            share, faster = one[key] / one["step_ms"], last[f"{name}_times_as_fast"]
            table.append([one["method"], f"{one['particles']:,}", name, one[key], f"{100 * share:.0f} %", last["threads"],
                          last[key], f"{faster:.2f}"])
            if share > 0.05 and one["particles"] > 9000 and (slowest is None or faster < slowest[0]):
                slowest = faster, (f"{name} of {one['method']} with {one['particles']:,} particles, {faster:.2f} times on "
                                   f"{threads_text(last['threads'])}")
    sentences = ["PBD's prediction, projection and velocity update are one pass here, \"fused_solve\", a whole step in one "
                 "parallel region. Passes over up to 32,768 particles, other than patch solves, run on one thread by design."]
    if slowest:
        sentences.append("The pass with the smallest speed-up, of those with 5 % of a step or more from 10,000 particles on: "
                         f"{slowest[1]}.")
    study.section("Strong scaling, pass by pass", sentences,
                  ["method", "particles", "pass", "ms on one thread", "share of the step", "threads", "ms", "times as fast"],
                  table)


def add_bandwidth(study, rows):
    all_groups = groups(rows, "strong")
    large = [group for group in all_groups if group[0]["particles"] >= 1e6] if len(all_groups) > 5 else all_groups
    summary = "; ".join(f"{row['gb_per_s']:.1f} of {row['triad_gb_per_s']:.1f} GB/s ({name_of(row)}, "
                        f"{threads_text(row['threads'])})" for group in large for row in (group[0], group[-1]))
    study.section(
        "Bandwidth: what must move, beside the triad",
        [f"{MUST_MOVE} Constraints, forces and repeated reads are not included. The triad is over as many bytes as one substep "
         "or product reads and writes, so that for small bodies it is that of caches.",
         f"Bandwidth of the largest bodies, and that of the triad: {summary}."],
        ["method", "particles", "threads", "GB/s that must move", "triad of as many bytes, GB/s", "share"],
        [[row["method"], f"{row['particles']:,}", row["threads"], *bandwidth_fields(row)]
         for group in all_groups for row in group])


def add_launches(study, rows):
    launches = {row["threads"]: row for row in rows if row["kind"] == "launch"}
    summary = "; ".join(f"{row['fork_join_us']:.3g} and {row['barrier_us']:.3g} microseconds on {threads_text(t)}"
                        for t, row in launches.items() if t > 1)
    sentences = [f"An empty parallel region, and one more barrier within it: {summary}, at best (if other programs use the "
                 "cores, the times are those of the scheduler). On one thread malha opens no region."]
    shares = []
    for group in groups(rows, "strong"):
        last = group[-1]
        if "fused_solve_ms" in last and last["patch_colors"]:
            launch = launches[last["threads"]]
            waits = launch["fork_join_us"] + PBD["substeps"] * last["patch_colors"] * launch["barrier_us"]
            shares.append(f"{0.1 * waits / last['step_ms']:.2g} % ({last['particles']:,})")
    if shares:
        sentences.append("A step of PBD is one region with 10 substeps, each with a barrier per colour of patches. Their share "
                         f"of a step on the most threads, by particles: {', '.join(shares)}.")
    study.section("Time to start threads and to wait at barriers", sentences,
                  ["threads", "fork and join, microseconds", "median", "a barrier, microseconds"],
                  [[t, *(f"{row[key]:.3g}" for key in ("fork_join_us", "fork_join_median_us", "barrier_us"))]
                   for t, row in launches.items()])


def add_weak(study, rows):
    all_groups = groups(rows, "weak")
    study.section(
        "Weak scaling: a cloth that grows with the threads",
        ["Efficiency is the time of one thread over that of all threads, with as many particles per thread: "
         f"{on_most_threads(all_groups, lambda row: format(100 * row['efficiency'], '.0f') + ' %')}.{left_out(rows, 'weak')} The "
         "work of a sparse factor grows a little faster than its particles, which lowers its efficiency here."],
        ["method", "particles", "threads", "ms a step", "efficiency"],
        [[row["method"], f"{row['particles']:,}", row["threads"], row["step_ms"], f"{100 * row['efficiency']:.0f} %"]
         for group in all_groups for row in group],
        ("weak", threads_chart(all_groups, "Weak scaling: as many particles a thread (in names: of one thread)",
                               "efficiency", "efficiency", False)))


def add_on_device(study, rows):
    runs = [group[0] for group in groups(rows, "strong")]
    figure, axes = plt.subplots()
    for method in METHODS:
        own = [row for row in runs if row["method"] == method]
        if own:
            axes.plot([row["particles"] for row in own], [row["step_ms"] for row in own], marker="o",
                      color=plt.get_cmap(SHADES[method])(0.7), label=method)
    axes.set(title="What a step takes on the device", xlabel="particles", ylabel="ms a step", xscale="log", yscale="log")
    axes.legend()
    study.section(
        "What a step takes on the device, by size",
        [f"On {runs[0]['device'] if runs else 'no device'}. The host waits for every pass, to time it, which it does not in "
         f"a run.{left_out(rows, 'strong')}", MUST_MOVE],
        ["method", "particles", "ms a step", "ns a particle and step", "colours", "GB/s that must move", "a copy's GB/s", "share",
         "set-up, s"],
        [[row["method"], f"{row['particles']:,}", row["step_ms"], f"{1e6 * row['step_ms'] / row['particles']:.3g}",
          row["patch_colors"], *bandwidth_fields(row), f"{row['setup_s']:.3g}"] for row in runs], ("device", figure))


def add_sections(study, rows):
    for add in (add_strong, add_passes, add_bandwidth, add_launches, add_weak):
        add(study, rows)


def measure(study):
    on_device = study.on.get("backend") == "cuda"
    threads = [1] if on_device else thread_counts(study.cores)
    bodies = cases(study.quick, on_device)
    study.plan(len(bodies) + (0 if on_device else len(threads)))
    launches = [] if on_device else study.cells(threads, lambda t: f"launches on {threads_text(t)}",
                                                lambda t: launch_costs(t, study.quick))
    cells = study.cells(bodies, lambda case: f"{case[0]}: {case[1]}, {case[2]**2:,} particles",
                        lambda case: measured(study, *case, threads, on_device))
    if study.partial:
        return
    for cell in launches:
        study.row(kind="launch", **cell)
    for case, cell in zip(bodies, cells):
        for row in rows_of(*case, cell):
            study.row(**row)
    add_on_device(study, study.rows) if on_device else add_sections(study, study.rows)


if __name__ == "__main__":
    studies.main("scaling", "Speed-up by more threads, pass by pass, on the same body and on one that grows", measure,
                 any_backend=True)
