"""A question has one answer: HTTP, the client and the command give what `damperlab.studies.answers` makes of the same cube."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import httpx
import numpy as np
import pytest
import xarray as xr
from tests.service.cli.commands import run
from tests.service.contract import check
from tests.studies.solving import LEAN

from damperlab.service.client import Client, Study
from damperlab.service.documents import plain
from damperlab.service.questions.every import BY_ROUTE
from damperlab.service.simulation import compute
from damperlab.service.simulation_request import read_simulation
from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.fragility import fragility
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.map_difference import map_difference
from damperlab.studies.answers.optimal_designs import merged_designs, optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.answers.refine import refine_optimum
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.definition import parse_study
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.questions import (
    EVERY_AXIS,
    Fragile,
    Judging,
    Ranking,
    Search,
    Selection,
    Tuning,
)
from damperlab.studies.store.export.export import without_names
from damperlab.studies.store.store import Store

HYBRID: dict[str, Any] = {
    "name": "hybrid, three by three",
    "axes": {
        "clearance_ratio": [5, 10, 20],
        "friction_ratio": [0.1, 0.2, 0.4],
        "frequency_ratio": [0.95, 1, 1.05],
    },
    "steady": {"max_cycles": 300},
}
FRICTION: dict[str, Any] = {
    "name": "friction over frequency",
    "particle": False,
    "axes": {
        "friction_ratio": [0.1, 0.2, 0.4, 0.8, 1.6],
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 5},
    },
}
AT = {"clearance_ratio": 9.0, "friction_ratio": 0.15}
PLANE = ("clearance_ratio", "friction_ratio")
DAMPERS = ("clearance_m", "friction_force_n")


class Asked(NamedTuple):
    """A question, what the client is given, and what the function makes of the same; SAME is the study itself."""

    route: str
    given: dict[str, Any]
    answer: Callable[[xr.Dataset], xr.Dataset]


SAME = object()
MAP, RESPONSE, RANKING, TMD = "resonance-map", "frequency-response", "optimal-designs", "tmd-comparison"
XY = dict(zip("xy", PLANE, strict=True))
OF_SUITE = dict(zip("xy", DAMPERS, strict=True))


def of_two(answer: xr.Dataset, cube: xr.Dataset) -> xr.Dataset:
    return answer.assign_attrs(studies=[cube.attrs["digest"][:12]] * 2)


HYBRIDS: dict[str, Asked] = {
    "map, worst over the band": Asked(MAP, XY, lambda cube: resonance_map(cube, *PLANE)),
    "map at a frequency": Asked(
        MAP, {"x": PLANE[1], "y": PLANE[0], "frequency_ratio": 1.0},
        lambda cube: resonance_map(cube, *PLANE[::-1], Selection(at={"frequency_ratio": 1.0})),
    ),
    "map of codes": Asked(
        MAP, XY | {"metric": "response_class"}, lambda cube: resonance_map(cube, *PLANE, Selection("response_class"))
    ),
    "map of counts, which are floats": Asked(
        MAP, XY | {"metric": "period", "frequency_ratio": 1.0},
        lambda cube: resonance_map(cube, *PLANE, Selection("period", at={"frequency_ratio": 1})),
    ),
    "map, mean over a dimension": Asked(
        MAP, {"x": "clearance_ratio", "y": "frequency_ratio", "over": "friction_ratio", "reduce": "mean"},
        lambda cube: resonance_map(cube, "clearance_ratio", "frequency_ratio", over="friction_ratio", reduce="mean"),
    ),
    "map less that of another": Asked(
        MAP, XY | {"minus": SAME}, lambda cube: of_two(map_difference(cube, cube, *PLANE), cube)
    ),
    "response": Asked(RESPONSE, AT, lambda cube: frequency_response(cube, Selection(at=AT))),
    "response with gaps": Asked(
        RESPONSE, AT | {"metric": "floquet_multiplier"},
        lambda cube: frequency_response(cube, Selection("floquet_multiplier", at=AT)),
    ),
    "response beside another": Asked(
        RESPONSE, AT | {"with_": SAME}, lambda cube: of_two(compared_response(cube, cube, Selection(at=AT)), cube)
    ),
    "ranking": Asked(
        RANKING, {"objective": "band_rms", "band": (0.95, 1.0), "top": 4, "exclude_locked": True, "clearance_ratio": (5, 10)},
        lambda cube: optimal_designs(
            cube,
            Judging("band_rms", band=(0.95, 1.0), exclude_locked=True, ranges={"clearance_ratio": (5, 10)}),
            top=4,
        ),
    ),
    "ranking within a range of a result": Asked(
        RANKING, {"top": 10, "stick_fraction": (0, 0.5)},
        lambda cube: optimal_designs(cube, Judging(ranges={"stick_fraction": (0, 0.5)})),
    ),
    "ranking of nothing": Asked(
        RANKING, {"top": 10, "max_impact_speed": 0.0, "friction_ratio": (0.1, 0.1)},
        lambda cube: optimal_designs(cube, Judging(max_impact_speed=0.0, ranges={"friction_ratio": (0.1, 0.1)})),
    ),
    "front": Asked(
        RANKING, {"top": 500, "pareto": ["amplitude", "-dissipation_impact"]},
        lambda cube: pareto_front(cube, ["amplitude", "-dissipation_impact"]),
    ),
    "tuned mass damper": Asked(
        TMD, AT | {"criterion": "den_hartog", "detuning": 0.05},
        lambda cube: tmd_comparison(cube, Tuning("den_hartog", detuning=0.05), at=AT),
    ),
    "tuned mass damper under a force": Asked(
        TMD, AT | {"criterion": "hinf", "excitation": "force"},
        lambda cube: tmd_comparison(cube, Tuning("hinf", excitation="force"), at=AT),
    ),
    "work and precision": Asked("work-precision", {}, work_precision),
}  # fmt: skip
SUITES: dict[str, Asked] = {
    "map under a record": Asked(
        MAP, OF_SUITE | {"record": "northridge", "scale": 3},
        lambda cube: resonance_map(cube, *DAMPERS, Selection(at={"record": "northridge", "scale": 3})),
    ),
    "map over the records": Asked(
        MAP, OF_SUITE | {"scale": 3}, lambda cube: resonance_map(cube, *DAMPERS, Selection(at={"scale": 3}))
    ),
    "dampers by their worst case": Asked(
        RANKING, {"top": 2, "records": ["northridge-360"], "clearance_m": (0.002, 1)},
        lambda cube: ranked_designs(
            cube, Judging(ranges={"clearance_m": (0.002, 1)}), Ranking(top=2, records=("northridge-360",)), dict,
            lambda: {"northridge-360": builtin_record("northridge-360")},
        ),
    ),
    "fragility": Asked("fragility", {"threshold": 0.02}, lambda cube: fragility(cube, Fragile(0.02))),
}  # fmt: skip


@pytest.fixture(scope="module")
def remote(service: Any) -> Iterator[Client]:
    with Client(service.url) as client:
        yield client


@pytest.fixture(scope="module")
def friction(remote: Client) -> Study:
    return remote.submit(FRICTION).wait(progress=False)


@pytest.fixture(scope="module")
def hybrid(remote: Client) -> Study:
    return remote.submit(HYBRID).wait(progress=False)


@pytest.fixture
def printed(store: Store) -> Callable[..., Any]:
    """Run a command, and read the document that it prints."""
    return lambda *words: json.loads(run(*words, "--data-dir", store.data_dir, "--json").stdout)


def query(given: dict[str, Any], study: str) -> dict[str, str]:
    """Spell what the client is given as the parameters of a query."""

    def text(value: Any) -> str:
        if isinstance(value, list | tuple):
            return ",".join(map(text, value))
        return study if value is SAME else str(value).lower() if isinstance(value, bool) else str(value)

    return {
        {"with_": "with", "records": "record"}.get(name, name): text(value) for name, value in given.items()
    }


def options(query: dict[str, str]) -> list[str]:
    """Spell the parameters of a query as the options of a command."""
    found: list[str] = []
    for name, value in query.items():
        if name != "record" and (name in EVERY_AXIS or name == "stick_fraction"):
            found += ["--within" if "," in value else "--at", f"{name}={value}"]
        else:
            found += [f"--{name.replace('_', '-')}", *([] if value == "true" else [value])]
    return found


def assert_same(found: xr.Dataset, local: xr.Dataset) -> None:
    """Equal values, names, units, attributes and types; an answer can draw itself, which a bare Dataset cannot."""
    assert isinstance(found, xr.Dataset)
    for name in [name for name in found.coords if str(name).endswith("response_class_words")]:
        codes = found[str(name).removesuffix("_words")]
        meanings = dict(zip(codes.attrs["flag_values"], codes.attrs["flag_meanings"].split(), strict=True))
        assert [meanings[code] for code in codes.values.ravel()] == found[name].values.ravel().tolist()
        found = found.drop_vars(name)
    bare = xr.Dataset(dict(found.data_vars), dict(found.coords), _sent(found.attrs))
    xr.testing.assert_identical(bare, local.drop_attrs(deep=False).assign_attrs(_sent(local.attrs)))
    kinds = [{name: array.dtype.kind for name, array in each.variables.items()} for each in (found, local)]
    assert kinds[0] == kinds[1]


def _sent(attributes: dict[Any, Any]) -> dict[str, Any]:
    """Give attributes as JSON has them; the metric is that of the question, and stands in the document's head."""
    return {name: plain(value) for name, value in attributes.items() if name != "metric"}


