"""What is asked of dampers over base amplitudes is what numpy says of the values that were stored."""

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.documents import without

from damperlab.studies.amplitudes import DIMENSIONS as AMPLITUDE_DIMENSIONS
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.one_amplitude import at_one_amplitude, said_of_it
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.suite import require_harmonic, worst_case_designs
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.questions import Judging, Ranking, Selection, Tuning
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.description import stored_variables
from damperlab.studies.store.export.export import csv_lines, write_file
from damperlab.studies.store.store import Store
from damperlab.studies.tmd.transfer import amplitude_ratio
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.units import base_of, with_units
from damperlab.studies.variables import DIMENSIONS, ResponseClass

MASS, HERTZ = 2.0, 4.0
Z = np.array([0.001, 0.002, 0.004])
PHYSICAL = {
    "mass_kg": MASS,
    "natural_frequency_hz": HERTZ,
    "base_amplitude_m": Z.tolist(),
    "clearance_m": [0.006, 0.01],
    "friction_force_n": [0.5, 1.0, 1.5],
    "excitation_frequency_hz": [3.6, 4.0, 4.4, 4.8],
}
FORCED = without(PHYSICAL, "base_amplitude_m") | {"force_n": (Z * MASS * (2 * np.pi * HERTZ) ** 2).tolist()}


def keep(store: Store, physical: dict[str, Any]) -> str:
    """Store a study whose values are drawn, unless it is there, and give its id."""
    excitation = "force" if "force_n" in physical else "base"
    study = parse_study({"name": "ray", "excitation": excitation, "physical": physical})
    plan = plan_with_chunk(study, (1, 1, 1, 1, 2, 2, 3), lambda _, at: np.ones(len(at["mass_ratio"])))
    record, created = store.submit(study, plan, {})
    rng = np.random.default_rng(5)
    for index in range(plan.count if created else 0):
        block = plan.block(index)
        values = {v.name: rng.uniform(0.5, 9.0, block.shape).astype(v.dtype) for v in stored_variables(study)}
        values["status"] = np.zeros(block.shape, np.int8)
        values["response_class"] = np.full(block.shape, ResponseClass.SYMMETRIC, np.int8)
        if block.start[3] == 0 and block.start[4] == 2:  # one damper holds still at every amplitude
            values["response_class"][:] = ResponseClass.LOCKED
        store.mark(record.id, write_region(store.cube_path(record.id), block, values))
    return record.id


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Store, str]]:
    folder: Path = tmp_path_factory.mktemp("amplitudes")
    store = Store.open(folder)
    yield store, keep(store, PHYSICAL)
    store.close()


def cube_of(stored: tuple[Store, str], constant: str) -> xr.Dataset:
    """The cube of which so much of the base's motion is constant."""
    store, study_id = stored
    named = constant != "displacement"
    return store.cube(keep(store, PHYSICAL | {"constant": constant}) if named else study_id)


@pytest.fixture
def cube(stored: tuple[Store, str]) -> xr.Dataset:
    return cube_of(stored, "displacement")


