"""What a notebook shows: objects as escaped tables, and a refusal as its own last line."""

import os
import subprocess
import sys
import traceback
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from damperlab import Client, Study
from damperlab.service.client import Refused


class _Balanced(HTMLParser):
    """Fails on a tag that is not closed, or on one that is not ours."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in ("div", "strong", "table", "tr", "th", "td"), tag
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def html(shown: Any) -> str:
    text = str(shown._repr_html_())
    parser = _Balanced()
    parser.feed(text)
    assert parser.open == []
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
    script = (
        "from IPython.core.interactiveshell import InteractiveShell\n"
        "shell = InteractiveShell(colors='nocolor')\n"
        "shell.run_cell('from damperlab import Client, Study, open_store')\n"
        f"for cell in {cells!r}:\n    shell.run_cell(cell)\n    print('end of a cell')\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=os.environ | {"HOME": str(tmp_path)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    shown = ended.stdout.split("end of a cell")[:-1]
    for text, (line, name, said) in zip(shown, LINES, strict=True):
        assert f"{name}: " in text, line
        assert said in text
        places = [one for one in text.splitlines() if one.startswith('  File "')]
        assert len(places) == 2
        assert all("ipython-input" in place for place in places)
        assert "mine()" in text
