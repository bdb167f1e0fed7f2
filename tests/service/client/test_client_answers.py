"""Every answer that the client gives is the Dataset that `damperlab.studies.answers` makes of the same cube."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from damperlab.service.client import Client, Study
from damperlab.studies.answers.compared_response import compared_response
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.map_difference import map_difference
from damperlab.studies.answers.merged import merged_designs
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.refine import refine_boundary, refine_optimum
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.robust import robust_designs
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.definition import parse_study
from damperlab.studies.questions import Judging, Search, Selection, Tuning
from damperlab.studies.store.export.export import without_names
from damperlab.studies.store.store import Store

# Friction alone: one kernel, and classes from locked to sliding. With the particle there is a mass to compare.
FRICTION: dict[str, Any] = {
    "name": "friction over frequency",
    "particle": False,
    "axes": {
        "friction_ratio": [0.1, 0.2, 0.4, 0.8, 1.6],
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 5},
    },
}
HYBRID: dict[str, Any] = {
    "name": "hybrid, three by three",
    "axes": {
        "clearance_ratio": [5, 10, 20],
        "friction_ratio": [0.1, 0.2, 0.4],
        "frequency_ratio": [0.95, 1, 1.05],
    },
}


@pytest.fixture(scope="module")
def remote(service: Any) -> Iterator[Client]:
    with Client(service.url) as client:
        yield client


@pytest.fixture(scope="module")
def store(service: Any) -> Iterator[Store]:
    store = Store.open(service.log.parent / "data")
    yield store
    store.close()


@pytest.fixture(scope="module")
def friction(remote: Client) -> Study:
    return remote.submit(FRICTION).wait(progress=False)


@pytest.fixture(scope="module")
def hybrid(remote: Client) -> Study:
    return remote.submit(HYBRID).wait(progress=False)


AT = {"clearance_ratio": 9.0, "friction_ratio": 0.15}
Ask = Callable[[Study], xr.Dataset]
Answer = Callable[[xr.Dataset], xr.Dataset]
QUESTIONS: dict[str, tuple[Ask, Answer]] = {
    "map, worst over the band": (
        lambda study: study.resonance_map(),
        lambda cube: resonance_map(cube, "clearance_ratio", "friction_ratio"),
    ),
    "map at a frequency": (
        lambda study: study.resonance_map("friction_ratio", "clearance_ratio", frequency_ratio=1.0),
        lambda cube: resonance_map(
            cube, "friction_ratio", "clearance_ratio", Selection(at={"frequency_ratio": 1.0})
        ),
    ),
    "map of codes": (
        lambda study: study.resonance_map(metric="response_class"),
        lambda cube: resonance_map(cube, "clearance_ratio", "friction_ratio", Selection("response_class")),
    ),
    "map of counts, which are floats": (
        lambda study: study.resonance_map(metric="period", frequency_ratio=1.0),
        lambda cube: resonance_map(
            cube, "clearance_ratio", "friction_ratio", Selection("period", at={"frequency_ratio": 1})
        ),
    ),
    "map, mean over a dimension": (
        lambda study: study.resonance_map(
            "clearance_ratio", "frequency_ratio", over="friction_ratio", reduce="mean"
        ),
        lambda cube: resonance_map(
            cube, "clearance_ratio", "frequency_ratio", over="friction_ratio", reduce="mean"
        ),
    ),
    "map less that of another": (
        lambda study: study.resonance_map(minus=study),
        lambda cube: map_difference(cube, cube, "clearance_ratio", "friction_ratio").assign_attrs(
            studies=[cube.attrs["digest"][:12]] * 2
        ),
    ),
    "response": (
        lambda study: study.frequency_response(**AT),
        lambda cube: frequency_response(cube, Selection(at=AT)),
    ),
    "response with gaps": (
        lambda study: study.frequency_response("floquet_multiplier", **AT),
        lambda cube: frequency_response(cube, Selection("floquet_multiplier", at=AT)),
    ),
    "response between grid points": (
        lambda study: study.frequency_response(interpolate=True, **AT),
        lambda cube: frequency_response(cube, Selection(at=AT, interpolate=True)),
    ),
    "response beside another": (
        lambda study: study.frequency_response(with_=study, **AT),
        lambda cube: compared_response(cube, cube, Selection(at=AT)).assign_attrs(
            studies=[cube.attrs["digest"][:12]] * 2
        ),
    ),
    "ranking": (
        lambda study: study.optimal_designs(
            "band_rms", band=(0.95, 1.0), top=4, exclude_locked=True, clearance_ratio=(5, 10)
        ),
        lambda cube: optimal_designs(
            cube,
            Judging("band_rms", band=(0.95, 1.0), exclude_locked=True, ranges={"clearance_ratio": (5, 10)}),
            top=4,
        ),
    ),
    "ranking of nothing": (
        lambda study: study.optimal_designs(max_impact_speed=0.0, friction_ratio=(0.1, 0.1)),
        lambda cube: optimal_designs(
            cube, Judging(max_impact_speed=0.0, ranges={"friction_ratio": (0.1, 0.1)})
        ),
    ),
    "front": (
        lambda study: study.optimal_designs(pareto=["amplitude", "-dissipation_impact"]),
        lambda cube: pareto_front(cube, ["amplitude", "-dissipation_impact"]),
    ),
    "robust": (
        lambda study: study.robust_designs((1, 2), top=3),
        lambda cube: robust_designs(cube, (1, 2), top=3),
    ),
    "tuned mass damper": (
        lambda study: study.tmd_comparison("den_hartog", detuning=0.05, **AT),
        lambda cube: tmd_comparison(cube, Tuning("den_hartog", detuning=0.05), at=AT),
    ),
    "tuned mass damper under a force": (
        lambda study: study.tmd_comparison("hinf", excitation="force", **AT),
        lambda cube: tmd_comparison(cube, Tuning("hinf", excitation="force"), at=AT),
    ),
    "work and precision": (lambda study: study.work_precision(), work_precision),
}


def assert_same(found: xr.Dataset, local: xr.Dataset) -> None:
    """Equal values, names, units, attributes and types; an answer can draw itself, which a bare Dataset cannot."""
    assert isinstance(found, xr.Dataset)
    for name in [name for name in found.coords if str(name).endswith("response_class_words")]:
        codes = found[str(name).removesuffix("_words")]
        meanings = dict(zip(codes.attrs["flag_values"], codes.attrs["flag_meanings"].split(), strict=True))
        assert [meanings[code] for code in codes.values.ravel()] == found[name].values.ravel().tolist()
        found = found.drop_vars(name)
    bare = xr.Dataset(dict(found.data_vars), dict(found.coords), found.attrs)
    xr.testing.assert_identical(bare, local)
    kinds = [{name: array.dtype.kind for name, array in each.variables.items()} for each in (found, local)]
    assert kinds[0] == kinds[1]


@pytest.mark.parametrize("question", QUESTIONS)
def test_answer_is_the_dataset_of_the_local_function(hybrid: Study, store: Store, question: str) -> None:
    ask, answer = QUESTIONS[question]
    found, local = ask(hybrid), answer(store.cube(hybrid.id))
    assert_same(found, local)


def test_scene_without_a_particle_has_the_same_answers(friction: Study, store: Store) -> None:
    cube = store.cube(friction.id)
    assert_same(friction.resonance_map(), resonance_map(cube, "friction_ratio", "frequency_ratio"))
    designs = friction.optimal_designs(exclude_locked=True)
    assert_same(designs, optimal_designs(cube, Judging(exclude_locked=True)))
    assert designs.attrs["locked"] > 0


def test_refinement_leads_to_a_ranking_of_both_studies(hybrid: Study, store: Store) -> None:
    definition = parse_study(hybrid.record.definition)
    local = refine_optimum(definition, {hybrid.id: store.cube(hybrid.id)}, Search(1.0))
    planned = hybrid.refine(1.0, dry_run=True)
    assert (planned.known, planned.follow_up) == (False, None)
    assert (planned.points, planned.fine_points, planned.note) == (
        local.points,
        local.fine_points,
        local.note,
    )
    assert planned.found == local.found
    assert planned.steps == local.steps

    step = hybrid.refine(1.0)
    assert step.follow_up is not None
    step.follow_up.wait(progress=False)
    together = hybrid.optimal_designs(with_=[step.follow_up])
    cubes = {study.id: store.cube(study.id) for study in (hybrid, step.follow_up)}
    assert_same(together, merged_designs(cubes))
    assert together["value"][0] <= hybrid.optimal_designs()["value"][0]


def test_refinement_of_a_class_boundary(friction: Study, store: Store) -> None:
    definition = parse_study(friction.record.definition)
    at = {"frequency_ratio": 1.0}
    cubes = {friction.id: store.cube(friction.id)}
    local = refine_boundary(definition, cubes, "friction_ratio", at, 0.1)
    found = friction.refine_boundary("friction_ratio", 0.1, dry_run=True, frequency_ratio=1.0)
    assert (found.found, found.note) == (local.found, local.note)


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
    ("name", "open_it"),
    [
        ("cube.nc", lambda path: xr.load_dataset(path, engine="h5netcdf")["amplitude_ratio"].values.ravel()),
        (
            "cube.csv",
            lambda path: np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")[
                "amplitude_ratio"
            ],
        ),
        (
            "cube.parquet",
            lambda path: (
                pytest.importorskip("pyarrow.parquet").read_table(path)["amplitude_ratio"].to_numpy()
            ),
        ),
    ],
)
def test_export_holds_every_point(
    hybrid: Study, store: Store, tmp_path: Path, name: str, open_it: Callable[[Path], np.ndarray]
) -> None:
    path = hybrid.export(tmp_path / name)
    np.testing.assert_array_equal(open_it(path), store.cube(hybrid.id)["amplitude_ratio"].values.ravel())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda study: study.resonance_map(), "Clearance ratio"),
        (lambda study: study.resonance_map(minus=study), "Difference in amplitude ratio"),
        (lambda study: study.frequency_response(**AT), "Frequency ratio"),
        (lambda study: study.frequency_response(with_=study, **AT), "Frequency ratio"),
        (lambda study: study.optimal_designs(), "argest amplitude ratio in the band"),
        (lambda study: study.robust_designs((1, 2)), "argest over the base amplitudes"),
        (lambda study: study.tmd_comparison(**AT), "tuned mass damper"),
        (lambda study: study.work_precision(), "Run time of a point"),
    ],
)
def test_answer_draws_itself(hybrid: Study, tmp_path: Path, ask: Ask, words: str) -> None:
    path = tmp_path / "figure.svg"
    ask(hybrid).plot(path)
    assert words in path.read_text()


def test_plot_keeps_the_plots_of_xarray(hybrid: Study) -> None:
    designs = hybrid.optimal_designs()
    assert callable(designs.plot.scatter)
    # a Dataset in every other respect, and still drawn after it was cut
    assert isinstance(designs.isel(rank=slice(3)), type(designs))


def test_simulation_is_that_of_the_solver(remote: Client, tmp_path: Path) -> None:
    found = remote.simulate(1.0, friction_ratio=0.6, particle=False, history=2)
    # Den Hartog 1931; the value of Hundal's closed form, see tests/worker
    assert found.metrics["relative_amplitude_ratio"] == pytest.approx(31.059792, abs=5e-7)
    assert "eriodic" in found.response_class
    assert found.history["u"].attrs["units"] == "Z"
    # two cycles of the excitation at r = 1 are 4π
    assert float(np.ptp(found.history["time"].values)) == pytest.approx(4 * np.pi)
    assert float(np.abs(found.history["v"]).max()) == pytest.approx(31.059792, rel=1e-3)
    found.plot(tmp_path / "history.svg")
    assert "Time in excitation cycles" in (tmp_path / "history.svg").read_text()


def test_simulation_under_a_force_is_that_of_the_solver(remote: Client) -> None:
    found = remote.simulate(1.1, damping_ratio=0.05, particle=False, excitation="force", history=1)
    assert found.metrics["amplitude_ratio"] == pytest.approx(1.0 / np.hypot(1.0 - 1.21, 0.11), rel=1e-12)


def test_simulation_for_a_number_of_cycles_ends_where_the_solver_does(remote: Client) -> None:
    from damperlab.worker.point import Design
    from damperlab.worker.simulate import simulate
    from damperlab.worker.solver.particle import Particle

    found = remote.simulate(0.9, clearance_ratio=8.0, friction_ratio=0.3, cycles=5, history=0)
    local = simulate(Design(0.0038, 0.9, 0.3, Particle(8.0, 0.47, 0.1)), 5)
    assert found.state == local.state
    assert found.events == local.events
    assert not found.history
