# SPDX-License-Identifier: Apache-2.0
"""A sweep makes each run once, by any executor, and goes on after a kill."""
import concurrent.futures
import json
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import cloth, scene_of

import malha

BASE = scene_of(cloth(cells=6), duration=0.2)
LONGER = scene_of(cloth(cells=16), duration=0.5)  # some 20 ms, so that a kill comes between runs


def table_of(*arguments, **options):
    """The rows of a sweep's table, whether pandas is there or not."""
    table = malha.sweep(*arguments, **options)
    return table if isinstance(table, list) else table.to_dict("records")


def spawned(workers=2):
    return concurrent.futures.ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def stamps(out):
    """When each run of a sweep was written."""
    return {path.parent.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in pathlib.Path(out).glob("*/report.json")
            if not path.parent.name.endswith(".part")}


def sheets(size, cells):
    """A scene for the parameters of a run."""
    body = cloth(cells=cells)
    body["shape"]["grid"]["size"] = [size, size]
    return scene_of(body, duration=0.1)


def test_the_table_has_the_parameters_and_measures_of_each_run(tmp_path):
    rows = table_of(BASE, {"/solver/substeps": [4, 8], "/bodies/cloth/mass": [0.1, np.float64(0.3)]}, out=tmp_path)
    assert [(r["/solver/substeps"], r["/bodies/cloth/mass"]) for r in rows] == [(4, 0.1), (4, 0.3), (8, 0.1), (8, 0.3)]
    for row in rows:
        settings = malha.Scene(BASE).to_dict()
        settings["solver"]["substeps"], settings["bodies"][0]["mass"] = row["/solver/substeps"], row["/bodies/cloth/mass"]
        simulation = malha.Simulation(settings)
        simulation.step(20)
        assert row["state_hash"] == simulation.state_hash and row["status"] == "finished" and row["steps"] == 20
        assert row["energy_j"] == pytest.approx(simulation.measure()["energy_j"])
        assert json.loads(pathlib.Path(row["path"], "report.json").read_text())["state_hash"] == row["state_hash"]
    assert len({row["path"] for row in rows}) == 4
    assert {path.name for path in tmp_path.iterdir()} == {pathlib.Path(row["path"]).name for row in rows}


def test_the_table_is_of_pandas_where_it_is_installed(tmp_path, monkeypatch):
    pandas = pytest.importorskip("pandas", reason="pandas is missing; tools/setup python installs it")
    table = malha.sweep(BASE, pandas.DataFrame({"/solver/substeps": [2, 4]}), out=tmp_path)
    assert isinstance(table, pandas.DataFrame) and list(table["/solver/substeps"]) == [2, 4]
    monkeypatch.setitem(sys.modules, "pandas", None)  # as where it is not installed
    rows = malha.sweep(BASE, {"/solver/substeps": [2, 4]}, out=tmp_path)
    assert isinstance(rows, list) and rows[1]["state_hash"] == table["state_hash"][1]


def test_what_is_done_is_not_done_again(tmp_path):
    made = []
    first = table_of(BASE, {"/solver/substeps": [2, 4]}, out=tmp_path)
    before = stamps(tmp_path)
    more = table_of(BASE, {"/solver/substeps": [2, 3, 4]}, out=tmp_path, progress=lambda done, runs: made.append((done, runs)))
    assert made == [(3, 3)], "only the run that was missing"
    assert before.items() <= stamps(tmp_path).items() and len(stamps(tmp_path)) == 3
    assert [more[0], more[2]] == first


def test_runs_are_made_in_the_order_of_the_rows(tmp_path):
    rows = table_of(BASE, {"/solver/substeps": [8, 2, 6, 4]}, out=tmp_path)
    written = sorted(rows, key=lambda row: pathlib.Path(row["path"], "report.json").stat().st_mtime_ns)
    assert [row["/solver/substeps"] for row in written] == [8, 2, 6, 4]


def test_equal_scenes_are_run_once(tmp_path):
    rows = table_of(BASE, [{"/solver/substeps": 4}, {"/solver/substeps": 4}, {}, {"/solver/substeps": 8}], out=tmp_path)
    assert rows[0]["path"] == rows[1]["path"] and rows[2]["path"] == rows[3]["path"] != rows[0]["path"]
    assert len(stamps(tmp_path)) == 2, "8 substeps are those of the base"


def test_a_function_makes_the_scenes(tmp_path):
    with spawned() as pool:
        rows = table_of(sheets, {"size": [0.5, 1], "cells": [4, 6]}, pool, out=tmp_path)
    assert [(row["size"], row["cells"]) for row in rows] == [(0.5, 4), (0.5, 6), (1, 4), (1, 6)]
    simulation = malha.Simulation(sheets(1, 6))
    simulation.step(10)
    assert rows[3]["state_hash"] == simulation.state_hash


