# SPDX-License-Identifier: Apache-2.0
"""tools/study/size.py in its quick version: memory per particle, and errors; and what its references promise. Times are never
asserted."""
import json

import numpy as np
import pytest
from conftest import G, quick_study

pytest.importorskip("matplotlib")
reference = pytest.importorskip("_malha_reference")
pytest.importorskip("scipy")
from scipy.special import ellipk  # noqa: E402

import size  # noqa: E402


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    out = quick_study("size", tmp_path_factory.mktemp)
    result = json.loads((out / "size.json").read_text())
    for section in result["sections"]:
        assert (out / f"{section['chart']}.svg").exists()
    return result


def costs(result, method=None):
    """The rows of costs, or those of a method by their particles."""
    rows = [row for row in result["rows"] if "measures" not in row]
    return rows if method is None else {row["particles"]: row for row in rows if row["method"] == method}


def errors(result, measures, method, mesh="grid"):
    """The rows of a method on a mesh by their side."""
    return {row["side"]: row for row in result["rows"] if row.get("measures") == measures and row["method"] == method
            and row["mesh"] == mesh}


def bytes_a_particle(row, owner="bytes"):
    return row[owner] / row["particles"]


def test_pbd_takes_as_much_memory_a_particle_from_10000_on(result):
    rows = costs(result, "PBD, 10 substeps")
    assert bytes_a_particle(rows[20164]) / bytes_a_particle(rows[10000]) == pytest.approx(1, abs=0.03), "patches differ a little"
    # x with its rounding remainder, v, displacement and w: 52; and places as the host reads them: 24.
    assert bytes_a_particle(rows[10000], "bytes_by_owner_particles") == pytest.approx(76, abs=0.5)


def test_a_dense_filter_takes_half_the_square_of_its_unknowns(result):
    unknowns = 34 * 33  # one row is pinned
    filter_bytes = costs(result, "Desbrun, dense")[34 * 34]["bytes_by_owner_filter"]
    assert filter_bytes / (2 * unknowns**2) == pytest.approx(1, abs=0.1), "panels of four rows are padded up to 16"


def test_a_sparse_filter_grows_a_little_faster_than_its_unknowns(result):
    rows = costs(result, "Desbrun, sparse")
    small, large = (bytes_a_particle(rows[count], "bytes_by_owner_filter") for count in (2116, 20164))
    assert small < large < 1.5 * small, "n log n: with ten times as many, log2(20164) / log2(2116) = 1.3"


def test_the_process_grows_by_about_what_its_owners_take(result):
    for row in costs(result):
        if row["particles"] >= 10000:
            assert row["held_bytes"] == pytest.approx(row["bytes"], rel=0.3)
            assert row["peak_bytes"] is None or row["peak_bytes"] >= row["held_bytes"]


def test_there_are_time_memory_and_set_up_of_every_size_that_fits(result):
    assert len(result["sections"]) == 7
    assert len(costs(result)) == 10
    for section in result["sections"][:3]:
        assert len(section["rows"]) == len(costs(result))
        assert {row[0] for row in section["rows"]} == set(size.METHODS)
    for row in costs(result):
        assert row["setup_s"] > 0 and 0 < row["step_least_s"] <= row["step_s"] <= row["step_most_s"]


def test_what_does_not_fit_into_memory_is_left_out(monkeypatch):
    monkeypatch.setattr(size, "available_bytes", lambda: 2**30)
    assert size.measured_cost("PBD, 10 substeps", 2000, True) == {"left_out": "it takes 2.42 GiB, and 1 GiB are free"}


