# SPDX-License-Identifier: Apache-2.0
"""malha study validation: its master curves have published values, and those of other derivations; its results agree
with each other, and a missing module is named."""
import csv
import html
import json
import os
import subprocess
import sys
import types

import numpy as np
import pytest

pytest.importorskip("matplotlib")
scipy = pytest.importorskip("scipy")
from scipy.integrate import quad, solve_ivp  # noqa: E402
from scipy.linalg import eigh  # noqa: E402
from scipy.optimize import brentq, fsolve  # noqa: E402

import validation  # noqa: E402
from conftest import run_study  # noqa: E402


def run(*words, **variables):
    environment = {**os.environ, "MALHA_PYTHON": sys.executable, **variables}
    return subprocess.run([os.environ["MALHA_COMMAND"], "study", "validation", *map(str, words)], capture_output=True,
                          text=True, check=False, env=environment)


# ---- The cantilever --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma, ratio", [(1, 0.1246), (10, 1.067), (100, 5.888), (1000, 21.34)])
def test_a_heavy_elastica_has_the_aspect_ratio_of_the_protocol(gamma, ratio):
    assert validation.heavy_elastica(gamma) == pytest.approx(ratio, rel=5e-4)


def test_a_heavy_elastica_is_a_beam_under_a_small_load():
    assert validation.heavy_elastica(1e-3) == pytest.approx(1e-3 / 8, rel=1e-5)  # q L^4 / (8 B)


