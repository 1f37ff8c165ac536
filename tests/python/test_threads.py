# SPDX-License-Identifier: Apache-2.0
"""Behaviour with Ctrl-C, callbacks, threads and memory."""
import gc
import json
import os
import signal
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest
from conftest import chain, cloth, distance, scene_of

import malha


def interrupt_soon(seconds=0.3):
    timer = threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    return timer


@pytest.mark.parametrize("callback", [None, lambda s: None])
def test_ctrl_c_ends_the_loop_after_a_whole_step(callback):
    run = malha.Simulation(scene_of(cloth(cells=30)), threads=1)
    timer = interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        run.step(10**9, callback)
    timer.join()
    again = malha.Simulation(scene_of(cloth(cells=30)), threads=1)
    assert run.steps > 0 and again.step(run.steps) == run.steps
    assert again.state_hash == run.state_hash
    assert run.step(2) == 2, "it goes on"


def test_ctrl_c_ends_a_whole_run_with_a_checkpoint(tmp_path):
    scene = scene_of(cloth(cells=30), duration=1e5)
    timer = interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        malha.run(scene, tmp_path / "out", threads=1)
    timer.join()
    run = malha.Simulation(scene)
    run.load_checkpoint(tmp_path / "out" / "checkpoint.malha")
    assert run.steps > 0


def test_ctrl_c_in_a_constraint_leaves_the_state_before_the_step():
    calls = []

    def slow(x, which):
        calls.append(1)
        if len(calls) == 20:
            signal.raise_signal(signal.SIGINT)
        return distance(0.5)(x, which)

    run = malha.Simulation(scene_of(chain()), constraints=[malha.Constraint([[0, 1]], slow)])
    with pytest.raises(KeyboardInterrupt):
        run.step(100)
    assert run.steps == 1, "eight substeps a step, of two calls"
    twin = malha.Simulation(scene_of(chain()), constraints=[malha.Constraint([[0, 1]], distance(0.5))])
    twin.step()
    assert run.state_hash == twin.state_hash


def test_callbacks_see_each_step_and_end_the_loop(simulation):
    times = []
    assert simulation.step(4, callback=lambda s: times.append(s.time)) == 4
    np.testing.assert_allclose(times, [0.01, 0.02, 0.03, 0.04])
    assert simulation.step(100, callback=lambda s: s.steps < 7) == 3
    assert simulation.step(0) == 0
    with pytest.raises(ZeroDivisionError):
        simulation.step(5, callback=lambda s: 1 / 0)
    assert simulation.steps == 8, "the step before the callback is whole"
    with pytest.raises(malha.InputError, match="step: n: found -1"):
        simulation.step(-1)


@pytest.mark.parametrize("said, steps", [(np.False_, 1), (np.True_, 5), (False, 1), (None, 5), (0, 1), (True, 5)])
def test_what_is_false_ends_the_loop_and_none_goes_on(simulation, said, steps):
    assert simulation.step(5, callback=lambda s: said) == steps


USES = {
    "step": lambda s: s.step(), "gravity": lambda s: setattr(s, "gravity", (1, 2, 3)),
    "positions": lambda s: setattr(s, "positions", s.positions), "pins": lambda s: setattr(s, "pins", [0]),
    "measure": lambda s: s.measure(), "values": lambda s: s.constraint_values(), "state": lambda s: s.save_state(),
}


@pytest.mark.parametrize("around", ["step", "measure", "report", "constraint_values", "failed_expectations"])
@pytest.mark.parametrize("use", USES)
def test_a_constraint_cannot_use_its_simulation_whoever_asks(around, use):
    refused = []

    def function(x, which):
        if run:
            with pytest.raises(RuntimeError, match="not done yet"):
                USES[use](run[0])
            refused.append(use)
        return distance(0.3)(x, which)

    run = []
    one = malha.Simulation(scene_of(cloth(cells=60)), threads=1, constraints=[malha.Constraint([[1, 2]], function, 1e-4)])
    run.append(one)
    getattr(one, around)()
    run.clear()
    assert refused and one.step() == 1


def test_a_thread_cannot_use_what_another_measures():
    inside, go_on, said = threading.Event(), threading.Event(), []

    def function(x, which):
        if threading.current_thread() is not threading.main_thread():
            inside.set()
            go_on.wait(60)
        return distance(0.3)(x, which)

    run = malha.Simulation(scene_of(cloth()), threads=1, constraints=[malha.Constraint([[1, 2]], function, 1e-4)])
    thread = threading.Thread(target=lambda: said.append(run.measure()))
    thread.start()
    assert inside.wait(60)
    with pytest.raises(RuntimeError, match="not done yet"):
        run.gravity = (1, 2, 3)
    go_on.set()
    thread.join()
    assert said[0]["elastic_energy_j"] > 0


