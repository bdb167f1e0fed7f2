"""A new question is one file and its lines in the list: it is behind every door then, and behind none without them."""

import json
import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from tests.ready import ready
from tests.service.cli.commands import LINEAR, run

from damperlab.service.questions.every import EVERY

ROOT = Path(__file__).parents[2]

QUESTION = '''"""The question which amplitude a share of the points stays below."""

from dataclasses import dataclass
from typing import Any

from damperlab.service.questions.forms import along
from damperlab.service.questions.question import Question, Subject, Words
from damperlab.studies.shapes import Numbers, OfPoints
from damperlab.studies.field import asked
from damperlab.studies.kinds import HARMONIC


@dataclass(frozen=True)
class Share:
    """Which share."""

    share: float = asked(0.5, "Share of the points.", least=0, most=1)
    beside: str | None = asked(None, "Another study.", studies=True, doors=("http",))


class AmplitudeShare(OfPoints):
    """Amplitudes along ``share``."""

    share: Numbers
    amplitude_ratio: Numbers


def answer(study: Subject, asked: Share) -> Any:
    """Give the amplitude that a share of the points stays below."""
    import numpy as np
    import xarray as xr

    values = study.cube["amplitude_ratio"].values
    shares = np.array([0.0, asked.share, 1.0])
    found = {"amplitude_ratio": ("share", np.quantile(values, shares), {"units": "1"})}
    known = {"note": "Three amplitudes.", "complete": 1.0, "points": values.size, "points_failed": 0}
    return xr.Dataset(found, {"share": shares}, known)


def draw(found: Any, names: tuple[str, ...]) -> Any:
    """Draw the amplitudes."""
    from matplotlib.figure import Figure

    figure = Figure()
    figure.add_subplot().plot(found["share"], found["amplitude_ratio"])
    return figure


def tell(study: Subject, found: Any, details: bool, asked: Share) -> Words:
    """List the amplitudes."""
    rows = [(f"{share:g}", f"{float(value):.6g}") for share, value in found["amplitude_ratio"].to_series().items()]
    return Words(None, [found.attrs["note"]], (("share", "amplitude"), rows))


AMPLITUDE_SHARE: Question[Any] = Question(
    route="amplitude-share",
    command="share",
    summary="The amplitude that a share of the points stays below",
    help="Say which amplitude a share of the points stays below.",
    asks=(Share,),
    answer=answer,
    gives=AmplitudeShare,
    form=along("share"),
    draw=draw,
    tell=tell,
    kinds=(HARMONIC,),
    details=False,
)
'''


@pytest.fixture
def extended(tmp_path: Path) -> Path:
    """The package with one question more."""
    package = tmp_path / "with" / "damperlab"
    shutil.copytree(ROOT / "src" / "damperlab", package, symlinks=True, ignore=lambda *_: ["service"])
    for name in ("studies", "worker"):
        (package / name).unlink()
        (package / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "service", package / "service", ignore=shutil.ignore_patterns("library"))
    questions = package / "service" / "questions"
    (questions / "amplitude_share.py").write_text(QUESTION)
    listed = (questions / "every.py").read_text()
    importing = "from damperlab.service.questions.amplitude_share import AMPLITUDE_SHARE\n"
    listed = listed.replace("from damperlab", f"{importing}from damperlab", 1)
    (questions / "every.py").write_text(
        listed.replace("    RESONANCE_MAP,\n", "    AMPLITUDE_SHARE,\n    RESONANCE_MAP,\n")
    )
    return package.parent


def test_a_new_question_is_one_file_and_its_line_in_the_list(extended: Path, tmp_path: Path) -> None:
    (tmp_path / "study.json").write_text(json.dumps(LINEAR))
    made = json.loads(run("run", tmp_path / "study.json", "--data-dir", tmp_path / "data", "--json").stdout)
    places = [str(extended), str(tmp_path / "data"), made["id"]]
    ended = ready().run("tests.service.extended", places, dict(os.environ), 600.0)
    assert ended.returncode == 0, ended.stderr
    found: dict[str, Any] = json.loads(ended.stdout)

    assert found["status"] == 200
    assert found["http"] == found["command"]
    assert found["client"] == found["http"]["amplitude_ratio"]
    assert found["refused"]["errors"][0]["field"] == "share"
    assert (tmp_path / "data" / "share.png").read_bytes().startswith(b"\x89PNG")
    operation = found["document"]["paths"]["/api/v1/studies/{study_id}/amplitude-share"]["get"]
    assert operation["description"] == "Give the amplitude that a share of the points stays below."
    assert [each["name"] for each in operation["parameters"]] == ["study_id", "share", "beside"]
    schema = found["document"]["components"]["schemas"]["AmplitudeShare"]
    assert schema["properties"]["share"] == {"type": "array", "items": {"type": ["number", "null"]}}
    assert found["reads"] == ["beside"]
    assert '"method": "amplitude_share"' in found["words"]
    assert found["signature"] == "(*, share=0.5)"
    assert "Share of the points." in found["help"]


def test_the_list_names_every_file_of_a_question() -> None:
    folder = ROOT / "service" / "questions"
    files = {path.stem for path in folder.glob("*.py") if " = Question(" in path.read_text()}
    assert {question.answer.__module__.rpartition(".")[2] for question in EVERY} == files
    assert "amplitude-share" not in {question.route for question in EVERY}
