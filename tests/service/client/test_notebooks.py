"""The notebooks run from top to bottom against a real service, and show what they say they show."""

import os
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parents[3] / "docs" / "notebooks"
FIGURES = {"figure-11": 2, "robust-design": 2, "tuned-mass-damper": 2}
WORDS = {
    "figure-11": "best over the band",
    "robust-design": "best in the worst case: ",
    "tuned-mass-damper": "5 % off: peak",
}


def test_every_notebook_is_known_here_and_kept_without_outputs() -> None:
    assert {path.stem for path in NOTEBOOKS.glob("*.ipynb")} == set(FIGURES)
    for path in NOTEBOOKS.glob("*.ipynb"):
        for cell in nbformat.read(path, as_version=4).cells:
            assert not cell.get("outputs")


# the kernel's own sockets and event loops are not this project's
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", FIGURES)
def test_notebook_runs(service: Any, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    monkeypatch.setitem(os.environ, "DAMPERLAB_URL", service.url)
    monkeypatch.setitem(os.environ, "IPYTHONDIR", str(tmp_path / "ipython"))
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    nbformat.write(notebook, tmp_path / "executed.ipynb")
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    kinds = [set(output.get("data", {})) for output in outputs]
    assert sum("image/png" in kind for kind in kinds) == FIGURES[name]
    texts = "".join(output.get("text", "") for output in outputs)
    assert WORDS[name] in texts
    # the bar of the notebook, and nothing on standard error
    assert any("<progress" in output.get("data", {}).get("text/html", "") for output in outputs)
    assert not [output for output in outputs if output.get("name") == "stderr"]