@pytest.mark.parametrize(("constant", "order"), [("displacement", 0), ("acceleration", 2)])
def test_results_in_units_are_the_ratios_times_the_displacement_of_the_base_at_each_frequency(
    stored: tuple[Store, str], constant: str, order: int
) -> None:
    cube = cube_of(stored, constant)
    base_m = Z[:, None] / cube["frequency_ratio"].values ** order
    ratio, stiffness = cube["amplitude_ratio"].values, MASS * (2 * np.pi * HERTZ) ** 2
    np.testing.assert_array_equal(cube["amplitude_m"].values, ratio * base_m)
    speed = cube["impact_speed_max"].values * (2 * np.pi * HERTZ * base_m)
    np.testing.assert_allclose(cube["impact_speed_max_m_per_s"], speed, rtol=1e-15)
    # energy goes with the square of the base amplitude
    energy = cube["dissipation_per_cycle"].values * (stiffness * base_m**2)
    np.testing.assert_allclose(cube["dissipation_per_cycle_j"], energy, rtol=1e-15)
    units = {"amplitude_m": "m", "impact_speed_max_m_per_s": "m s-1", "dissipation_per_cycle_j": "J"}
    assert {name: cube[name].attrs["units"] for name in units} == units
    # read in pieces, along each dimension on its own, the factors go with their places
    part = cube["amplitude_m"].isel(base_amplitude_m=[2, 0], frequency_ratio=slice(1, 3), clearance_m=1)
    np.testing.assert_array_equal(part.values[0, 0, 0], (ratio * base_m)[0, 0, 0, 1][:, [2, 0], 1:3])
    one = cube["amplitude_m"].isel(frequency_ratio=2, friction_force_n=[0, 2])
    np.testing.assert_array_equal(one.values, (ratio * base_m)[..., 2][..., [0, 2], :])
    loaded = with_units(cube.drop_vars(["amplitude_m"]).load())
    np.testing.assert_array_equal(loaded["amplitude_m"].values, ratio * base_m)
    # the ratios of a damper, a handful of roundings
    per = base_m if order else Z
    dims = ("base_amplitude_m", "frequency_ratio") if order else ("base_amplitude_m",)
    assert cube["clearance_ratio"].dims == ("clearance_m", *dims)
    np.testing.assert_array_equal(cube["clearance_ratio"][1], 0.01 / per)
    np.testing.assert_allclose(cube["friction_ratio"][2], 1.5 / (stiffness * per), rtol=1e-15)
    # the map shows the worst of metres, which is not where the ratio is largest
    shown = resonance_map(cube, "clearance_m", "friction_force_n", Selection(metric="amplitude_m"))
    worst = (ratio * base_m).max(axis=(5, 6)).ravel()
    np.testing.assert_allclose(shown["amplitude_m"].values.T.ravel(), worst, rtol=1e-15)
    rows = list(csv.DictReader(io.StringIO("".join(csv_lines(cube)))))
    np.testing.assert_allclose([float(row["amplitude_m"]) for row in rows], (ratio * base_m).ravel())


def test_exports_hold_dampers_ratios_and_units(
    stored: tuple[Store, str], cube: xr.Dataset, tmp_path: Path
) -> None:
    store, study_id = stored
    assert not list(verify(store, store.find(study_id)))
    write_file(cube, tmp_path / "cube.nc", "netcdf")
    with xr.open_dataset(tmp_path / "cube.nc", engine="h5netcdf") as back:
        assert tuple(back["amplitude_ratio"].dims) == tuple(cube["status"].dims)
        for name in ("clearance_ratio", "friction_ratio", "frequency_hz", "particle_mass_kg"):
            assert name in back.coords
        for name in ("amplitude_m", "clearance_ratio", "amplitude_ratio"):
            np.testing.assert_array_equal(back[name], cube[name])
        assert {back[name].attrs["units"] for name in ("base_amplitude_m", "clearance_m", "amplitude_m")} == {
            "m"
        }
        rows = list(csv.DictReader(io.StringIO("".join(csv_lines(cube)))))
        assert len(rows) == cube["status"].size
        for name in ("base_amplitude_m", "clearance_ratio", "friction_ratio", "amplitude_m"):
            column = (
                xr.broadcast(back[name], back["status"])[0].transpose(*back["status"].dims).values.ravel()
            )
            np.testing.assert_array_equal([float(row[name]) for row in rows], column)
    # what a client opens over HTTP has the stored arrays alone
    plain = cube.drop_vars([name for name in cube.variables if name.endswith(("_m", "_m_per_s"))
                            and name not in cube.dims]).drop_vars(["clearance_ratio", "friction_ratio"])  # fmt: skip
    assert "amplitude_m" not in plain
    again = with_units(plain)
    for name in ("clearance_ratio", "friction_ratio", "amplitude_m", "impact_speed_max_m_per_s"):
        assert again[name].dims == cube[name].dims
        np.testing.assert_allclose(again[name], cube[name], rtol=1e-15)


def test_a_map_of_dampers_shows_the_worst_base_amplitude_and_frequency(cube: xr.Dataset) -> None:
    answer = resonance_map(cube, "clearance_m", "friction_force_n", Selection("amplitude_ratio"))
    values = cube["amplitude_ratio"].values[0, 0, 0]
    np.testing.assert_array_equal(answer["amplitude_ratio"], values.max(axis=(2, 3)).T)
    where = values.max(axis=3).argmax(axis=2).T
    np.testing.assert_array_equal(answer["base_amplitude_m_at"], Z[where])
    assert "3 base amplitudes from 1 to 4 mm" in answer.attrs["note"]
    lengths = resonance_map(cube, "clearance_m", "friction_force_n")
    np.testing.assert_array_equal(lengths["amplitude_m"], (values * Z[:, None]).max(axis=(2, 3)).T)
    assert "amplitude_error_m" in lengths
    assert "amplitude_error" not in lengths