@pytest.mark.parametrize("question", [*HYBRIDS, *SUITES])
def test_every_door_gives_the_answer_of_the_function(
    client: httpx.Client,
    remote: Client,
    store: Store,
    hybrid: Study,
    suite: dict[str, Any],
    printed: Callable[..., Any],
    question: str,
) -> None:
    route, given, answer = (HYBRIDS | SUITES)[question]
    study = hybrid if question in HYBRIDS else remote.study(suite["id"])
    asked = {name: study if value is SAME else value for name, value in given.items()}
    assert_same(getattr(study, BY_ROUTE[route].method)(**asked), answer(store.cube(study.id)))
    sent = query(given, study.id)
    document = client.get(f"/api/v1/studies/{study.id}/{route}", params=sent).json()
    assert "values" in document or "columns" in document, document
    assert printed(BY_ROUTE[route].command, study.id, *options(sent)) == document


@pytest.mark.parametrize(
    ("route", "boundary", "asked"),
    [("refine", [], {}), ("refine-boundary", ["--boundary", "friction_ratio"], {"frequency_ratio": "1"})],
)
def test_a_search_is_planned_alike(
    client: httpx.Client,
    friction: Study,
    printed: Callable[..., Any],
    route: str,
    boundary: list[str],
    asked: dict[str, str],
) -> None:
    sent = asked | {"dry_run": "true"} | ({"along": boundary[1]} if boundary else {})
    answer = client.post(f"/api/v1/studies/{friction.id}/{route}", params=sent)
    check("post", f"/api/v1/studies/{{study_id}}/{route}", answer)
    planned = answer.json()
    told = printed("refine", friction.id, *boundary, *options(asked), "--dry-run")
    assert planned["note"]
    assert {name: told.get(name) for name in planned} == planned
    if not boundary:
        step = friction.refine(dry_run=True)
        assert (step.note, step.follow_up) == (planned["note"], None)
    else:
        # locked where the friction bears the largest inertia force, r² = 1
        assert planned["found"]["low"] < 1.0 < planned["found"]["high"]
        found = friction.refine_boundary("friction_ratio", dry_run=True, frequency_ratio=1.0)
        assert (found.found, found.note) == (planned["found"], planned["note"])


