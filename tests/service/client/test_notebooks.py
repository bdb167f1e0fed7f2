"""Notebooks run from top to bottom; objects show as tables, and a refusal as its own last line."""

import os
import re
import traceback
from pathlib import Path
from typing import Any

import nbformat
import pytest
from docs.computed import is_of_here
from docs.executed import NOTEBOOKS, execute, lasting
from tests.ready import ready

from damperlab import Client, Study
from damperlab.service.client import Refused

FIGURES = {"figure-11": 2, "tuned-mass-damper": 2}
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


def html(shown: Any) -> str:
    """Give what a notebook shows; every tag is closed, and one of ours."""
    text = str(shown._repr_html_())
    opened, closed = (sorted(re.findall(tag, text)) for tag in (r"<(\w+)", r"</(\w+)"))
    assert opened == closed
    assert set(opened) <= {"div", "strong", "table", "tr", "th", "td"}
    return text


def test_a_definition_shows_its_axes_and_escapes_its_name() -> None:
    study = Study(name="<script>", particle=False, axes={"friction_ratio": 0, "frequency_ratio": [1, 2, 3]})
    text = html(study)
    assert "&lt;script&gt;" in text
    assert "1 to 3, 3 values" in text


def test_objects_of_a_service_show_what_they_are(service: Any, curve: dict[str, Any]) -> None:
    with Client(service.url) as client:
        assert service.url in html(client)
        study = client.study(curve["id"])
        assert "done" in html(study)
        assert curve["id"] in html(study.record)
        assert "amplitude_ratio" in html(client.simulate(2.0, particle=False))


def test_a_refusal_ends_with_its_message_and_shows_no_frame_of_the_retries(service: Any) -> None:
    with Client(service.url) as client, pytest.raises(Refused) as refused:
        client.submit({"axes": {"frequency_ratio": -1}, "particle": False})
    lines = traceback.format_exception(refused.value)
    assert not [line for line in lines if "stamina" in line or "tenacity" in line or "contextlib" in line]
    assert "axes.frequency_ratio" in lines[-1]
    assert refused.value.__cause__ is None


LINES = (
    ("Study(axes={'clearance_ratio': [-1]})", "StudyFaults", "clearance_ratio[0]"),
    ("Client('http://127.0.0.1:9', timeout=1).study('x')", "Unreachable", "127.0.0.1:9"),
    ("Client('htp:/x')", "Refused", "http://HOST:PORT"),
    ("open_store('.').find('nobody')", "StudyNotFound", "nobody"),
)


def test_a_notebook_shows_the_users_own_lines_and_the_message(tmp_path: Path) -> None:
    cells = [f"def mine():\n    return {line}\nmine()" for line, _, _ in LINES]
    program = (
        "get_ipython().run_cell('from damperlab import Client, Study, open_store')\n"
        f"for cell in {cells!r}:\n    get_ipython().run_cell(cell)\n    print('end of a cell')\n"
    )
    with (tmp_path / "printed").open("w+") as printed:
        settings = os.environ | {"IPYTHONDIR": str(tmp_path)}
        options = ["--colors=NoColor", "--HistoryManager.enabled=False", "-c", program]
        ready().loaded.fork("IPython", options, settings, out=printed, folder=tmp_path).wait(600.0)
        printed.seek(0)
        shown = printed.read().split("end of a cell")[:-1]
    for text, (line, name, said) in zip(shown, LINES, strict=True):
        assert f"{name}: " in text, line
        assert said in text
        places = [one for one in text.splitlines() if one.startswith('  File "')]
        assert len(places) == 2
        assert all("ipython-input" in place for place in places)
        assert "mine()" in text