def test_the_backbone_of_a_damper_is_a_map_over_amplitude_and_frequency(cube: xr.Dataset) -> None:
    at = {"clearance_m": 0.01, "friction_force_n": 1.5}
    answer = resonance_map(cube, "frequency_hz", "base_amplitude_m", Selection("amplitude_m", at))
    assert answer["amplitude_m"].dims == ("base_amplitude_m", "frequency_hz")
    np.testing.assert_allclose(answer["frequency_hz"], [3.6, 4.0, 4.4, 4.8], rtol=1e-15)
    np.testing.assert_array_equal(answer["amplitude_m"], cube["amplitude_m"].values[0, 0, 0, 1, 2])
    curve = frequency_response(cube, Selection("amplitude_m", at | {"base_amplitude_m": 0.0021}))
    np.testing.assert_array_equal(curve["amplitude_m"], cube["amplitude_m"].values[0, 0, 0, 1, 2, 1])
    assert "base amplitude Z = 2 mm (the grid point nearest to the 2.1 mm asked for)" in curve.attrs["note"]


def test_a_curve_of_no_named_damper_is_that_of_the_best_at_its_worst_base_amplitude(cube: xr.Dataset) -> None:
    worst = (cube["amplitude_m"].values[0, 0, 0]).max(axis=(2, 3))
    c, f = np.unravel_index(worst.argmin(), worst.shape)
    curve = frequency_response(cube)
    values = cube["amplitude_m"].values[0, 0, 0, c, f]
    np.testing.assert_array_equal(curve["amplitude_m"], values[values.max(axis=1).argmax()])
    assert float(curve["amplitude_m"].max()) == worst.min()


def test_dampers_are_ranked_by_their_worst_amplitude_and_frequency(cube: xr.Dataset) -> None:
    values = cube["amplitude_ratio"].values[0, 0, 0]
    worst = values.max(axis=(2, 3))
    lengths = ranked_designs(cube, Judging(), Ranking(), lambda _: {})
    np.testing.assert_array_equal(
        lengths["value"], np.sort((values * Z[:, None]).max(axis=(2, 3)), axis=None)
    )
    ratio = Ranking(metric="amplitude_ratio")
    answer = ranked_designs(cube, Judging(), ratio, lambda _: {})
    np.testing.assert_array_equal(answer["value"], np.sort(worst.ravel()))
    c, f = np.unravel_index(worst.argmin(), worst.shape)
    a, r = np.unravel_index(values[c, f].argmax(), values[c, f].shape)
    best = answer.isel(rank=0)
    assert float(best["base_amplitude_m"]) == Z[a]
    assert float(best["frequency_ratio"]) == cube["frequency_ratio"].values[r]
    assert float(best["error"]) == cube["amplitude_error"].values[0, 0, 0, c, f, a, r]
    free = ranked_designs(cube, Judging(exclude_locked=True), Ranking(), lambda _: {})
    assert free.sizes["rank"] == 5
    assert free.attrs["locked"] == 1
    assert (0.006, 1.5) not in set(
        zip(free["clearance_m"].values, free["friction_force_n"].values, strict=True)
    )
    band = ranked_designs(
        cube,
        Judging(ranges={"frequency_hz": (3.9, 4.5), "base_amplitude_m": (0.0015, 1)}),
        ratio,
        lambda _: {},
    )
    np.testing.assert_array_equal(band["value"], np.sort(values[:, :, 1:, 1:3].max(axis=(2, 3)).ravel()))