def test_a_mesh_that_changed_is_another_run(tmp_path):
    mesh = tmp_path / "mesh.obj"
    paths = set()
    for width in (1, 2, 1):
        mesh.write_text(f"v 0 0 0\nv {width} 0 0\nv 0 0 1\nf 1 2 3\n")
        paths.add(table_of(by_path(str(mesh)), [{}], out=tmp_path / "out")[0]["path"])
    assert len(paths) == 2


def elsewhere():
    os.chdir("/")


def by_path(mesh):
    body = {"name": "cloth", "shape": {"mesh": mesh}, "mass": 1, "constraints": [{"type": "distance"}]}
    return scene_of(body, duration=0.1)


def test_relative_paths_start_where_the_sweep_was_called(tmp_path, monkeypatch):
    (tmp_path / "mesh.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.json").write_text(json.dumps(by_path("mesh.obj")))
    spawn = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawn, initializer=elsewhere) as pool:
        rows = table_of("scene.json", [{}], pool, out="a") + table_of(by_path, [{"mesh": "mesh.obj"}], pool, out="b")
    assert [row["status"] for row in rows] == ["finished"] * 2 and (tmp_path / "a").is_dir() and (tmp_path / "b").is_dir()


def test_a_run_that_diverges_is_a_result_and_one_that_is_refused_is_none(tmp_path, rushing):
    (row,) = table_of(rushing, [{}], out=tmp_path, steps=1100)
    assert row["status"] == "diverged" and "step 1024" in row["notes"] and pathlib.Path(row["path"], "report.json").exists()
    before = stamps(tmp_path)
    table_of(rushing, [{}], out=tmp_path, steps=1100)
    assert stamps(tmp_path) == before
    missing = BASE | {"bodies": [cloth() | {"shape": {"mesh": str(tmp_path / "none.obj")}, "pins": []}]}
    for _ in range(2):
        (row,) = table_of(missing, [{}], out=tmp_path)
        assert row["status"] == "refused" and "cannot read" in row["notes"] and row["path"] is None
    assert stamps(tmp_path) == before


@pytest.mark.parametrize("parameters, said", [
    ({"/solver/substepz": [1]}, r"sweep: run 0, .*unknown key 'substepz' \(did you mean 'substeps'\?\)"),
    ({"/solvr/substeps": [1]}, r"/solvr/substeps: found 'solvr' \(did you mean 'solver'\?\); allowed: .*solver"),
    ({"/bodies/clot/mass": [1]}, r"found 'clot' \(did you mean 'cloth'\?\); allowed: 0, cloth"),
    ({"/bodies/0/mass/x": [1]}, r"found 'x'; allowed: nothing below a number"),
    ({"/solver/substeps": [4, 0]}, r"sweep: run 1, {'/solver/substeps': 0}: scene: /solver/substeps: found 0; allowed: "),
    ({"/solver/substeps": 4}, r"/solver/substeps: found int; allowed: a list of values"),
    ([{"/solver/substeps": 4}, 5], r"row 1: found int; allowed: a dict of values"),
])
def test_parameters_that_no_scene_has_are_refused_before_the_first_run(parameters, said, tmp_path):
    with pytest.raises(malha.InputError, match=said):
        malha.sweep(BASE, parameters, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_executors_that_cannot_do_are_refused(tmp_path):
    with pytest.raises(malha.InputError, match="executor: found int; allowed: one of concurrent.futures"):
        malha.sweep(BASE, {}, 4, out=tmp_path)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("fork")) as pool:
        with pytest.raises(malha.InputError, match="processes that are forked"):
            malha.sweep(BASE, {}, pool, out=tmp_path)


def test_threads_make_the_same_table(tmp_path):
    parameters = {"/solver/substeps": range(1, 9)}
    alone = table_of(BASE, parameters, out=tmp_path / "alone")
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        threads = table_of(BASE, parameters, pool, out=tmp_path / "threads", threads=2)
    assert [row["state_hash"] for row in alone] == [row["state_hash"] for row in threads]


def test_a_killed_worker_ends_a_pool_and_the_next_call_makes_what_is_missing(tmp_path):
    parameters = {"/solver/substeps": range(1, 31)}
    with spawned() as pool:
        def kill(done, runs):
            if done == 5:
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        with pytest.raises(RuntimeError, match=r"sweep: \d+ of 30 runs are done; found BrokenProcessPool"):
            malha.sweep(LONGER, parameters, pool, out=tmp_path, progress=kill)
    before = stamps(tmp_path)
    assert 5 <= len(before) < 30
    with spawned() as pool:
        rows = table_of(LONGER, parameters, pool, out=tmp_path)
    assert [row["status"] for row in rows] == ["finished"] * 30 and before.items() <= stamps(tmp_path).items()


