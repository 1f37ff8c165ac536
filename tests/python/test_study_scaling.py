# SPDX-License-Identifier: Apache-2.0
"""tools/study/scaling.py in its quick version: the same bits on all numbers of threads, and fits. Times are never asserted."""
import json
import os
import types

import pytest
from conftest import quick_study, run_study

pytest.importorskip("matplotlib")
pytest.importorskip("_malha_reference")

import scaling  # noqa: E402

THREADS = scaling.thread_counts(len(os.sched_getaffinity(0)))


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    out = quick_study("scaling", tmp_path_factory.mktemp)
    result = json.loads((out / "scaling.json").read_text())
    for section in result["sections"]:
        assert not section["chart"] or (out / f"{section['chart']}.svg").exists()
    return result


def rows_of_kind(result, kind):
    return [row for row in result["rows"] if row["kind"] == kind]


def test_every_number_of_threads_has_the_same_bits(result):
    hashes = {}
    for row in rows_of_kind(result, "strong"):
        hashes.setdefault((row["method"], row["side"]), []).append(row["hash"])
    assert len(hashes) == 5
    for body, all_hashes in hashes.items():
        assert len(set(all_hashes)) == 1 and len(all_hashes) == len(THREADS), body
    assert "The states after the same steps are the same bits on every number of threads." in result["sections"][0]["sentences"]


@pytest.mark.parametrize("cores, counts", [(1, [1, 2]), (2, [1, 2]), (3, [1, 2, 3]), (12, [1, 2, 4, 8, 12]),
                                           (64, [1, 2, 4, 8, 16, 32, 64])])
def test_threads_are_powers_of_two_and_all_cores(cores, counts):
    assert scaling.thread_counts(cores) == counts


def test_a_body_grows_with_the_threads_in_weak_scaling(result):
    rows = rows_of_kind(result, "weak")
    assert len(rows) == 2 * len(THREADS)
    for row in rows:
        assert row["particles"] / row["threads"] == pytest.approx(2500, rel=0.02), "sides are whole numbers"


def test_there_is_every_pass_of_a_step(result):
    for row in rows_of_kind(result, "strong"):
        passes = {key for key, value in row.items() if key.endswith("_ms") and key != "step_ms" and value is not None}
        assert passes == ({"fused_solve_ms"} if row["method"] == "PBD, 10 substeps" else
                          {"filter_ms", "forces_ms", "prediction_ms", "state_ms"})


def test_launches_are_measured_on_every_number_of_threads(result):
    rows = rows_of_kind(result, "launch")
    assert [row["threads"] for row in rows] == THREADS
    assert all(row["fork_join_us"] > 0 and row["barrier_us"] >= 0 for row in rows)


def test_there_are_all_sections(result):
    assert [section["title"].split(":")[0] for section in result["sections"]] == [
        "Strong scaling", "Strong scaling, pass by pass", "Bandwidth", "Time to start threads and to wait at barriers",
        "Weak scaling"]
    for section in result["sections"]:
        assert section["rows"] and all(len(row) == len(section["columns"]) for row in section["rows"])


def test_bandwidth_is_measured_on_several_threads():
    for threads in (1, 2):
        assert 0 < scaling.triad_gb_per_s(2**20, threads) < 1e4


def sections_of(rows, add=scaling.add_sections):
    """The sections that a function adds for the rows: dicts of sentences, columns and rows (fields that are no text)."""
    sections = []
    study = types.SimpleNamespace(section=lambda title, sentences, columns, rows, chart=None: sections.append(
        {"sentences": sentences, "columns": columns, "rows": rows}))
    add(study, rows)
    return sections


@pytest.mark.parametrize("method", scaling.METHODS)
def test_it_runs_on_more_threads_than_cores_too(method):
    study = types.SimpleNamespace(quick=True, on={})
    rows = scaling.rows_of("strong", method, 50, scaling.measured(study, "strong", method, 50, [1, 3, 8], False))
    assert len(rows) == 3
    for row in rows:
        assert row["hash"] == rows[0]["hash"] and row["times_as_fast"] > 0
    assert sections_of(rows, scaling.add_strong)[0]["rows"][2][2] == 8


def test_a_body_that_does_not_fit_into_memory_is_left_out(monkeypatch):
    monkeypatch.setattr(scaling, "available_bytes", lambda: 2**28)
    cell = scaling.measured(types.SimpleNamespace(quick=True, on={}), "weak", "Desbrun, sparse", 316, [1, 2], False)
    assert cell["left_out"].startswith("all together take ") and cell["left_out"].endswith("GiB, and 0.25 GiB are free")


# ---- Fits and rows ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0, 0.1, 0.5, 1])
def test_the_serial_fraction_is_found_from_times_that_follow_amdahl(share):
    threads = [1, 2, 4, 8, 64]
    assert scaling.serial_fraction(threads, [3 * (share + (1 - share) / t) for t in threads]) == pytest.approx(share, abs=1e-14)


@pytest.mark.parametrize("threads, seconds", [([1, 2], [1, 0.4]), ([1, 2, 4, 8], [8, 3.9, 1.9, 0.9]),
                                              ([1, 2, 4, 8], [1, 1.1, 1.3, 2])])
def test_the_serial_fraction_is_not_fitted_to_more_than_the_threads_or_to_slower_ones(threads, seconds):
    assert scaling.serial_fraction(threads, seconds) is None


def test_the_imbalance_is_the_busiest_thread_over_the_mean():
    assert scaling.imbalance(8, 2, 2) == 1
    assert scaling.imbalance(6, 2, 2) == pytest.approx(4 / 3), "two and one"
    assert scaling.imbalance(2, 2, 64) == 64, "one patch per colour: one thread works"
    assert scaling.imbalance(0, 0, 2) == 1, "no patches"


