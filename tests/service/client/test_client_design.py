"""Designs from Python, over real sockets: asked for, waited for, shown, written, steered."""

import json
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from tests.service.conftest import SPECIFICATION

from damperlab.service.client import Client, Conflict, Design, NotFound, Refused, StillRunning, Stopped


@pytest.mark.night
def test_a_design_is_asked_for_waited_for_and_written(
    remote: Client, design: dict[str, Any], tmp_path: Path
) -> None:
    file = tmp_path / "spec.json"
    file.write_text(json.dumps(SPECIFICATION))
    found = remote.design(file).wait(progress=False)
    assert found == remote.design(SPECIFICATION) == remote.design(file.read_text())
    assert (found.id, found.state) == (design["id"], "done")
    assert found.answer == design["answer"]
    assert found in remote.designs(state="done")
    assert found not in remote.designs(name="no such name")
    amplitudes = found.amplitudes
    assert amplitudes.sizes["amplitude"] == len(design["answer"]["amplitudes"]) >= 1
    assert amplitudes["worst"].values.tolist() == [each["worst"] for each in design["answer"]["amplitudes"]]
    assert amplitudes["value"].attrs["units"] == "m"
    report = found.report(tmp_path / "report.html")
    assert "small &lt;floor&gt;" in report.read_text()
    assert [path.name for path in tmp_path.glob("*.part")] == []
    shown = found._repr_html_()
    assert "small &lt;floor&gt;" in shown
    assert found.answer["verdict"]["sentences"][0] in unescape(shown)


def test_what_is_wrong_with_a_specification_is_told_before_or_after_it_is_sent(remote: Client) -> None:
    with pytest.raises(Refused) as refused:
        remote.design(SPECIFICATION | {"restitution": 2, "nonsense": 1})
    assert {fault.field for fault in refused.value.faults} == {"restitution", "nonsense"}
    for nothing in ("no-such-name", 3):
        with pytest.raises(Refused) as refused:
            remote.design(nothing)  # type: ignore[arg-type]
        assert [fault.field for fault in refused.value.faults] == ["specification"]


def test_a_design_is_stopped_and_deleted(remote: Client, capsys: pytest.CaptureFixture[str]) -> None:
    # too much for a moment: it has not ended when it is looked at
    asked: Design = remote.design(SPECIFICATION | {"clearance_m": 0.0053, "budget_points": 5000})
    for unfinished in (lambda: asked.wait(timeout=0.0), lambda: asked.answer):
        with pytest.raises(StillRunning):
            unfinished()
    assert "5,000 points" in capsys.readouterr().err
    with pytest.raises(Conflict):
        asked.delete()
    assert "points" in asked._repr_html_()
    with pytest.raises(Stopped):
        asked.cancel().wait(progress=False)
    with pytest.raises(Conflict):
        asked.report("report.html")
    assert asked.resume().state in ("queued", "running")
    asked.cancel().delete()
    with pytest.raises(NotFound):
        _ = asked.state