@pytest.mark.parametrize("constant", ["displacement", "velocity", "acceleration"])
def test_a_tuned_mass_damper_is_compared_at_one_base_amplitude(
    stored: tuple[Store, str], constant: str
) -> None:
    falls = constant != "displacement"
    whole = cube_of(stored, constant)
    definition = whole.attrs["study"]
    at = {"clearance_m": 0.01, "friction_force_n": 1.5, "base_amplitude_m": 0.0021}
    one, rest = at_one_amplitude(whole, at)
    assert whole.attrs["study"] == definition
    if not falls:
        assert tuple(one["status"].dims) == DIMENSIONS
        np.testing.assert_array_equal(one["clearance_ratio"], np.array([0.006, 0.01]) / 0.002)
        stiffness = MASS * (2 * np.pi * HERTZ) ** 2
        forces = np.array([0.5, 1, 1.5])
        np.testing.assert_allclose(one["friction_ratio"], forces / (stiffness * 0.002), rtol=1e-14)
    answer = said_of_it(tmd_comparison(one, Tuning(mass_ratio=0.05), rest), one, whole)
    np.testing.assert_array_equal(answer["hybrid"], whole["amplitude_ratio"].values[0, 0, 0, 1, 2, 1])
    same = frequency_response(whole, Selection("amplitude_ratio", at))
    np.testing.assert_array_equal(answer["hybrid"], same["amplitude_ratio"])
    for words in (answer.attrs, answer.attrs["in_units"]):
        assert words["verdict"]
        assert (f"The {constant} of the base is the same at every frequency" in words["note"]) is falls
    assert "2 mm" in answer.attrs["in_units"]["note"]
    with pytest.raises(QueryFault) as refused:
        at_one_amplitude(whole, {})
    assert refused.value.fault.field == "base_amplitude_m"
    # where the amplitude alone is named, it is the best damper at that
    one, rest = at_one_amplitude(whole, {"base_amplitude_m": 0.002})
    answer = tmd_comparison(one, Tuning(mass_ratio=0.05), rest)
    worst = whole["amplitude_ratio"].sel(base_amplitude_m=0.002).max("frequency_ratio")
    assert float(answer["hybrid"].max()) == float(worst.min())


@pytest.mark.parametrize("metric", ["amplitude_m", "amplitude_ratio"])
@pytest.mark.parametrize("share", [2.0, 0.1], ids=["a poor damper", "a good damper"])
@pytest.mark.parametrize("force", [False, True], ids=["base", "force"])
def test_the_worst_case_is_compared_with_a_tuned_mass_damper_and_with_the_bare_structure(
    stored: tuple[Store, str], metric: str, share: float, force: bool
) -> None:
    store, study_id = stored
    cube = store.cube(keep(store, FORCED) if force else study_id)
    cube = xr.concat([cube, cube.assign_coords(damping_ratio=[0.05])], "damping_ratio", data_vars="minimal")
    (mass,), zetas, r = cube["mass_ratio"].values, cube["damping_ratio"].values, np.linspace(0.9, 1.2, 20_001)
    shaken: Any = "force" if force else "base"
    absorber = tuned("minimax", float(mass), float(zetas[0]), shaken)
    within = {"base_amplitude_m": (0.0005, 0.003)}
    largest = 1000 * 0.002 if metric == "amplitude_m" else 1.0
    peak = max(amplitude_ratio(r, absorber, zeta, shaken).max() for zeta in zetas) * largest
    passed = 1.0 if force else 1 + 2j * zetas[0] * r
    bare = np.abs(passed / (1 - r**2 + 2j * zetas[0] * r)).max() * largest
    answer = worst_case_designs(
        cube.assign({metric: cube[metric] * share}), Judging(ranges=within), Ranking(metric=metric)
    )
    brief = answer.attrs["brief"]
    rows = {row[0]: float(row[1].split()[0]) for row in brief["rows"]}
    assert rows["without damper"] == pytest.approx(bare, rel=5e-3)
    kinds = [each["kind"] for each in answer.attrs["notes"]]
    if share == 2.0:
        assert (brief["damper"], "tuned_mass_damper" in kinds) == ("tuned_mass_damper", True)
        assert f"at worst {peak:.3g}" in brief["sentences"][0]
        assert "tuned mass damper" not in rows
    else:
        assert (brief["damper"], "tuned_mass_damper" in kinds) == ("hybrid", False)
        assert brief["sentences"][0].startswith("Best damper: ")
        assert rows["tuned mass damper"] == pytest.approx(peak, rel=5e-3)


