# SPDX-License-Identifier: Apache-2.0
"""The docstrings are pages: Sphinx renders them without a warning, and every public name is on them."""
import inspect
import os
import subprocess
import sys

import pytest
from conftest import ROOT

import malha

pytest.importorskip("sphinx", reason="Sphinx is missing; tools/setup python installs it")


def test_the_pages_hold_every_public_name(tmp_path):
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", str(tmp_path / "trees"),
                           str(ROOT / "tools" / "python" / "reference"), str(tmp_path / "pages")],
                          capture_output=True, text=True, check=False, env=os.environ)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "pages" / "index.html").read_text()
    for name in malha.__all__:
        assert f'id="malha.{name}"' in page, name
        thing = getattr(malha, name)
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for member in vars(thing):
                assert member.startswith("_") or f'id="malha.{name}.{member}"' in page, (name, member)
