"""Every result that a study stores is shown by every question that takes one, with its unit or what it is over."""

import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import yaml
from tests.service.cli.commands import run

from damperlab.service.questions.frequency_response import FREQUENCY_RESPONSE
from damperlab.service.questions.question import Subject
from damperlab.service.questions.resonance_map import RESONANCE_MAP
from damperlab.studies.questions import Selection
from damperlab.studies.store.store import Store
from damperlab.studies.unit_names import ACCELERATIONS, AMPLITUDES, OVER, RESULTS
from damperlab.studies.variables import VARIABLES

RATIOS: dict[str, Any] = {
    "damping_ratio": 0.05,
    "axes": {
        "clearance_ratio": [2, 6],
        "friction_ratio": [0.2, 0.4],
        "frequency_ratio": [0.9, 1.0],
        "mass_ratio": 0.07,
        "restitution": 0.5,
    },
}
UNITS: dict[str, Any] = {
    "damping_ratio": 0.05,
    "axes": {"restitution": 0.5},
    "physical": {
        "mass_kg": 42,
        "natural_frequency_hz": 11.3,
        "base_amplitude_m": 8e-5,
        "particle_mass_kg": 3,
        "clearance_m": [0.0002, 0.0005],
        "friction_force_n": [0, 3],
        "excitation_frequency_hz": [10, 11],
    },
}
AMPLITUDE_AXIS = UNITS["physical"] | {"base_amplitude_m": [4e-5, 8e-5]}
FORCE = {name: value for name, value in UNITS["physical"].items() if name != "base_amplitude_m"}
EVERY_METRIC = [name for name, one in VARIABLES.items() if not (one.start or one.rubbing)]
SCENES: dict[str, dict[str, Any]] = {
    "ratios": RATIOS,
    "forced-ratios": RATIOS | {"excitation": "force"},
    "units": UNITS,
    "forced-units": UNITS | {"excitation": "force", "physical": FORCE | {"force_n": 17}},
    "amplitudes": UNITS | {"physical": AMPLITUDE_AXIS},
    "forced-amplitudes": UNITS | {"excitation": "force", "physical": FORCE | {"force_n": [8, 17]}},
    "accelerated": UNITS | {"physical": AMPLITUDE_AXIS | {"constant": "acceleration"}},
    "rubbing": UNITS | {"physical": UNITS["physical"] | {"particle_friction_coefficient": [0, 0.02]}},
    "starts": UNITS | {"start": {"kind": "ensemble", "n": 2}},
}
SMALL = {"max_cycles": 60, "tolerance": 0.2}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found: Path = tmp_path_factory.mktemp("metrics")
    return found


def metrics_of(scene: str) -> list[str]:
    """Name all that a scene can store; accelerations take kernels of their own, so none by day."""
    more = {"starts": "start", "rubbing": "rubbing"}.get(scene, "asked")
    every = [name for name, one in VARIABLES.items() if name in EVERY_METRIC or getattr(one, more)]
    return [name for name in every if scene not in AT_ONCE or "acceleration" not in name]


AT_ONCE = ("ratios",)
"""What guards a change; the other scenes follow at night."""


@pytest.fixture(
    scope="module",
    params=[each if each in AT_ONCE else pytest.param(each, marks=pytest.mark.night) for each in SCENES],
)
def scene(request: pytest.FixtureRequest, folder: Path) -> str:
    name = str(request.param)
    document = SCENES[name] | {"name": name, "steady": SMALL, "metrics": metrics_of(name)}
    file = folder / f"{name}.yaml"
    file.write_text(yaml.safe_dump(document))
    run("run", file, "--data-dir", folder / "data")
    return name


@pytest.fixture
def printed(folder: Path) -> Callable[..., str]:
    return lambda *question: run(*question, "--data-dir", folder / "data").stdout


def kept_in(scene: str) -> list[str]:
    """Name the results that a scene's study stores, and those that it has in units."""
    stored = metrics_of(scene)
    lacking = {AMPLITUDES[name] for name in AMPLITUDES if name not in stored}
    return stored if "ratios" in scene else [*stored, *(name for name in RESULTS if name not in lacking)]


def test_every_result_is_shown_with_its_unit_or_what_it_is_over(scene: str, folder: Path) -> None:
    with closing(Store.open(folder / "data")) as store:
        subject = Subject(store.find(scene), store, "map")
        for metric in kept_in(scene):
            for question in (RESONANCE_MAP, FREQUENCY_RESPONSE)[: 1 if "forced" in scene else 2]:
                asked = [
                    kind(metric=metric) if issubclass(kind, Selection) else kind() for kind in question.asks
                ]
                words = question.tell(subject, question.of(subject, *asked), True, *asked)
                caption, _, _ = words.sentences[0].partition(". ")
                assert unit_in(caption) == UNIT_OF.get(metric), caption


UNIT_OF = {
    **OVER,
    **dict.fromkeys(AMPLITUDES.values(), "mm"),
    **dict.fromkeys(ACCELERATIONS.values(), "m/s²"),
    "impact_speed_max_m_per_s": "m/s",
    "dissipation_per_cycle_j": "J",
    "run_time": "s",
}
"""What the caption of each result has to say; nothing of counts, shares and codes."""


def unit_in(caption: str) -> str | None:
    """Find the unit that a caption names, or what its ratio is over."""
    found = re.search(r" in (mm|m/s²|m/s|J|s)(?=$|,)", caption)
    if found:
        return found[1]
    found = re.search(r"(?: over |/\(?)(Z·ω_n²|Z·ω_n|k·Z²|Z)", caption)
    return found[1] if found else None


@pytest.mark.night
def test_a_ranking_and_a_report_are_written_of_every_scene(
    scene: str, folder: Path, printed: Callable[..., str]
) -> None:
    printed("optimum", scene)
    file = folder / f"{scene}.html"
    printed("report", scene, "-o", str(file))
    caption = "amplitude ratio X/Z" if "ratios" in scene else "amplitude of the structure X in mm"
    assert caption in file.read_text()


def test_what_is_named_as_a_ratio_is_one_and_what_nobody_named_is_in_units(
    scene: str, printed: Callable[..., str]
) -> None:
    if "ratios" in scene:  # it has nothing in units
        assert "X/Z" in printed("map", scene)
        return
    ratio, length, usual = (
        printed("map", scene, *named, "--details").partition("\n\n")[2]
        for named in (("--metric", "amplitude_ratio"), ("--metric", "amplitude_m"), ())
    )
    assert rows(usual) == rows(length) != rows(ratio)
    detailed = printed("response", scene, "--metric", "amplitude_ratio", "--details").partition("\n\n")[2]
    column = detailed.splitlines()[1]
    assert "amplitude_ratio" in column
    assert "[mm]" not in column
    together = printed("map", scene, "--metric", "amplitude_ratio", "--minus", scene, "--details")
    assert "amplitude ratio X/Z" in together


def rows(said: str) -> list[str]:
    return said.splitlines()[1:]
