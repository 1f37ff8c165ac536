# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and finds the result that it states."""
import pathlib
import runpy
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

pytest.importorskip("matplotlib", reason="matplotlib is missing; tools/setup python installs it")
pytest.importorskip("scipy", reason="scipy is missing; tools/setup python installs it")

EXAMPLES = ROOT / "tools" / "python" / "examples"
CHARTS = {"substeps": ".svg", "fit": ".svg", "gallery": ".png", "frames": ".svg", "swimmer": ".svg"}


def run_example(name, folder, *words):
    done = subprocess.run([sys.executable, str(EXAMPLES / f"{name}.py"), "--out", f"chart{CHARTS[name]}", *words],
                          capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / f"chart{CHARTS[name]}").stat().st_size > 5000
    return done.stdout


def test_there_is_no_other_example():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == CHARTS.keys()


def test_substeps_lower_the_error(tmp_path):
    run_example("substeps", tmp_path)
    example = runpy.run_path(str(EXAMPLES / "substeps.py"))
    error = example["errors"](1e-3, [10, 40, 160], truth=640)
    assert error[0] > error[1] > error[2] > 0


def test_a_fit_finds_the_compliance_that_made_the_sag(tmp_path):
    assert "a sag of 0.2 m: compliance" in run_example("fit", tmp_path, "--sag", "0.2")
    example = runpy.run_path(str(EXAMPLES / "fit.py"))
    assert example["fit"](example["sag"](2e-3)) == pytest.approx(2e-3, rel=1e-3)


def test_a_gallery_shows_both_methods(tmp_path):
    said = run_example("gallery", tmp_path)
    assert "XPBD" in said and "Desbrun" in said


def test_frames_are_read_as_they_were_written(tmp_path):
    assert "181 frames of 315 vertices" in run_example("frames", tmp_path, "--run", "run")
    frames = runpy.run_path(str(EXAMPLES / "frames.py"))["read_pc2"](pathlib.Path(tmp_path, "run/frames/points_flag.pc2"))
    assert frames.shape == (181, 315, 3) and np.isfinite(frames).all()
    assert np.ptp(frames[:, 0], axis=0).max() < 1e-6, "a pinned corner stays"


def test_a_cloth_rides_on_a_mat_that_numpy_moves(tmp_path):
    assert "mm above the mat" in run_example("swimmer", tmp_path)
    example = runpy.run_path(str(EXAMPLES / "swimmer.py"))
    times, cloth, under, simulation = example["swim"](120)
    above = simulation.positions[:, 1] - example["waved"](simulation.positions, simulation.time)[:, 1]
    assert above.min() > 0.005, "nothing is under the mat, whose thickness is 10 mm"
    assert np.abs(cloth - under)[30:].max() < 0.05 and np.ptp(under) > 0.05
