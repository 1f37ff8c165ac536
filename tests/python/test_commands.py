# SPDX-License-Identifier: Apache-2.0
"""malha.tune and malha.study are the commands of those names."""
import json
import pathlib

import pytest
from conftest import ROOT, cloth, said_by_command, scene_of

import malha


def rows_of(table):
    return table if isinstance(table, list) else table.to_dict("records")


@pytest.fixture(autouse=True)
def built():
    if not (pathlib.Path(malha.__file__).parent / "malha_measures").exists():
        pytest.skip("malha_measures was not built; tools/build builds it")


def test_tune_finds_a_scene_that_reaches_the_error():
    given = scene_of(cloth(cells=6, constraints=[{"type": "distance", "compliance": 1e-4}]), substeps=40)
    found = malha.tune(given, error=0.01, seconds=0.1, threads=1)
    trials = rows_of(found["trials"])
    best = trials[found["best"]]
    assert best["found"] == "reaches" and best["error_m"] <= 0.01 and found["error_m"] == 0.01 and found["seconds"] == 0.1
    assert best["ms_per_s"] <= min(1.5 * row["ms_per_s"] for row in trials if row["found"] == "reaches")
    tuned = found["scene"].to_dict()
    assert tuned["solver"]["substeps"] == best["substeps"] and tuned["bodies"] == malha.Scene(given).to_dict()["bodies"]
    malha.Simulation(found["scene"]).step()


def test_tune_says_what_it_refuses_in_the_words_of_the_command(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene_of(cloth())))
    status, said = said_by_command("tune", path, "--error", "-1", "--out", tmp_path / "out.json")
    assert status == 2
    with pytest.raises(malha.InputError) as caught:
        malha.tune(path, error=-1)
    assert said.replace("-1", "-1.0").splitlines()[-1] == str(caught.value).splitlines()[-1]
    with pytest.raises(malha.InputError, match="scene: .*/solver/time_budget: found a time budget"):
        malha.tune(scene_of(cloth(), solver={"type": "desbrun", "substeps": 1, "iterations": 1, "time_budget": 1.0}) , error=0.1)
    with pytest.raises(TypeError, match=r"tune: found the keyword 'eror' \(did you mean 'error'\?\); allowed: scene, error"):
        malha.tune(path, eror=0.1)


def test_tune_without_a_reference_says_why():
    stiff = scene_of(cloth(cells=6, constraints=[{"type": "distance", "compliance": 1e-12}]))
    with pytest.raises(RuntimeError, match="^scene: .*(reference did not converge|no method reaches)"):
        malha.tune(stiff, error=1e-9, seconds=0.05, threads=1)


def test_a_study_is_a_table_and_a_page(tmp_path):
    found = malha.study("parsimony", quick=True, out=tmp_path)
    rows = rows_of(found["rows"])
    written = json.loads((tmp_path / "parsimony.json").read_text())
    assert len(rows) == len(written["rows"]) > 10 and rows[0].keys() >= written["rows"][0].keys()
    assert [one["title"] for one in found["sections"]] == [one["title"] for one in written["sections"]]
    assert pathlib.Path(found["page"]).stat().st_size > 1000
    with pytest.raises(malha.InputError, match=r"found .*acuracy.*did you mean 'accuracy'"):
        malha.study("acuracy", out=tmp_path)


def test_the_command_is_of_the_same_version():
    assert pathlib.Path(malha._command()) == pathlib.Path(malha.__file__).parent / "malha"
    assert said_by_command("check", ROOT / "scenes" / "flag.json")[0] == 0
