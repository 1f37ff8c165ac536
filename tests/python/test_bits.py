# SPDX-License-Identifier: Apache-2.0
"""The Python module gives the same bits as the command, for every shipped scene."""
import json
import subprocess

import pytest
from conftest import COMMAND, ROOT, cloth, scene_of

import malha

STEPS = 15  # a quarter of a second of most: things fall and touch
SCENES = sorted(path.name for path in (ROOT / "scenes").glob("*.json") if path.name != "schema.json")


def test_all_shipped_scenes_are_there():
    assert len(SCENES) >= 25


@pytest.mark.parametrize("name", SCENES)
def test_a_shipped_scene_has_the_bits_of_the_command(name, tmp_path):
    path = ROOT / "scenes" / name
    words = ["run", path, "--steps", STEPS, "--threads", 2, "--every", 0, "--no-picture", "--no-page", "--quiet", "--out",
             tmp_path / "out"]
    subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True)
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    simulation = malha.Simulation(path, threads=1)
    assert simulation.step(STEPS) == STEPS
    assert simulation.state_hash == report["state_hash"]
    assert simulation.time == report["time_s"]


def test_backends_and_threads_have_the_same_bits():
    hashes = set()
    for options in ({"threads": 1}, {"threads": 2}, {"backend": "serial"}, {}):
        simulation = malha.Simulation(scene_of(cloth(cells=50), precision="float"), **options)
        simulation.step(10)
        hashes.add(simulation.state_hash)
    assert len(hashes) == 1


def test_patches_may_be_cut_for_another_machine(tmp_path):
    scene = scene_of(cloth(cells=50), precision="float")
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    planned = subprocess.run([COMMAND, "plan", tmp_path / "scene.json", "--for", "h200", "--json"], check=True, capture_output=True)
    of_h200, of_cpu = (malha.Simulation(scene, threads=1, machine=name).plan()["patches"] for name in ("h200", "cpu"))
    assert of_h200 == json.loads(planned.stdout)["patches"] != of_cpu
    with pytest.raises(malha.InputError, match='machine: found "h20"; allowed: cpu, '):
        malha.Simulation(scene, machine="h20")


def test_a_scene_that_went_through_python_has_the_same_bits():
    scene = malha.Scene(ROOT / "scenes" / "flag.json")
    runs = [malha.Simulation(one, threads=1) for one in (scene, scene.to_dict(), scene.to_json())]
    for run in runs:
        run.step(20)
    assert len({run.state_hash for run in runs}) == 1


def test_a_whole_run_leaves_what_the_command_leaves(tmp_path):
    scene = scene_of(cloth(), outputs={"frames": {"every": 5, "formats": ["pc2"]}}, duration=0.2)
    seen = []
    result = malha.run(scene, tmp_path / "out", threads=1, progress=lambda step, steps, time: seen.append((step, steps)))
    assert result["complete"] and result["failed_expectations"] == []
    assert seen == [(step, 20) for step in range(1, 21)]
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    simulation = malha.Simulation(scene, threads=1)
    simulation.step(20)
    assert report["state_hash"] == simulation.state_hash
    assert (tmp_path / "out" / "frames" / "points_cloth.pc2").exists()
    with pytest.raises(malha.InputError, match="is not before|allowed"):
        malha.run(scene, tmp_path / "out", resume=True)
