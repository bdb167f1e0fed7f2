"""The notebooks run from top to bottom against a real service, and print and draw what is kept in them."""

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from docs.computed import is_of_here
from docs.executed import NOTEBOOKS, execute, lasting

FIGURES = {"figure-11": 2, "robust-design": 2, "tuned-mass-damper": 2}
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def texts_of(notebook: Any, exact: bool) -> list[str]:
    """Give what a notebook prints; numbers only where every digit is the same: chaotic responses differ between processors."""
    found = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            found.append(re.sub(r"\s+", " ", text if exact else NUMBER.sub("#", text)))
    return found


def pictures_of(notebook: Any) -> int:
    return sum(
        "image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])
    )


def test_every_notebook_is_known_here_and_kept_with_its_figures() -> None:
    assert {path.stem for path in NOTEBOOKS.glob("*.ipynb")} == set(FIGURES)
    for path in NOTEBOOKS.glob("*.ipynb"):
        assert pictures_of(nbformat.read(path, as_version=4)) == FIGURES[path.stem]


# the kernel's own sockets and event loops are not this project's
@pytest.mark.night
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", FIGURES)
def test_notebook_runs(service: Any, name: str, tmp_path: Path) -> None:
    done = execute(NOTEBOOKS / f"{name}.ipynb", service.url, tmp_path)
    outputs = [output for cell in done.cells for output in cell.get("outputs", [])]
    # the bar of the notebook, and nothing on standard error
    assert any("<progress" in output.get("data", {}).get("text/html", "") for output in outputs)
    assert not [output for output in outputs if output.get("name") == "stderr"]
    kept = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    assert pictures_of(done) == FIGURES[name]
    exact = is_of_here(f"docs/notebooks/{name}.ipynb")
    assert texts_of(lasting(done), exact) == texts_of(kept, exact)  # `make docs-figures` renews what is kept
