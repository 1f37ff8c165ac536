# SPDX-License-Identifier: Apache-2.0
"""The notebook runs from its first cell to its last, and shows what it says."""
import base64

import pytest
from conftest import ROOT

nbformat = pytest.importorskip("nbformat", reason="nbformat is missing; tools/setup python installs it")
nbclient = pytest.importorskip("nbclient", reason="nbclient is missing; tools/setup python installs it")
pytest.importorskip("ipykernel", reason="ipykernel is missing; tools/setup python installs it")
pytest.importorskip("pandas", reason="pandas is missing; tools/setup python installs it")
pytest.importorskip("matplotlib", reason="matplotlib is missing; tools/setup python installs it")

FOLDER = ROOT / "tools" / "python" / "examples"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs(path, monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)  # charts are drawn into the notebook
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "the repository keeps no outputs"
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(FOLDER)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    pictures = [base64.b64decode(output.data["image/png"]) for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 2 and min(map(len, pictures)) > 10000
    words = "".join(output.get("text", "") + output.get("data", {}).get("text/html", "") for output in outputs)
    assert "<malha.Simulation 'cape'" in words and words.count("finished") == 4


def test_there_is_a_notebook():
    assert [path.stem for path in FOLDER.glob("*.ipynb")] == ["mesh_to_chart"]