def test_a_damper_without_a_value_is_neither_equal_nor_best(cube: xr.Dataset) -> None:
    values = cube["amplitude_m"].copy(data=np.full(cube["amplitude_m"].shape, np.nan))
    nothing = worst_case_designs(cube.assign(amplitude_m=values)).attrs["brief"]
    assert (nothing["damper"], nothing["rows"]) == (None, [])
    values[{"clearance_m": 0, "friction_force_n": 0}] = 0.5
    one = worst_case_designs(cube.assign(amplitude_m=values)).attrs["brief"]
    assert {"equal", "second"}.isdisjoint(row[0] for row in one["rows"])

    # and those with the value of the best are equal
    values = cube["amplitude_m"].copy(data=np.ones_like(cube["amplitude_m"]))
    values[{"friction_force_n": 2}] = 2.0
    rows = worst_case_designs(cube.assign(amplitude_m=values)).attrs["brief"]["rows"]
    assert [row[0] for row in rows[:3]] == ["equal"] * 3


@pytest.mark.parametrize(("constant", "order"), [("velocity", 1), ("acceleration", 2)])
def test_a_tuned_mass_damper_is_compared_where_the_displacement_of_the_base_falls_with_the_frequency(
    stored: tuple[Store, str], constant: str, order: int
) -> None:
    cube = cube_of(stored, constant)
    brief = worst_case_designs(cube).attrs["brief"]
    zeta, mass, r = cube["damping_ratio"].item(), cube["mass_ratio"].item(), np.linspace(0.9, 1.2, 100_001)
    moved = amplitude_ratio(r, tuned("minimax", mass, zeta), zeta) * Z.max() / r**order
    assert brief["damper"] == "tuned_mass_damper"
    assert f"at worst {1e3 * moved.max():.3g} mm" in brief["sentences"][0]
    (bare,) = (row[1] for row in brief["rows"] if row[0] == "without damper")
    alone = np.abs((1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r)) * Z.max() / r**order
    assert float(bare.split()[0]) == pytest.approx(1e3 * alone.max(), rel=5e-3)


@pytest.mark.parametrize("constant", ["displacement", "velocity"])
def test_the_acceleration_of_the_best_damper_is_the_largest_over_all_base_amplitudes(
    stored: tuple[Store, str], constant: str
) -> None:
    cube = cube_of(stored, constant)
    ranked = worst_case_designs(cube, Judging(exclude_locked=True))
    best = cube.sel({name: ranked[name].values[0] for name in ("clearance_m", "friction_force_n")})
    damped = np.hypot(1.0, 2.0 * best["damping_ratio"] * best["frequency_ratio"])
    forced = (
        best["relative_amplitude_m"] * damped * (2 * np.pi * HERTZ) ** 2 + best["friction_force_n"] / MASS
    )
    held = base_of(best) * (2 * np.pi * HERTZ * best["frequency_ratio"]) ** 2
    largest = xr.where(best["response_class"] == ResponseClass.LOCKED, held, forced).max()
    assert ranked.attrs["acceleration_g"] == pytest.approx(float(largest) / 9.80665)
    (row,) = (row for row in ranked.attrs["brief"]["rows"] if row[0] == "acceleration")
    assert "assumed lying, frictionless" in row[2]
    definition = json.loads(cube.attrs["study"])
    definition["physical"]["particle_friction_coefficient"] = 0.1
    rubbing = worst_case_designs(
        cube.assign_attrs(study=json.dumps(definition)), Judging(exclude_locked=True)
    )
    assert rubbing.attrs["acceleration_g"] < ranked.attrs["acceleration_g"]
    (row,) = (row for row in rubbing.attrs["brief"]["rows"] if row[0] == "acceleration")
    assert row[2].endswith("assumed lying")
    damper = {name: float(best[name]) for name in ("clearance_m", "friction_force_n")}
    curves = [frequency_response(cube, Selection(at=damper | {"base_amplitude_m": z})) for z in Z]
    assert max(curve.attrs["acceleration_g"] for curve in curves) == ranked.attrs["acceleration_g"]


@pytest.mark.parametrize(
    ("asked", "instead"), [("work-precision", "optimal designs"), ("refine", "finer axes of clearance_m")]
)
def test_what_a_study_over_base_amplitudes_does_not_answer_says_what_does(asked: str, instead: str) -> None:
    with pytest.raises(QueryFault) as refused:
        require_harmonic(tuple(AMPLITUDE_DIMENSIONS), asked)
    fault = refused.value.fault
    assert fault.field == "study"
    assert fault.allowed == f"a study with one base amplitude for {asked}"
    assert instead in fault.advice