def test_refinement_leads_to_a_ranking_of_both_studies(
    client: httpx.Client, hybrid: Study, store: Store, printed: Callable[..., Any]
) -> None:
    definition = parse_study(hybrid.record.definition)
    local = refine_optimum(definition, {hybrid.id: store.cube(hybrid.id)}, Search(1.0))
    step = hybrid.refine(1.0)
    assert (step.known, step.points, step.fine_points, step.note, step.found, step.steps) == (
        False, local.points, local.fine_points, local.say(), local.found, local.steps,
    )  # fmt: skip
    assert step.follow_up is not None
    step.follow_up.wait(progress=False)
    # asked again it is the same study
    address = f"/api/v1/studies/{hybrid.id}"
    again = client.post(f"{address}/refine", params={"tolerance": "1"})
    assert (again.status_code, again.json()["follow_up"]["id"]) == (200, step.follow_up.id)
    check("post", "/api/v1/studies/{study_id}/refine", again)
    together = hybrid.optimal_designs(with_=[step.follow_up])
    cubes = {study.id: store.cube(study.id) for study in (hybrid, step.follow_up)}
    assert_same(together, merged_designs(cubes))
    assert together["value"][0] <= hybrid.optimal_designs()["value"][0]
    document = client.get(f"{address}/optimal-designs", params={"with": step.follow_up.id}).json()
    assert printed("optimum", hybrid.id, "--with", step.follow_up.id) == document