@pytest.mark.parametrize("mesh", ["grid", "irregular"])
def test_sweeps_stretch_with_the_side_and_levels_do_not(result, mesh):
    pbd, levels = (errors(result, "error", method, mesh) for method in ("PBD", "levels"))
    assert levels[17]["levels"] > 1 and levels[80]["levels"] > 2
    # The ratio of the sides is five.
    assert pbd[80]["strain_rms"] / pbd[17]["strain_rms"] > 4
    assert levels[80]["strain_rms"] / levels[17]["strain_rms"] < 2.5
    assert levels[80]["strain_rms"] < pbd[80]["strain_rms"]
    assert levels[80]["error_m"] < pbd[80]["error_m"]


def test_the_work_for_a_strain_of_a_hundredth_is_found(result):
    for method in ("PBD", "XPBD", "levels", "long_range"):
        for mesh in ("grid", "irregular"):
            rows = errors(result, "work", method, mesh)
            assert set(rows) == {17, 33}
            for row in rows.values():
                assert row["left_out"] is None and row["strain_rms"] <= 0.01, row
    rows = errors(result, "work", "PBD")
    assert rows[33]["count"] > rows[17]["count"]


def test_filtered_bending_is_right_at_every_resolution(result):
    error = {(method, along): row["error_m"] for method in size.BENDING
             for along, row in errors(result, "bending", method).items()}
    assert error["filtered", 12] < 0.01 and error["filtered", 36] < 0.01
    assert error["projected", 12] < 0.02 and error["projected", 36] > 0.2
    assert error["Desbrun", 36] > 0.2, "its springs hold the strip up"
    assert len(result["sections"][-1]["rows"]) == 6


# ---- References ------------------------------------------------------------------------------------------------------


def test_a_chain_of_one_link_is_a_pendulum():
    """Released from the horizontal, its speed at the bottom is sqrt(2 g l), which it reaches after K(sin 45 deg) sqrt(l / g)."""
    l, steps = 2, 20000
    chain = reference.Chain(1, l, G)
    chain.advance(ellipk(0.5) * np.sqrt(l / G) / steps, steps)
    # The leapfrog method is of second order in the step, and starts with a velocity half a step too early.
    assert chain.joints[1] == pytest.approx([-l, 0], abs=1e-3)
    assert 2 * chain.kinetic == pytest.approx(G * l, rel=2e-3), "the last joint has half of the mass, here 1/2 kg"


def test_a_chain_keeps_its_length_and_its_energy():
    l, links, h = 2, 40, 1e-4
    chain, before, worst, most = reference.Chain(links, l, G), 0.0, 0.0, 0.0
    for _ in range(10000):
        chain.advance(h, 1)
        potential, kinetic = chain.potential, chain.kinetic
        worst = max(worst, abs(kinetic + (before + potential) / 2))  # at the middle of a step; it is 0 at the start
        before, most = potential, max(most, kinetic)
    assert worst < 0.01 * most, "the tip accelerates strongly after 0.8 s, within some ten steps"
    assert np.linalg.norm(np.diff(chain.joints, axis=0), axis=1) == pytest.approx(l / links, abs=1e-10)


def test_an_elastica_under_a_small_load_is_a_beam():
    assert reference.heavy_elastica(1e-3, 10)[-1, :2] == pytest.approx([1, 1e-3 / 8], rel=1e-4)  # q L^4 / (8 B)


@pytest.mark.parametrize("side", [3, 20])
def test_an_irregular_sheet_is_whole_and_its_triangles_are_well_shaped(side):
    points, faces = size.irregular_sheet(side)
    assert points.shape == (side**2, 3) and len(faces) == 2 * (side - 1)**2
    a, b, c = points[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    assert np.all(normals[:, 1] > 0) and np.sum(normals[:, 1]) == pytest.approx(size.SIDE**2)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    assert np.all(count <= 2) and np.sum(count == 1) == 4 * (side - 1), "the border"
    inner = np.all((points[:, ::2] > 0) & (points[:, ::2] < size.SIDE), axis=1)
    valence = np.bincount(edges.ravel())[inner]
    assert valence.min() >= 4 and valence.max() <= 9
    assert side == 3 or np.sum(valence != 6) > 100, "it is irregular"