PBD = "PBD, 10 substeps"


def cell_of(seconds):
    """A cell with these seconds per step on 1, 2, 4 and 8 threads, the same in each turn."""
    return {"load_average": 0.5, "lines": [
        {"threads": 2**k, "particles": 10000, "step_s": [s, s, s], "least_step_s": s / 2, "passes_s": {"fused_solve": s / 4},
         "setup_s": 0.1, "hash": "a", "patches": 12, "patch_colors": 2, "must_move_bytes": 1e6, "triad_gb_per_s": 20}
        for k, s in enumerate(seconds)]}


def test_rows_have_the_speed_up_of_eight_threads():
    rows = scaling.rows_of("strong", PBD, 100, cell_of([0.8, 0.5, 0.35, 0.275]))
    assert len(rows) == 4
    eight = rows[3]
    expected = {"threads": 8, "step_ms": 275, "times_as_fast": 0.8 / 0.275, "undisturbed_times_as_fast": 0.8 / 0.275,
                "efficiency": 0.1 / 0.275, "fused_solve_times_as_fast": 0.8 / 0.275,
                "gb_per_s": 1e6 / (0.275 / 4) / 1e9,  # in the pass that reads and writes them
                "imbalance_by_patches": 8 / 6}  # six patches per colour
    assert {key: eight[key] for key in expected} == pytest.approx(expected, rel=1e-12)
    for row in rows:
        assert row["serial_share"] == pytest.approx(0.25, abs=1e-12), "0.2 s of 0.8 s are serial"


def test_rows_of_a_device_have_its_bandwidth():
    cell = cell_of([0.5]) | {"device": "a device"}
    cell["lines"][0]["triad_gb_per_s"] = 1e6 / (0.5 / 4) / 1e9 * 4
    section, = sections_of(scaling.rows_of("strong", PBD, 100, cell), scaling.add_on_device)
    assert len(section["rows"]) == 1 and len(section["rows"][0]) == len(section["columns"])
    assert section["rows"][0][7] == "25 %", "bandwidth over that of a copy"
    assert section["sentences"][0].startswith("On a device.")


def test_a_device_has_cases_of_strong_scaling_alone():
    on_device = scaling.cases(False, True)
    assert on_device == [case for case in scaling.cases(False, False) if case[0] == "strong"]
    assert ("strong", "PBD, 10 substeps", 1000) in on_device


def test_a_device_is_measured_by_its_driver(monkeypatch):
    calls, status = [], {}

    class Driver:
        def __getattr__(self, name):
            def call(*arguments):
                calls.append(name)
                if name == "cuDeviceGetName":
                    arguments[0].value = b"a device"
                return status.get(name, 0)
            return call

    monkeypatch.setattr(scaling.ctypes, "CDLL", lambda name: Driver())
    name, gb_per_s = scaling.device()
    assert name == "a device" and gb_per_s > 0
    assert calls.count("cuMemAlloc_v2") == calls.count("cuMemFree_v2") == 2 and calls.count("cuMemcpyDtoD_v2") == 11
    status["cuInit"] = 100
    with pytest.raises(OSError, match="error 100 of its driver"):
        scaling.device()


def test_a_device_that_is_not_there_is_named(tmp_path):
    ended = run_study("scaling", "--quick", "--backend", "cuda", "--out", tmp_path / "out")
    if ended.returncode == 0:
        pytest.skip("there is a device")
    assert ended.returncode == 2 and "cuda" in ended.stderr.lower() and "Traceback" not in ended.stderr
    assert not (tmp_path / "out" / "scaling.json").exists()


def test_rows_of_a_body_that_grows_compare_equal_times():
    rows = scaling.rows_of("weak", PBD, 100, cell_of([0.5, 0.5, 0.625, 1]))
    assert rows[1]["efficiency"] == 1 and rows[3]["efficiency"] == 0.5
    assert "serial_share" not in rows[3]


def test_a_row_has_the_reason_why_a_cell_was_left_out():
    rows = scaling.rows_of("strong", PBD, 100, {"left_out": "too large"})
    assert len(rows) == 1 and rows[0]["left_out"] == "too large"


def test_rows_name_their_machine_if_there_are_several():
    assert {row["machine"] for row in scaling.rows_of("strong", PBD, 100, cell_of([1, 0.5]) | {"machine": "b"})} == {"b"}


def test_sections_say_which_serial_fractions_are_not_fitted(monkeypatch):
    rows = scaling.rows_of("strong", PBD, 100, cell_of([0.8, 0.39, 0.19, 0.09]))
    assert all(row["serial_share"] is None for row in rows)
    rows += scaling.rows_of("strong", PBD, 316, cell_of([0.8, 0.5, 0.35, 0.275]))
    monkeypatch.setenv("OMP_PROC_BIND", "close")
    monkeypatch.setenv("OMP_PLACES", "cores")
    strong, = sections_of(rows, scaling.add_strong)
    assert strong["columns"][7] == "serial fraction"
    assert strong["rows"][3][7] == "not fitted" and strong["rows"][7][7] == "0.25"
    said = "\n".join(strong["sentences"])
    assert "OMP_PROC_BIND=close, OMP_PLACES=cores" in said
    assert "Times as fast on 8 threads as on one" in said
    assert ": not fitted (PBD, 10 substeps, 10,000), 0.25 (PBD, 10 substeps, 10,000). Not fitted: " in said