def test_every_door_finds_up_to_which_friction_of_its_particle_the_best_damper_holds(
    client: httpx.Client, remote: Client, printed: Callable[..., Any]
) -> None:
    physical = {
        "mass_kg": 250, "natural_frequency_hz": 7.6, "base_amplitude_m": 0.001, "particle_mass_kg": 20,
        "friction_force_n": 300, "clearance_m": [0.003, 0.004],
    }  # fmt: skip
    axes = {"restitution": 0.5, "frequency_ratio": [0.95, 0.97]}
    asked = {"name": "floor", "damping_ratio": 0.02, "physical": physical, "axes": axes, "metrics": LEAN}
    study = remote.submit(asked)
    study.wait(progress=False)
    step = study.particle_friction()
    assert (step.known, len(step.follow_ups)) == (False, 1)
    for each in step.follow_ups:
        each.wait(progress=False)
    (follow_up,) = step.follow_ups
    address = f"/api/v1/studies/{study.id}/particle-friction"
    planned = client.post(address, params={"with": follow_up.id})
    check("post", "/api/v1/studies/{study_id}/particle-friction", planned)
    known = planned.json()
    assert (known["known"], "follow_ups" in known) == (True, False)
    assert known["note"].startswith("Friction of the particle ")
    document = client.get(f"/api/v1/studies/{study.id}/optimal-designs", params={"with": follow_up.id}).json()
    (note,) = (each["values"] for each in document["notes"] if each["kind"] == "particle_friction")
    assert f"{note['up_to'] or note['fails']:g}" in known["note"]
    assert printed("optimum", study.id, "--friction") == document


def test_cube_is_lazy_and_bit_for_bit_the_stored_one(hybrid: Study, store: Store) -> None:
    cube = hybrid.cube()
    assert cube["amplitude_ratio"].chunks is not None
    stored = without_names(store.cube(hybrid.id))
    xr.testing.assert_identical(cube.compute(), stored.compute())
    without_dask = hybrid.cube(chunks=None)
    assert without_dask["amplitude_ratio"].chunks is None
    corner = {"clearance_ratio": 10, "friction_ratio": 0.2, "frequency_ratio": 1.0}
    values = [each["amplitude_ratio"].sel(corner).values for each in (without_dask, stored)]
    np.testing.assert_array_equal(*values)


@pytest.mark.parametrize(
    ("kind", "suffix"), [("hybrid", "nc"), ("hybrid", "csv"), ("hybrid", "parquet"), ("suite", "nc")]
)
def test_an_export_is_one_file_behind_every_door(
    client: httpx.Client, remote: Client, hybrid: Study, suite: dict[str, Any], store: Store, tmp_path: Path,
    kind: str, suffix: str,
) -> None:  # fmt: skip
    study = hybrid if kind == "hybrid" else remote.study(suite["id"])
    there, here = tmp_path / f"a.{suffix}", tmp_path / f"b.{suffix}"
    content = study.export(there).read_bytes()
    run("export", study.id, "-o", here, "--data-dir", store.data_dir)
    assert here.read_bytes() == content
    assert sorted(tmp_path.iterdir()) == [there, here]
    if suffix == "csv":
        answer = client.get(f"/api/v1/studies/{study.id}/export", params={"format": "csv"})
        assert (answer.status_code, answer.content) == (200, content)
        assert "attachment" in answer.headers["content-disposition"]


DRAWN: list[tuple[Callable[[Study], Any], str]] = [
    (lambda study: study.resonance_map(), "Clearance ratio"),
    (lambda study: study.frequency_response(with_=study, **AT), "Frequency ratio"),
    (lambda study: study.optimal_designs(), "argest amplitude ratio in the band"),
    (lambda study: study.work_precision(), "Run time of a point"),
]