@pytest.mark.parametrize("gamma", [0.3, 5, 40])
def test_a_heavy_elastica_is_found_by_shooting_too(gamma):
    def shot(slope):
        return solve_ivp(lambda s, y: [y[1], gamma * (1 - s) * np.cos(y[0]), np.sin(y[0]), np.cos(y[0])], (0, 1),
                         [0, -slope, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]

    end = shot(brentq(lambda slope: shot(slope)[1], 0, gamma))
    assert validation.heavy_elastica(gamma) == pytest.approx(-end[2] / end[3], rel=1e-5)


# ---- Bend and twist --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("curl", [0.5 * np.pi, np.pi, 2 * np.pi])
def test_a_curved_ribbon_sags_under_a_small_load_as_the_torque_of_its_weight_says(curl):
    """Castigliano: the torques of the weight and of a unit force at the end, over the rigidity of torsion, 2 D."""
    def place(s):
        return np.array([np.sin(curl * s), 1 - np.cos(curl * s)]) / curl

    def torque(s, at):  # about the tangent at s, of a unit force down at `at`
        arm, tangent = place(at) - place(s), np.array([np.cos(curl * s), np.sin(curl * s)])
        return arm[0] * tangent[1] - arm[1] * tangent[0]

    sag = quad(lambda s: quad(lambda at: torque(s, at), s, 1)[0] * torque(s, 1) / 2, 0, 1)[0]
    assert validation.sag_of_ribbon(curl, 0.01, 1e-3) / 0.01 == pytest.approx(sag, rel=3e-3)


def test_a_ribbon_that_may_not_stretch_sags_as_one_that_may_where_it_twists_little():
    for curl, gammas in validation.CURLS.items():
        for gamma in gammas:
            may, may_not = (validation.sag_of_ribbon(curl * np.pi, gamma, 0.2, flag) for flag in (False, True))
            assert may_not < may < 1.02 * may_not


# ---- Lateral buckling ------------------------------------------------------------------------------------------------


def beam_buckling_load(depth, poisson=0.0, count=120):
    """The same load by a beam: lateral bending, torsion, and the warping that the clamp hinders; by Hermite elements."""
    h, (x, weights) = 1 / count, np.polynomial.legendre.leggauss(4)
    x, weights = (x + 1) / 2, weights / 2
    stiff, load = np.zeros((2, 2 * count + 2, 2 * count + 2))
    bending, torsion = 1 - poisson**2, 2 * (1 - poisson)
    for element in range(count):
        at = slice(2 * element, 2 * element + 4)
        for u, weight in zip(x, weights):
            n0 = np.array([1 - 3 * u**2 + 2 * u**3, h * (u - 2 * u**2 + u**3), 3 * u**2 - 2 * u**3, h * (u**3 - u**2)])
            n1 = np.array([-6 * u + 6 * u**2, h * (1 - 4 * u + 3 * u**2), 6 * u - 6 * u**2, h * (3 * u**2 - 2 * u)]) / h
            n2 = np.array([-6 + 12 * u, h * (-4 + 6 * u), 6 - 12 * u, h * (6 * u - 2)]) / h**2
            moment = (1 - (element + u) * h)**2 / 2
            stiff[at, at] += weight * h * (depth**2 / 12 * np.outer(n2, n2) + torsion * np.outer(n1, n1))
            load[at, at] += weight * h * moment**2 / bending * np.outer(n0, n0)
    return 1 / np.sqrt(eigh(load[2:, 2:], stiff[2:, 2:], eigvals_only=True)[-1])


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_a_shallow_plate_buckles_as_the_beam_of_timoshenko_and_gere(poisson):
    beam = 12.85 * np.sqrt(2 * (1 - poisson) * (1 - poisson**2))
    assert beam_buckling_load(0.01, poisson) == pytest.approx(beam, rel=0.01)
    # The share 0.65 times the depth is warping, as in the next test.
    assert validation.buckling_load(0.05, poisson, 14, 8) == pytest.approx(1.0325 * beam, rel=0.01)


@pytest.mark.parametrize("depth", [0.1, 0.2, 0.5])
def test_a_deep_plate_buckles_as_a_beam_whose_warping_is_hindered(depth):
    assert validation.buckling_load(depth) == pytest.approx(beam_buckling_load(depth), rel=0.01)
    assert validation.buckling_load(depth) == pytest.approx(validation.buckling_load(depth, 0.0, 9, 6), rel=3e-3)


# ---- Stick and slip --------------------------------------------------------------------------------------------------


def test_a_pressed_strip_begins_with_eulers_load_and_its_mode():
    assert validation.TANGENT**2 == pytest.approx(20.19, rel=1e-4)  # of a column that is clamped and hinged
    pressed, ratio = validation.force_ratio(0)
    # The moment at the clamp is the horizontal force times L: B w''(0) = H L in the mode of the column.
    slope = quad(lambda s: validation.pinned_mode(s)[1]**2, 0, 1)[0]
    assert ratio[1] / np.sqrt(pressed[1]) == pytest.approx(np.sqrt(2 / slope) * validation.TANGENT, rel=2e-2)
    assert np.all(np.diff(ratio) > 0)


@pytest.mark.parametrize("gamma, pressed", [(0, 0.15), (0, 0.3), (5, 0.2)])
def test_the_forces_on_a_pressed_strip_are_found_by_shooting_too(gamma, pressed):
    def end(unknown, pressed):
        slope, V, H = unknown
        y = solve_ivp(lambda s, y: [y[1], -(V - gamma * (1 - s)) * np.sin(y[0]) - H * np.cos(y[0]), np.sin(y[0]), np.cos(y[0])],
                      (0, 1), [0, slope, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]
        return [y[1], y[2], y[3] - 1 + pressed]

    found = [5, 21 + gamma / 2, -4]
    for at in np.linspace(0.15, pressed, 7):
        found, _, status, message = fsolve(end, found, at, full_output=True)
        assert status == 1, message
    assert np.interp(pressed, *validation.force_ratio(gamma)) == pytest.approx(abs(found[2] / found[1]), rel=2e-3)


@pytest.mark.parametrize("substeps, iterations, right", [(6, 1, False), (8, 1, True), (3, 4, False), (4, 4, True)])
def test_friction_holds_with_the_substeps_below_which_malha_warns(substeps, iterations, right):
    """The boundary of the warning that tests/report/warnings_test.cpp tests: WarningOfFriction."""
    pressed = validation.pressed_at_slip(types.SimpleNamespace(threads=1), "plate, filtered", "irregular", 24, substeps, 0.1, 0,
                                         iterations=iterations)
    assert (abs(np.interp(pressed, *validation.force_ratio(0)) / 0.1 - 1) < 0.1) == right


# ---- The study -------------------------------------------------------------------------------------------------------


def test_the_quick_version_writes_results_that_agree_with_each_other_and_measures_nothing_twice(tmp_path):
    first = run("--quick", "--out", tmp_path)
    assert first.returncode == 0, first.stderr
    result = json.loads((tmp_path / "validation.json").read_text())
    with open(tmp_path / "validation.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(result["rows"]) > 0
    assert {row["protocol"] for row in rows} == set(validation.PROTOCOLS)
    for row in rows:
        bar = validation.PROTOCOLS[row["protocol"]].bar
        if row["value"]:  # by default an error is a share of the reference
            assert float(row["error"]) > 0 or row["value"] == row["reference"]
        assert (row["within"] == "true") == (row["error"] != "" and float(row["error"]) <= bar)
    best, every = result["sections"][:2]
    place = {name: number for number, name in enumerate(every["columns"])}
    resolved = [row for row in rows if row["resolved"] == "true"]
    for line in every["rows"]:
        own = [row for row in resolved if all(row[key] == line[place[key]] for key in ("protocol", "method", "mesh", "cells", "substeps"))]
        assert own and (line[place[""]] == "passed") == all(row["within"] == "true" for row in own), line
        if line[place["largest error"]].endswith("%"):
            worst = 100 * max(float(row["error"]) for row in own)
            assert float(line[place["largest error"]].split()[0]) == pytest.approx(worst, rel=0.06), line
    assert {tuple(line[:3]) for line in best["rows"]} == {(row["protocol"], row["method"], row["mesh"]) for row in resolved}
    table = {}
    protocol = None
    for line in (tmp_path / "validation.md").read_text().splitlines()[4:]:
        name, method, *fields = (field.strip() for field in line.strip("|").split("|"))
        protocol = name.rpartition(",")[0] or protocol
        table[protocol, method] = {field for field in "; ".join(filter(None, fields)).split("; ")}
    expected = {}
    for name, method, mesh, cells, _, passed, error, _ in best["rows"]:
        words = f"{error} ({cells}" if passed == "passed" else f"*{error}* ({cells}"
        expected.setdefault((name, method), set()).add(words + (")" if mesh in ("grid", "irregular") else f", {mesh})"))
    assert table == expected
    page = (tmp_path / "index.html").read_text()
    for section in result["sections"]:
        assert f"<h3>{html.escape(section['title'])}</h3>" in page
        if section["chart"]:
            assert (tmp_path / f"{section['chart']}.svg").exists() and (tmp_path / f"{section['chart']}.png").exists()
    journal = (tmp_path / "validation.quick.cells.jsonl").read_bytes()
    # Again, by the script, which can be asked for some protocols: one with charts of curves and one with errors.
    some = ["stick and slip", "bounces"]
    again = run_study("validation", "--quick", "--out", tmp_path, "--only", *some)
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "validation.quick.cells.jsonl").read_bytes() == journal
    assert json.loads((tmp_path / "validation.json").read_text())["rows"] == [
        row for row in result["rows"] if row["protocol"] in some]


@pytest.mark.parametrize("missing", ["scipy", "matplotlib"])
def test_a_missing_module_is_named_with_what_installs_it(tmp_path, missing):
    (tmp_path / f"{missing}.py").write_text(f"raise ModuleNotFoundError(\"No module named '{missing}'\", name='{missing}')\n")
    ended = run("--quick", "--out", tmp_path / "out", PYTHONPATH=f"{tmp_path}:{os.environ['PYTHONPATH']}")
    assert ended.returncode == 4
    how = (f"sudo apt-get install python3-{missing}" if sys.prefix == "/usr" else  # Debian's own Python, or an environment
           f"{sys.executable} -m pip install {missing}")
    assert f"found no Python module {missing} in {sys.executable}; to install: {how}\n" in ended.stderr
    assert "Traceback" not in ended.stderr and not (tmp_path / "out").exists()


def test_a_missing_python_is_named_with_what_installs_it(tmp_path):
    ended = run("--out", tmp_path / "out", MALHA_PYTHON=str(tmp_path / "python3"))
    assert ended.returncode == 4
    assert f"found no Python that starts as {tmp_path / 'python3'}" in ended.stderr
    assert ended.stderr.endswith(
        "; to install one: sudo apt-get install python3 python3-numpy python3-scipy python3-matplotlib\n")


def test_a_share_has_whole_protocols(tmp_path):
    ended = run("--quick", "--share", "1000/1000", "--out", tmp_path)
    assert ended.returncode == 0 and ended.stdout.startswith("share       1000/1000 of validation: 0 cells in "), ended.stderr
