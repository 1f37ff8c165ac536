# SPDX-License-Identifier: Apache-2.0
"""malha study parsimony: what its quick version finds of launches and bytes. Times are never asserted."""
import json

import pytest
from conftest import quick_study

import malha

pytest.importorskip("matplotlib")
import parsimony as study  # noqa: E402  conftest.py sets its path


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """parsimony.json of a quick run."""
    out = quick_study("parsimony", tmp_path_factory.mktemp)
    return json.loads((out / "parsimony.json").read_text())


@pytest.fixture(scope="module")
def single(result):
    """The rows of each feature alone, by the feature's name."""
    return {row["feature"]: row for row in result["rows"] if row["kind"] == "single"}


def test_scenes_of_the_whole_study_may_start():
    """The quick version has coarser sheets, which may lie deeper in the ball than those of the whole one."""
    for feature, _, _, scene in study.single_features(quick=False):
        if "environment" in scene:
            malha.Simulation(scene).step()
    malha.Simulation(study.feature_ladder(quick=False)[-1][3]).step()


def test_a_bare_cloth_launches_patch_solves_alone(single):
    row = single["nothing"]
    assert row["kernels"] == "SolvePatch<float> 20"  # 10 substeps, 2 colours
    assert row["kernels_added"] == "" and row["added_bytes"] == 0
    assert [row[f"{owner}_bytes"] for owner in ("air", "springs", "filter", "collision")] == [0, 0, 0, 0]


@pytest.mark.parametrize("feature", ["distance on diagonals", "distance_limit", "bending", "isometric_bending", "neo_hookean"])
def test_constraints_of_patches_add_bytes_but_no_launch(single, feature):
    assert single[feature]["kernels_added"] == "" and single[feature]["constraints_bytes_added"] > 0


def test_added_bytes_have_their_owners(single):
    for feature, owner in (("air on faces", "air"), ("levels", "levels"), ("environment (touched)", "collision"),
                           ("self-collision (flat)", "collision"), ("pressure", "constraints")):
        assert single[feature][f"{owner}_bytes_added"] > 0, feature
    # Multipliers are stored between the two halves of a symmetric sweep.
    compliance = single["compliance"]
    assert compliance["constraints_bytes_added"] == compliance["added_bytes"] > 0 and compliance["kernels_added"] == ""
    assert single["drag on particles"]["added_bytes"] == single["sleep (awake)"]["added_bytes"] == 0
    # The contact cache depends on how many particles are near a surface, so its bytes differ from motion to motion.
    assert single["friction"]["kernels_added"] == ""


def test_sleep_adds_a_launch_awake_and_removes_all_asleep(single):
    assert single["sleep (awake)"]["kernels_added"] == "MeasureSpeed<float> 1"
    assert single["sleep (asleep)"]["launches_a_step"] == 0


def test_no_launch_is_lost_on_the_ladder(result):
    rungs = [row for row in result["rows"] if row["kind"] == "ladder"]
    assert len(rungs) > 5 and all(row["kernels_gone"] == "" for row in rungs)
    launches = [row["launches_a_step"] for row in rungs]
    assert launches == sorted(launches)


def test_time_memory_and_the_ladder_are_drawn(result):
    assert all(section["sentences"] and section["rows"] for section in result["sections"])
    assert {section["chart"] for section in result["sections"]} == {"parsimony_time", "parsimony_memory", "", "parsimony_ladder"}