@pytest.mark.parametrize(("ask", "words"), DRAWN)
def test_an_answer_draws_itself(
    hybrid: Study, tmp_path: Path, ask: Callable[[Study], Any], words: str
) -> None:
    ask(hybrid).plot(tmp_path / "figure.svg")
    assert words in (tmp_path / "figure.svg").read_text()


def test_a_command_draws_into_a_folder_that_it_makes(hybrid: Study, store: Store, tmp_path: Path) -> None:
    file = tmp_path / "new folder" / "drawn.png"
    run("map", hybrid.id, "--minus", hybrid.id, "-o", file, "--data-dir", store.data_dir)
    assert file.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_a_simulation_is_the_same_from_every_door(
    client: httpx.Client, remote: Client, tmp_path: Path
) -> None:
    point = {"frequency_ratio": 0.9, "clearance_ratio": 8.0, "friction_ratio": 0.3, "cycles": 5}
    local = compute(read_simulation({**point, "history": 0}, 10_000, 1000), 10_000)
    over_http = client.post("/api/v1/simulate", json=point).raise_for_status().json()
    flags = [part for name, value in point.items() for part in (f"--{name.replace('_', '-')}", str(value))]
    told = json.loads(run("simulate", *flags, "--json").stdout)
    found = remote.simulate(**point, history=2)  # type: ignore[arg-type]
    for state, events in (
        (over_http["state"], over_http["events"]), (told["state"], told["events"]), (found.state, found.events),
    ):  # fmt: skip
        assert (state, events) == (local["state"], local["events"])
    one, other = ({**each["metrics"], "run_time": 0.0} for each in (over_http, told))
    assert one == other
    assert set(local["events"]) == {"impacts", "turns", "attachments"}
    # the last two cycles, each of 2π/r, drawn and as a table
    assert float(np.ptp(found.history["time"].values)) == pytest.approx(4 * np.pi / 0.9)
    assert found.history["u"].attrs["units"] == "Z"
    found.plot(tmp_path / "history.svg")
    assert "Time in excitation cycles" in (tmp_path / "history.svg").read_text()
    run("simulate", *flags, "-o", tmp_path / "history.csv")
    rows = np.genfromtxt(tmp_path / "history.csv", delimiter=",", names=True)
    assert (rows["time"][0], rows["time"][-1]) == (0.0, pytest.approx(10 * np.pi / 0.9, rel=1e-12))
    assert rows["u"][-1] == pytest.approx(local["state"]["u"], rel=1e-9)


@pytest.mark.parametrize(("damping_ratio", "cycles"), [(0.05, np.log(100.0) / (0.1 * np.pi)), (0.0, None)])
def test_a_disturbance_dies_out_as_soon_as_is_said(damping_ratio: float, cycles: float | None) -> None:
    """Without a damper as e^(−ζτ)."""
    point = {"frequency_ratio": 0.5, "damping_ratio": damping_ratio, "particle": False, "history": 0}
    found = compute(read_simulation(point, 10_000, 1000), 10_000)
    assert found.get("settles_after_cycles") == (
        None if cycles is None else pytest.approx(0.5 * cycles, rel=1e-12)
    )


def test_dampers_are_compared_alike_under_an_earthquake(
    client: httpx.Client, remote: Client, printed: Callable[..., Any], tmp_path: Path
) -> None:
    asked = {"record": "northridge", "cases": ["none", "tmd"], "starts": 0}
    document = client.post("/api/v1/earthquake-comparisons", json=asked).raise_for_status().json()
    assert printed("earthquake", "northridge", "--case", "none", "--case", "tmd", "--starts", "0") == document
    found = remote.earthquake_comparison("northridge", ["none", "tmd"], starts=0)
    assert found["case"].values.tolist() == list(document["cases"]) == ["none", "tmd"]
    units = {"peak_relative_displacement_m": "m", "peak_absolute_acceleration_m_s2": "m/s2"}
    for name, unit in units.items():
        values = [document["cases"][case][name] for case in ("none", "tmd")]
        np.testing.assert_array_equal(found[name], values)
        assert found[name].attrs["units"] == unit
    assert found.attrs["record"]["id"] == document["record"]["id"] == "northridge-090"
    found.plot(tmp_path / "dampers.svg")
    assert "Peak of" in (tmp_path / "dampers.svg").read_text()
