"""The pages' Python runs as it stands there."""
import re

import numpy as np
from conftest import ROOT


def test_the_code_of_the_page_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    text = (ROOT / "tools" / "python" / "README.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) == 3
    names = {}
    for block in blocks:
        exec(block, names)  # the page's own code
    assert names["simulation"].time == 2 and len(names["rod"]) == 2
    assert np.allclose(names["square"].positions[:2], names["points"][:2]), "the pinned edge stays"
