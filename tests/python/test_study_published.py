# SPDX-License-Identifier: Apache-2.0
"""malha study published: its quick version agrees with printed results and with references. Times are never asserted."""
import csv
import json

import numpy as np
import pytest
from conftest import quick_study

pytest.importorskip("matplotlib")
import published  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The results of a quick run."""
    return quick_study("published", tmp_path_factory.mktemp)


@pytest.fixture(scope="module")
def result(folder):
    return json.loads((folder / "published.json").read_text())


@pytest.fixture(scope="module")
def rows_of(result):
    return lambda case: [row for row in result["rows"] if row["case"] == case]


# ---- The references --------------------------------------------------------------------------------------------------


def test_newtons_step_solves_the_equation_of_backward_euler():
    """An oscillator that turns: v' = v + h (gravity + k (1 - rest / |x'|) (-x') / m), with x' = x + h v'."""
    chain = published.chain_of([1.0, 2.0], 1.0, 1 / 50, 1, -9.81j)
    x, v, h = [0j, 1.3 + 0.2j], [0j, 0.5 - 1j], 0.02
    for _ in range(5):
        (_, new), (_, speed) = published.newton(chain, h, x, v)
        force = -50 * (1 - 1 / abs(new)) * new
        assert speed == pytest.approx(v[1] + h * (-9.81j + force / 2), abs=1e-9)
        assert new == pytest.approx(x[1] + h * speed, abs=1e-14)
        x, v = [0j, new], [0j, speed]


def test_many_sweeps_are_backward_euler():
    chain = published.chain_of([1.0] * 6, 0.3, 1e-3, 1, -9.81j)
    x, v = chain["start"], [0j] * 6
    for _ in range(3):
        by_newton, by_sweeps = published.newton(chain, 0.01, x, v), published.sweep(chain, 0.01, 3000, x, v)
        assert np.allclose(by_sweeps, by_newton, atol=1e-6)
        x, v = by_newton


@pytest.mark.parametrize("period, left", [(0.37, 0.8), (0.05, 0.5)])
def test_period_and_damping_are_those_of_a_damped_wave(period, left):
    t = 0.004 * np.arange(200)
    a = left**(t / period) * np.cos(2 * np.pi * t / period + 0.3)
    assert published.period_and_damping(a.tolist(), 0.004) == pytest.approx((period, left), rel=1e-9)


def test_what_does_not_oscillate_has_no_period():
    assert published.period_and_damping([0.5 * 0.8**n + 0.1 * 0.5**n for n in range(30)], 0.01) == (None, None)


# ---- The quick version -----------------------------------------------------------------------------------------------


def test_the_spring_by_xpbd_has_the_period_of_backward_euler_for_any_iterations(rows_of):
    rows = [row for row in rows_of("spring of 2016") if row["what"].startswith("XPBD")]
    assert len(rows) == 4
    for row in rows:
        # The tolerance is that of the fit to positions, which are accurate to 1e-16.
        assert row["period_s"] == pytest.approx(row["backward_euler_period_s"], rel=1e-6), row["what"]
        a = np.sqrt(1000) / 60 / row["substeps"]  # atan(a) / a = 1 - a^2 / 3 ..., a = omega h
        assert row["period_s"] / row["exact_period_s"] == pytest.approx(1 + a * a / 3, abs=a**4 / 10), row["what"]


def test_the_spring_by_pbd_has_a_period_that_falls_with_the_iterations(rows_of):
    one, five, ten = [row["period_s"] for row in rows_of("spring of 2016") if row["what"].startswith("PBD")]
    assert one > 1.5 * five
    assert five > 1.2 * ten


def test_the_force_of_the_chain_is_as_accurate_as_printed_to_a_factor_of_three(rows_of):
    rows = rows_of("chain of 2016")
    assert [row["iterations"] for row in rows] == [50, 100, 1000]
    before = 1
    for row in rows:
        assert 1 / 3 < row["ours"] / row["printed"] < 3, row["iterations"]
        assert row["ours"] == pytest.approx(row["plain_sweep"], rel=0.1), "the order of the sweep matters little"
        assert row["ours"] < before
        before = row["ours"]


def test_the_weight_stretches_a_chain_as_in_a_plain_sweep_and_a_hundred_times_less_with_substeps(rows_of):
    most = {(row["method"], row["substeps"], row["gravity_m_per_s2"], row["dt_s"]): row["most_m"]
            for row in rows_of("weight of 2019")}
    assert most["malha", 1, 10, 0.03] == pytest.approx(322.1, abs=0.1), "printed in the paper, with 100 iterations"
    assert most["malha", 100, 10, 0.03] == pytest.approx(3.2, abs=0.05), "and with 100 substeps"
    for substeps in (1, 100):
        assert most["malha", substeps, 10, 0.03] == pytest.approx(most["plain sweep", substeps, 10, 0.03], rel=1e-4)
    assert most["malha with long_range", 10, 10, 0.03] < 0.02 * 0.19 * 1.05, "the limit, a weight lowered by rounding"


def test_the_strand_is_shorter_with_more_substeps_at_equal_work(rows_of):
    rows = rows_of("strand of 2024")
    newton, = [row["most_m"] for row in rows if row["method"] == "Newton"]
    one, ten, hundred = [row["most_m"] for row in rows  # with 100 sweeps: 1 x 100, 10 x 10, 100 x 1
                         if row["method"] == "malha" and row["substeps"] * row["iterations"] == 100]
    assert one > 5 * ten
    assert ten > 5 * hundred
    assert hundred > 5 * newton, "none of them has converged"


def test_the_sheets_have_the_particles_of_the_thesis_and_times(rows_of):
    rows = rows_of("sheets of 2008")
    assert [row["particles"] for row in rows] == [289, 506, 506, 2025, 2025]
    assert all(row["frames_per_s"] > 0 and row["setup_s"] > 0 for row in rows)
    dense, sparse = rows[1:3]
    assert dense["strain_max"] == pytest.approx(sparse["strain_max"], rel=1e-3), "the filter's storage changes nothing but time"


def test_the_cloth_of_1364_vertices_does_not_intersect_itself(rows_of):
    rows = rows_of("cloth of 2006")
    assert rows
    for row in rows:
        assert row["particles"] == 1364
        assert row["crossings"] == 0
        assert row["most_contacts"] > 0


def test_each_case_has_sentences_and_a_table(folder, result):
    assert len(result["sections"]) == 6
    for section in result["sections"]:
        assert len(section["sentences"]) >= 2, section["title"]
        assert section["rows"], section["title"]
        assert all(len(row) == len(section["columns"]) for row in section["rows"])
        if section["chart"]:
            assert (folder / f"{section['chart']}.svg").exists() and (folder / f"{section['chart']}.png").exists()
    assert [section["chart"] for section in result["sections"]] == [
        "published_spring", "published_chain", "published_weight", "", "", ""]


def test_the_table_of_all_rows_has_those_of_the_json(folder, result):
    with open(folder / "published.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["case"] for row in rows] == [row["case"] for row in result["rows"]]
    for text, row in zip(rows, result["rows"]):
        assert {key for key, field in text.items() if field} == {key for key, value in row.items() if value not in (None, "")}