PROGRAM = """
import json, sys
import malha
base, out = json.loads(sys.argv[1]), sys.argv[2]
malha.sweep(base, {"/solver/substeps": list(range(1, 41))}, out=out)
"""


def test_a_sweep_that_was_killed_goes_on(tmp_path):
    running = subprocess.Popen([sys.executable, "-c", PROGRAM, json.dumps(LONGER), str(tmp_path)])
    deadline = time.monotonic() + 60
    while len(stamps(tmp_path)) < 10 and time.monotonic() < deadline:
        time.sleep(0.001)
    running.kill()
    running.wait()
    before = stamps(tmp_path)
    assert 10 <= len(before) < 40
    rows = table_of(LONGER, {"/solver/substeps": list(range(1, 41))}, out=tmp_path)
    assert [row["steps"] for row in rows] == [50] * 40 and len({row["path"] for row in rows}) == 40
    assert before.items() <= stamps(tmp_path).items()
    assert not list(tmp_path.glob("*.part")) and not list(tmp_path.glob("*.lock"))


def test_a_long_run_goes_on_from_its_checkpoint(tmp_path):
    long = BASE | {"outputs": {"checkpoint_every": 5}}
    (whole,) = table_of(long, [{}], out=tmp_path / "whole")
    part = tmp_path / "killed" / (pathlib.Path(whole["path"]).name + ".part")
    with pytest.raises(KeyboardInterrupt):
        def interrupt(step, steps, now):
            if step == 12:
                raise KeyboardInterrupt

        malha.run(long, part, progress=interrupt)
    seen = json.loads((part / "report.json").read_text())
    assert seen["step"] == 12
    (row,) = table_of(long, [{}], out=tmp_path / "killed")
    assert row["state_hash"] == whole["state_hash"]
    assert json.loads(pathlib.Path(row["path"], "report.json").read_text())["timing"]["steps"] == 8, "those that were left"


def test_dask_makes_a_whole_table_of_200_scenes_where_one_of_four_workers_is_killed(tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask is missing; tools/setup python installs it")
    killed = []
    with distributed.LocalCluster(n_workers=4, threads_per_worker=1, dashboard_address=None,
                                  local_directory=str(tmp_path / "dask")) as cluster, distributed.Client(cluster) as client:
        workers = client.run(os.getpid)

        def kill(done, runs):
            if done == 40 and not killed:
                killed.append(len(stamps(tmp_path / "out")))
                os.kill(next(iter(workers.values())), signal.SIGKILL)

        parameters = {"/solver/substeps": range(1, 21), "/bodies/cloth/mass": np.linspace(0.1, 1, 10)}
        rows = table_of(LONGER, parameters, client, out=tmp_path / "out", progress=kill)
    assert 40 <= killed[0] < 200 and len(set(workers.values())) == 4
    assert len(rows) == 200 and {row["status"] for row in rows} == {"finished"}
    assert len(stamps(tmp_path / "out")) == 200 and len(list((tmp_path / "out").iterdir())) == 200
    for row in rows[::37]:
        settings = malha.Scene(LONGER).to_dict()
        settings["solver"]["substeps"], settings["bodies"][0]["mass"] = row["/solver/substeps"], row["/bodies/cloth/mass"]
        simulation = malha.Simulation(settings)
        simulation.step(50)
        assert simulation.state_hash == row["state_hash"]


MPI = """
import json, sys
from mpi4py.futures import MPIPoolExecutor
import malha
if __name__ == "__main__":
    with MPIPoolExecutor() as pool:
        table = malha.sweep(json.loads(sys.argv[1]), {"/solver/substeps": list(range(1, 21))}, pool, out=sys.argv[2])
        print(len(table))
"""


def test_mpi_makes_the_same_table(tmp_path):
    pytest.importorskip("mpi4py", reason="mpi4py is missing; tools/setup python installs it")
    program = tmp_path / "program.py"
    program.write_text(MPI)
    done = subprocess.run(["mpiexec", "--allow-run-as-root", "--oversubscribe", "-n", "3", sys.executable, "-m", "mpi4py.futures",
                           str(program), json.dumps(BASE), str(tmp_path / "mpi")], capture_output=True, text=True, check=False,
                          env=os.environ | {"OMPI_MCA_plm_rsh_agent": "", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"})
    assert done.returncode == 0, done.stderr
    assert done.stdout == "20\n"
    before = stamps(tmp_path / "mpi")
    by_mpi = table_of(BASE, {"/solver/substeps": range(1, 21)}, out=tmp_path / "mpi")
    assert stamps(tmp_path / "mpi") == before, "it had made all of them"
    alone = table_of(BASE, {"/solver/substeps": range(1, 21)}, out=tmp_path / "alone")
    assert [row["state_hash"] for row in by_mpi] == [row["state_hash"] for row in alone]
