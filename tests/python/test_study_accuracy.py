# SPDX-License-Identifier: Apache-2.0
"""malha study accuracy: its quick version finds the orders of convergence, and what theory says of each method; its
references agree with closed forms. Times are never asserted."""
import csv
import json
import math
import re

import numpy as np
import pytest
from conftest import quick_study

pytest.importorskip("matplotlib")
reference = pytest.importorskip("_malha_reference")
import accuracy  # noqa: E402

SPRINGS = ("sheet7", "drum5", "shell", "chain")  # cases of many springs
CASES = ("oscillator", "orbit", *SPRINGS, "catenary", "cantilever", "swing1", "beam", "sunk_beam")
FILTERED = "XPBD, substeps, filtered bending, float"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The results of a quick run."""
    return quick_study("accuracy", tmp_path_factory.mktemp)


@pytest.fixture(scope="module")
def result(folder):
    return json.loads((folder / "accuracy.json").read_text())


@pytest.fixture(scope="module")
def series_of(result):
    """The rows of a case and series at a time, by their settings, without runs that diverged before."""
    def found(case, series, at=1):
        return {row["settings"]: row for row in accuracy.points_at(result["rows"], case, at) if row["series"] == series}
    return found


@pytest.fixture(scope="module")
def error_of(series_of):
    return lambda case, series, settings, at=1: series_of(case, series, at)[settings]["rms_error_m"]


@pytest.fixture(scope="module")
def order_of(series_of):
    return lambda case, series, at=1: accuracy.order_of(list(series_of(case, series, at).values()))


# ---- Orders of convergence -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", ("oscillator", "orbit", *SPRINGS))
def test_the_integrators_have_their_orders(case, order_of, error_of):
    assert order_of(case, "RK4") == pytest.approx(4, abs=0.3)
    # A spring that oscillates five times a second needs more substeps than Newton's method is run with; XPBD with one
    # spring is backward Euler.
    one_spring = case not in SPRINGS
    assert order_of(case, "XPBD, substeps, double" if one_spring else "backward Euler, Newton") == pytest.approx(1, abs=0.35)
    if not one_spring:  # substeps with a symmetric sweep are more accurate than as many of exact backward Euler
        assert error_of(case, "XPBD, substeps, double", "16x1") < 0.6 * error_of(case, "backward Euler, Newton", "16 a frame")


def test_converged_substeps_are_of_second_order_except_at_the_start(error_of):
    def error(series, n):
        return error_of("order", series, str(n), 0.5)

    def slope(series):
        return math.log(error(series, 10) / error(series, 40)) / math.log(4)

    assert slope("the same, to half a substep later") == pytest.approx(2, abs=0.35)
    assert slope("malha, as many iterations as substeps") == pytest.approx(1, abs=0.2)
    for n in (10, 20, 40):
        # The first-order error is due to the whole kick of the first substep: v h / 2 at 3 m/s, RMS.
        assert error("malha, as many iterations as substeps", n) == pytest.approx(3 / 60 / n / 2, rel=0.3)
        assert error("malha, 1 iteration", n) < 0.3 * error("one way, gradients at the end", n)


# ---- Methods ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", (1, 4, 16))
def test_xpbd_of_one_spring_is_backward_euler_unless_it_rotates(n, error_of):
    """With a rotating spring XPBD is more accurate: it moves the ends along their direction at the start of the substep."""
    def ratio(case):
        return error_of(case, "XPBD, substeps, double", f"{n}x1") / error_of(case, "backward Euler, Newton", f"{n} a frame")

    assert ratio("oscillator") == pytest.approx(1, abs=1e-6)
    # One substep a frame hardly resolves the rotation, so that the two directions differ much.
    assert ratio("orbit") < (1.05 if n == 1 else 1)


@pytest.mark.parametrize("case", SPRINGS)
def test_iterations_and_refinement_converge_to_backward_euler(case, error_of):
    # Iterations ignore the rotation of gradients within a step, which causes a part of the step's error.
    assert error_of(case, "XPBD, iterations", "1x256") == pytest.approx(
        error_of(case, "backward Euler, Newton", "1 a frame"), rel=0.05)
    assert error_of(case, "Desbrun, refine, 16 substeps", "16, r = 16") == pytest.approx(
        error_of(case, "backward Euler, Newton", "16 a frame"), rel=0.1)


@pytest.mark.parametrize("case", ("oscillator", "orbit", *SPRINGS, "beam"))
def test_substeps_are_more_accurate_than_iterations_at_equal_work(case, series_of):
    substeps, iterations = series_of(case, "XPBD, substeps, double")["64x1"], series_of(case, "XPBD, iterations")["1x64"]
    assert substeps["sweeps_per_s"] == iterations["sweeps_per_s"]
    assert substeps["rms_error_m"] < iterations["rms_error_m"] / 2


def test_float_is_as_accurate_as_double_with_few_and_with_many_substeps(error_of):
    single, double = ({n: error_of("shell", f"XPBD, substeps, {precision}", f"{n}x1") for n in (4, 256)}
                      for precision in ("float", "double"))
    assert single[256] < 1.5 * double[256]
    assert single[4] == pytest.approx(double[4], abs=1e-3)


def test_the_corrector_by_inertia_conserves_the_momenta_of_a_free_body(result, series_of, error_of):
    def angular(corrector, substeps):
        row = series_of("shell", f"Desbrun, corrector {corrector}")[f"{substeps}, r = 0"]
        return row["angular_momentum_error_kg_m2_per_s"]

    assert angular("inertia", 16) < 1e-10
    assert angular("off", 16) > 0.5 and angular("paper", 64) > 0.5  # of the 0.6 kg m^2/s of the shell
    assert error_of("shell", "Desbrun, corrector inertia", "16, r = 0") > error_of("shell", "XPBD, substeps, double", "16x1")
    for row in accuracy.points_at(result["rows"], "shell", 1):  # all conserve momentum in double
        if not row["series"].endswith(("float", "int16")) and not row["series"].startswith("PBD"):
            assert row["momentum_error_kg_m_per_s"] < 1e-9, row["key"]


def test_the_motion_of_a_taut_sheet_is_known_for_five_seconds(result, error_of, order_of):
    assert accuracy.points_at(result["rows"], "drum5", 5)[0]["truth_known_to_m"] < 1e-9
    assert error_of("drum5", "RK4", "64 a frame", 5) < 1e-8
    assert order_of("drum5", "RK4", 5) == pytest.approx(4, abs=0.3)
    # The motion is not chaotic.
    assert error_of("drum5", "XPBD, substeps, double", "256x1", 5) < error_of("drum5", "XPBD, substeps, double", "16x1", 5) / 4


def test_explicit_euler_gains_the_theoretical_energy(series_of, error_of):
    """Each step multiplies the energy of an undamped mode by 1 + (omega h)^2, with omega^2 = 1000 / s^2."""
    for n in (64, 256):
        h = accuracy.FRAME / n
        growth = (1 + 1000 * h**2)**(60 * n) - 1
        assert series_of("oscillator", "explicit Euler")[f"{n} a frame"]["energy_drift"] == pytest.approx(growth, rel=1e-9)
        assert abs(series_of("oscillator", "symplectic Euler")[f"{n} a frame"]["energy_drift"]) < math.sqrt(1000) * h / 2
    for case in ("oscillator", "orbit", "shell", "chain", "drum5"):
        assert series_of(case, "explicit Euler")["256 a frame"]["energy_drift"] > 0, case
        assert error_of(case, "explicit Euler", "256 a frame") > 2 * error_of(case, "symplectic Euler", "256 a frame"), case


@pytest.mark.parametrize("case", ("sheet7", "drum5", "chain"))
def test_pbd_errs_in_double_as_in_float(case, error_of):
    for settings in ("1x1", "1x16", "1x64"):
        in_double = error_of(case, "PBD, iterations, double", settings)
        assert in_double > 0.01
        assert error_of(case, "PBD, iterations, float", settings) == pytest.approx(in_double, abs=1e-3)


def test_only_explicit_methods_diverge_at_large_steps(result):
    def status(series, settings):
        return [row["status"] for row in result["rows"] if
                (row["case"], row["series"], row["settings"]) == ("sheet7", series, settings)]

    # 451 rad/s in steps of 1/60 s: 2 / omega_max takes 4 substeps.
    assert status("symplectic Euler", "1 a frame") == ["diverged"] and status("symplectic Euler", "4 a frame") == ["finished"]
    assert status("explicit Euler", "16 a frame") == ["diverged"]  # it has no stable step
    for row in result["rows"]:
        assert row["status"] == "finished" or not row["ours"] or row["series"].endswith("paper"), row["key"]


def test_the_elastic_catenary_is_found(error_of):
    own = 5.7e-4  # m: distance of the equilibrium of 8 springs from the continuous line
    for settings in ("1, r = 0", "64, r = 0"):  # for any step
        assert error_of("catenary", "Desbrun, substeps", settings, 5) == pytest.approx(own, abs=1e-5)
    assert error_of("catenary", "XPBD, substeps, double", "64x1", 5) == pytest.approx(own, abs=1e-5)
    assert error_of("catenary", "PBD, iterations, float", "1x16", 5) > 0.05  # PBD has no stiffness in N/m


def test_filtered_bending_finds_the_heavy_elastica_at_the_fewest_substeps(error_of):
    filtered = error_of("cantilever", FILTERED, "4x1", 5)
    assert filtered < 0.02
    assert error_of("cantilever", "XPBD, substeps, float", "4x1", 5) > 5 * filtered
    # Both converge to the equilibrium of the mesh.
    assert error_of("cantilever", FILTERED, "64x1", 5) == pytest.approx(
        error_of("cantilever", "XPBD, substeps, float", "64x1", 5), abs=2e-3)


def test_filtered_bending_swings_as_backward_euler_and_as_the_truth(error_of):
    for n in (1, 4, 16):
        assert error_of("swing1", FILTERED, f"{n}x1", 0.3) == pytest.approx(
            error_of("swing1", "backward Euler, Newton", f"{n} a frame", 0.3), rel=0.15)
    filtered = error_of("swing1", FILTERED, "4x1", 0.3)
    assert filtered < 0.01
    assert error_of("swing1", "XPBD, substeps, float", "4x1", 0.3) > 10 * filtered
    assert error_of("swing1", "Desbrun, substeps", "4, r = 0", 0.3) > 10 * filtered
    # The hinges are a discretisation other than that of the true motion, which many substeps come near all the same.
    for series in (FILTERED, "XPBD, substeps, float"):
        assert error_of("swing1", series, "256x1", 0.3) < 2e-4


# ---- The page --------------------------------------------------------------------------------------------------------


def test_each_case_has_sentences_a_table_and_charts_of_cost_and_work(folder, result):
    for section in result["sections"]:
        assert section["sentences"] and section["rows"], section["title"]
        assert (folder / f"{section['chart']}.svg").exists() and (folder / f"{section['chart']}.png").exists()
        assert all(len(row) == len(section["columns"]) for row in section["rows"])
    charts = {section["chart"] for section in result["sections"]}
    assert {f"accuracy_{case}_{kind}" for case in CASES for kind in ("cost", "work")} | {"accuracy_order"} <= charts
    with open(folder / "accuracy.csv", encoding="utf-8") as file:
        assert [row["key"] for row in csv.DictReader(file)] == [row["key"] for row in result["rows"]]


def test_replays_show_few_substeps_beside_many_and_a_diverging_run_beside_one_that_is_not(folder):
    def runs(name):
        data = re.findall(r'class="run">(.*?)</script>', (folder / name).read_text(), re.S)
        return [json.loads(run)["report"] for run in data]

    assert {path.name for path in folder.glob("*.html")} == {
        "index.html", "accuracy_sheet7_1.html", "accuracy_sheet7_100.html", "accuracy_shell_correctors.html"}
    assert [run["scene"] for run in runs("accuracy_sheet7_1.html")] == ["1 substep", "1024 substeps"]
    assert [run["status"] for run in runs("accuracy_shell_correctors.html")] == ["diverged", "finished"]


# ---- The references --------------------------------------------------------------------------------------------------


def test_all_springs_of_a_taut_sheet_stay_under_tension():
    case = accuracy.drum(5, 128)
    system, sunk = accuracy.system_of(case), 0
    run = reference.Integrator(system, "RK4", system.positions, system.velocities)
    for _ in range(5 * 60 * 64):
        run.advance(accuracy.FRAME / 64, 1)
        assert system.strains(run.positions).min() > 0.05  # of 0.11 at the start
        sunk = max(sunk, -run.positions.min())
    assert sunk > 0.05  # it moves


def test_a_grid_that_bends_comes_to_rest_as_a_heavy_elastica():
    def distance(cells):
        strip = accuracy.cantilever(cells)
        return accuracy.studies.rms_distance(accuracy.system_of(strip).equilibrium(1e-4), strip.exact(0)[0])

    coarse, fine = distance(8), distance(16)
    assert coarse < 0.02
    assert math.log2(coarse / fine) == pytest.approx(2, abs=0.4)  # in the edge, with the clamp at the second row


def test_a_stiff_taut_line_hangs_in_a_parabola():
    line = accuracy.elastic_catenary(1, 1.001, 1, 1e9, 10)
    assert line[10] == pytest.approx([1, 0, 0], abs=1e-12)
    assert -line[5, 1] == pytest.approx(math.sqrt(3 / 8 * 0.001), abs=1e-4)  # length - span = 8/3 sag^2 / span


def test_the_module_refuses_what_it_does_not_have():
    system = accuracy.system_of(accuracy.beam(1))
    for method, x, message in (("RK4", np.zeros((1, 3)), r"found an array \(1, 3\); allowed: \(24, 3\)"),
                               ("leapfrog", system.positions, "allowed: explicit Euler"),
                               ("backward Euler", system.positions, "found tetrahedra; allowed: springs")):
        with pytest.raises(ValueError, match=message):
            reference.Integrator(system, method, x, x)
