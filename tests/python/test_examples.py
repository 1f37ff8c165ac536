# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and finds the result that it states."""
import importlib
import pathlib
import re
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
    assert {path.stem for path in EXAMPLES.glob("*.py")} == CHARTS.keys() | {"drapes"}


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


def test_a_data_set_of_drapes_is_whole_and_made_once(tmp_path, monkeypatch):
    h5py = pytest.importorskip("h5py", reason="h5py is missing; tools/setup python installs it")
    pytest.importorskip("pandas", reason="pandas is missing; tools/setup python installs it")

    def make(count):
        done = subprocess.run([sys.executable, str(EXAMPLES / "drapes.py"), "--count", str(count), "--workers", "2", "--out", "set"],
                              capture_output=True, text=True, cwd=tmp_path, check=False)
        assert done.returncode == 0, done.stderr
        assert f"{count} of {count} drapes in set/drapes.h5" in done.stdout and "; 0 with notes" in done.stdout
        return {path: path.stat().st_mtime_ns for path in tmp_path.glob("set/runs/*/report.json")}

    first = make(3)
    assert first.items() <= make(4).items(), "the first three are not made again"
    monkeypatch.syspath_prepend(EXAMPLES)
    example = importlib.import_module("drapes")
    with h5py.File(tmp_path / "set" / "drapes.h5") as file:
        positions, faces = file["positions"][:], file["faces"][:]
        assert positions.shape == (4, 46, 13 * 48, 3) and faces.shape == (12 * 48, 4)
        parameters = [{name: file[f"parameters/{name}"][number] for name in example.RANGES} for number in range(4)]
        assert parameters == example.drawn(4) and len(set(file["state_hash"][:])) == 4
        bodies = file["body"][:]
    for number, drape in enumerate(positions):
        rest, _ = example.pattern(parameters[number]["length"], parameters[number]["fullness"])
        assert np.allclose(drape[0], rest, atol=1e-6) and np.allclose(drape[:, :48], drape[0, :48], atol=1e-6), "the waist is held"
        sides = np.linalg.norm(drape[:, faces] - drape[:, np.roll(faces, 1, axis=1)], axis=3)
        assert np.abs(sides[-1] / sides[0] - 1).max() < 0.06, "the cloth hardly stretches"
        assert drape[-1, -48:, 1].mean() < drape[0, -48:, 1].mean() - 0.05, "the hem falls"
        for body in bodies[number]:  # distance of each vertex to each capsule
            start, along = body[:3], body[3:6] - body[:3]
            t = np.clip((drape[-1] - start) @ along / max(along @ along, 1e-12), 0, 1)
            assert np.linalg.norm(drape[-1] - start - t[:, None] * along, axis=1).min() > body[6] + 0.003
    thumbnails = re.findall(r'src="([^"]+)"', (tmp_path / "set" / "index.html").read_text())
    assert len(thumbnails) == 4 and all((tmp_path / "set" / one).stat().st_size > 3000 for one in thumbnails)