@pytest.mark.parametrize("callback", ["None", "lambda s: None"])
def test_a_thread_that_steps_leaves_the_interpreter_in_peace(callback):
    code = f"""if True:
        import json, sys, threading, time, malha
        run = malha.Simulation(json.loads(sys.argv[1]), threads=1)
        threading.Thread(target=lambda: run.step(10**9, {callback}), daemon=True).start()
        time.sleep(0.3)"""
    scene = json.dumps(scene_of(cloth(cells=30)))
    done = subprocess.run([sys.executable, "-c", code, scene], capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_two_simulations_step_at_once_in_two_threads():
    """Each step's constraint waits for the other's: with one step at a time neither would end."""
    meeting = threading.Barrier(2, timeout=60)
    ends = []

    def simulate():
        met = distance(0.5)

        def function(x, which):
            meeting.wait()
            return met(x, which)

        run = malha.Simulation(scene_of(chain(), substeps=1), threads=1, constraints=[malha.Constraint([[0, 1]], function)])
        run.step(50)
        ends.append(run.state_hash)

    threads = [threading.Thread(target=simulate) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(ends) == 2 and ends[0] == ends[1]


def test_python_runs_while_two_simulations_compute():
    """A simulation refuses to be used while it computes: tested of both, one after the other and the first again."""
    stop = threading.Event()
    runs = [malha.Simulation(scene_of(cloth(cells=40)), threads=1) for _ in range(2)]

    def simulate(run):
        while not stop.is_set():
            run.step(200)

    def computes(run):
        try:
            run.time
        except RuntimeError as error:
            assert "not done yet" in str(error)
            return True
        return False

    threads = [threading.Thread(target=simulate, args=(run,)) for run in runs]
    for thread in threads:
        thread.start()
    try:
        assert any(computes(runs[0]) and computes(runs[1]) and computes(runs[0]) for _ in range(200_000))
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def resident_kib():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def test_ten_thousand_steps_leave_no_memory_and_no_references():
    seen = []

    def callback(s):
        seen[:] = [s.positions, s.velocities, s.faces, s.bodies, s.measure()]

    function = distance(0.05)
    constraint = malha.Constraint([[84, 85]], function, 1e-3)
    scene = malha.Scene(scene_of(cloth(), substeps=1))
    run = malha.Simulation(scene, threads=1, constraints=[constraint])
    run.step(500, callback)
    gc.collect()
    watched = (callback, function, constraint, scene, run, None, malha.Body)
    counts, objects, memory = [sys.getrefcount(one) for one in watched], len(gc.get_objects()), resident_kib()
    run.step(10_000, callback)
    gc.collect()
    now = [sys.getrefcount(one) for one in watched]
    assert all(abs(a - b) < 1000 for a, b in zip(counts, now)), "one leaked a step would be 10,000"
    assert len(gc.get_objects()) - objects < 100
    # Times of 10,000 steps are kept for the report, 80 KB in all; a leaked array a step would be 40 MB.
    assert resident_kib() - memory < 3000


def test_arrays_outlive_their_simulation():
    run = malha.Simulation(scene_of(cloth()))
    x = run.positions
    copy = x.copy()
    del run
    gc.collect()
    assert np.array_equal(x, copy)


def test_cycles_through_a_constraint_are_collected():
    class Watched:
        pass

    def cycle():
        box = [Watched()]

        def function(x, which):
            assert box
            return distance(0.5)(x, which)

        box.append(malha.Simulation(scene_of(chain()), constraints=[malha.Constraint([[0, 1]], function)]))
        box[1].step()
        return weakref.ref(box[0])

    watched = cycle()
    gc.collect()
    assert watched() is None


def test_a_number_of_threads_is_kept_where_it_may_not_adapt():
    run = malha.Simulation(scene_of(cloth(cells=40)), threads=2, adaptive_threads=False)
    adaptive = malha.Simulation(scene_of(cloth(cells=40)), threads=2)
    run.step(), adaptive.step()
    assert "steps_on_one_thread" not in run.report()["timing"]
    assert adaptive.report()["timing"]["steps_on_one_thread"] == 1, "the first step runs on one thread"
    assert run.state_hash == adaptive.state_hash
