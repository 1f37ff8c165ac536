# SPDX-License-Identifier: Apache-2.0
"""The Python code of the pages runs unchanged."""
import re

import numpy as np
from conftest import ROOT


def blocks_of(page, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(), re.S)


def test_the_code_of_the_first_page_runs(monkeypatch, tmp_path, capsys):
    (sheet,) = blocks_of("README.md", "json")
    (tmp_path / "sheet.json").write_text(sheet)
    monkeypatch.chdir(tmp_path)
    (code,) = blocks_of("README.md", "python")
    names = {}
    exec(code, names)  # the page's own code
    assert names["simulation"].time >= 2 and names["simulation"].positions.shape == (289, 3)
    assert names["simulation"].positions[:, 1].min() < -0.3, "the sheet has swung down"
    assert len(capsys.readouterr().out.split()) == 5


def test_the_code_of_the_page_runs(monkeypatch, tmp_path):
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    blocks = blocks_of("tools/python/README.md", "python")
    assert len(blocks) == 5
    names = {}
    for block in blocks:
        exec(block, names)  # the page's own code
    simulation = names["simulation"]
    before = simulation.steps
    assert simulation.step(120, callback=lambda s: s.positions[:, 1].min() > 1e3) == 1, "as the page has it, it ends"
    assert simulation.steps == before + 1
    assert simulation.time == 2 + 1 / 60 or simulation.steps == 121 and len(names["rod"]) == 2
    assert np.allclose(names["square"].positions[:2], names["points"][:2]), "the pinned edge stays"
    assert names["played"].positions[0, 1] > 0.2, "the tray lifts the ball"
    assert len(names["table"]) == 6 and set(names["table"]["status"]) == {"finished"}
