# SPDX-License-Identifier: Apache-2.0
"""The Python code of the pages runs unchanged."""
import re

import numpy as np
from conftest import ROOT


def test_the_code_of_the_page_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    text = (ROOT / "tools" / "python" / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) == 4
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
