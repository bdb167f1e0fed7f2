"""Exports: every point once, every digit back, nothing under the name until it is whole; many blocks to a chunk."""

import csv
import io
import itertools
import json
import re
import tracemalloc
from itertools import islice
from math import prod

import h5netcdf
import numpy as np
import pyarrow.parquet
import pytest
import xarray as xr
import zarr
from tests.filling import enter, entered, make_plan_of, make_study, outcome_of, values_of
from zarr.core.buffer import default_buffer_prototype
from zarr.storage import MemoryStore

import damperlab.studies.store.export.export
from damperlab.studies.conventions import of_variable
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.cube.description import describe_cube, plain_metadata
from damperlab.studies.store.export.export import csv_lines, parquet_pieces, write_file
from damperlab.studies.store.export.grouped import POINTS, group_of, grouped_chunks, grouped_metadata
from damperlab.studies.store.export.slabs import rows, slabs
from damperlab.studies.store.faults import BlockDamaged
from damperlab.studies.units import coordinates_in_units, with_units
from damperlab.studies.variables import DIMENSIONS

CELL_METHODS = re.compile(
    r"((time|realization): (maximum|minimum|mean|root_mean_square|standard_deviation)( \([^:()]+\))?( |$))+"
)
METRICS = ["amplitude_ratio", "amplitude_error", "impact_speed_max", "response_class", "cycles"]
"""Floats, codes and counts."""
SHAPES = [(1, 1, 1, 5, 3, 4), (1, 3, 1, 4, 2, 7), (2, 1, 3, 1, 1, 1), (1, 1, 1, 1, 1, 40)]


@pytest.fixture
def cube(store):
    study, plan, study_id = entered(store, metrics=METRICS)
    rng = np.random.default_rng(3)
    for index in range(plan.count - 2):
        block = plan.block(index)
        values = values_of(study, block)
        values["amplitude_ratio"] = rng.standard_normal(block.shape)
        write_region(store.cube_path(study_id), block, values)
        store.mark(study_id, outcome_of(block))
    return store.cube(study_id)


@pytest.mark.parametrize("budget", [1, 30, 10**6])
@pytest.mark.parametrize("shape", SHAPES)
def test_slabs_and_rows_hold_every_point_once(shape, budget):
    for chunk in itertools.product(*({1, min(2, n), n} for n in shape)):
        numbers = np.arange(np.prod(shape)).reshape(shape)
        ordered = np.concatenate([numbers[slab].ravel() for slab in rows(shape, chunk, budget)])
        np.testing.assert_array_equal(ordered, numbers.ravel())
        pieces = [numbers[slab] for slab in slabs(shape, chunk, budget)]
        np.testing.assert_array_equal(np.sort(np.concatenate([p.ravel() for p in pieces])), numbers.ravel())
        assert max(p.size for p in pieces) <= max(budget, np.prod(chunk))
        starts = [
            part.start % step
            for slab in slabs(shape, chunk, budget)
            for part, step in zip(slab, chunk, strict=True)
        ]
        assert not any(starts)  # along chunk borders


@pytest.mark.parametrize("budget", [16])
def test_csv_has_a_row_a_point_and_every_digit(cube, monkeypatch, budget):
    monkeypatch.setattr(damperlab.studies.store.export.export, "BUDGET", budget)
    table = list(csv.reader("".join(csv_lines(cube)).splitlines()))
    names = [*DIMENSIONS, *cube.data_vars]
    assert table[0] == names
    columns = dict(zip(names, zip(*table[1:], strict=True), strict=True))
    grid = np.meshgrid(*(cube[name].values for name in DIMENSIONS), indexing="ij")
    for name, values in zip(DIMENSIONS, grid, strict=True):
        np.testing.assert_array_equal(np.array(columns[name], float), values.ravel())
    for name in cube.data_vars:
        np.testing.assert_array_equal(np.array(columns[name], float), cube[name].values.ravel().astype(float))
    assert set(columns["status"]) == {"0", "-1"}


@pytest.mark.parametrize("budget", [16, 2**18])
def test_netcdf_brings_the_cube_back(cube, tmp_path, monkeypatch, budget):
    monkeypatch.setattr(damperlab.studies.store.export.export, "BUDGET", budget)
    path = tmp_path / "cube.nc"
    write_file(cube, path, "netcdf")
    with xr.open_dataset(path, engine="h5netcdf") as back:
        xr.testing.assert_identical(back.load(), cube.load())
        assert back["status"].dtype == np.int8
    assert list(tmp_path.glob("*.nc*")) == [path]


STRUCTURE = {"mass_kg": 2.0, "natural_frequency_hz": 4.0, "base_amplitude_m": 0.003}


@pytest.fixture
def in_units(store):
    """A cube of a study whose clearance and frequency are given in units, its friction and mass as ratios."""
    study, plan, study_id = entered(
        store,
        metrics=METRICS,
        physical=STRUCTURE | {"clearance_m": [0.006, 0.03], "excitation_frequency_hz": [3.5, 4.0, 4.5]},
        axes={"friction_ratio": [0.1, 0.2], "mass_ratio": 0.05, "restitution": 0.5},
    )
    rng = np.random.default_rng(4)
    for block in map(plan.block, range(plan.count)):
        values = values_of(study, block) | {"amplitude_ratio": rng.uniform(1, 9, block.shape)}
        write_region(store.cube_path(study_id), block, values)
        store.mark(study_id, outcome_of(block))
    return store.cube(study_id)


def test_a_study_in_units_is_exported_in_units_beside_its_ratios(in_units, tmp_path):
    write_file(in_units, tmp_path / "cube.nc", "netcdf")
    stiffness = 2.0 * (2 * np.pi * 4.0) ** 2
    with xr.open_dataset(tmp_path / "cube.nc", engine="h5netcdf") as back:
        assert back["clearance_m"].dims == ("clearance_ratio",)
        np.testing.assert_allclose(back["clearance_m"], [0.006, 0.03], rtol=1e-15)
        np.testing.assert_allclose(back["frequency_hz"], [3.5, 4.0, 4.5], rtol=1e-15)
        np.testing.assert_allclose(
            back["friction_force_n"], [0.1 * stiffness * 0.003, 0.2 * stiffness * 0.003]
        )
        np.testing.assert_allclose(back["particle_mass_kg"], [0.1])
        assert set(back.coords) - set(back.dims) == {
            "clearance_m",
            "frequency_hz",
            "friction_force_n",
            "particle_mass_kg",
        }
        assert back["clearance_m"].attrs["units"] == "m"
        np.testing.assert_array_equal(back["amplitude_m"], 0.003 * back["amplitude_ratio"])
        assert back["amplitude_m"].attrs["units"] == "m"
        speed = 2 * np.pi * 4.0 * 0.003
        np.testing.assert_allclose(back["impact_speed_max_m_per_s"], speed * back["impact_speed_max"])
        assert back["impact_speed_max_m_per_s"].attrs["units"] == "m s-1"
        xr.testing.assert_identical(
            back.drop_vars(set(back.variables) - set(in_units.variables)).load(), in_units.load()
        )
        xr.testing.assert_identical(with_units(in_units).load(), back.load())
        table = list(csv.DictReader(io.StringIO("".join(csv_lines(in_units)))))
        parquet = pyarrow.parquet.read_table(io.BytesIO(b"".join(parquet_pieces(in_units))))
        assert parquet.column_names == list(table[0])
        for name in ("clearance_m", "friction_force_n", "amplitude_m"):
            column = back[name].broadcast_like(back["amplitude_ratio"]).values.ravel()
            np.testing.assert_array_equal([float(row[name]) for row in table], column)
            np.testing.assert_array_equal(parquet[name].to_numpy(), column)
        assert parquet.schema.field("amplitude_m").metadata[b"units"] == b"m"


def test_what_the_block_has_no_number_for_stays_a_ratio(in_units, cube):
    lacking = in_units.copy()
    study = json.loads(in_units.attrs["study"])
    study["physical"]["mass_kg"] = [1.0, 2.0]
    lacking.attrs["study"] = json.dumps(study)
    assert {each.name for each in coordinates_in_units(lacking)} == {"clearance_m", "frequency_hz"}
    assert set(with_units(cube).variables) == set(cube.variables)


def test_a_netcdf_that_fails_leaves_the_old_file(cube, tmp_path, monkeypatch):
    path = tmp_path / "cube.nc"
    path.write_text("the old one")

    def refuse(*_: object, **__: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(h5netcdf.File, "create_variable", refuse)
    with pytest.raises(OSError, match="no space"):
        write_file(cube, path, "netcdf")
    assert path.read_text() == "the old one"
    assert [p.name for p in tmp_path.iterdir() if p.is_file()] == ["cube.nc"]


def test_exports_hold_a_piece_of_the_cube_at_a_time(store, tmp_path, monkeypatch):
    monkeypatch.setattr(damperlab.studies.store.export.export, "BUDGET", 2000)
    monkeypatch.setattr(damperlab.studies.store.export.export, "ROWS_AT_ONCE", 250)
    axes = {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 20},
        "friction_ratio": {"start": 0, "stop": 1, "num": 20},
        "restitution": 0.5,
        "mass_ratio": 0.1,
        "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 50},
    }
    study = make_study(axes=axes)
    study_id = enter(store, study, (1, 1, 1, 4, 20, 50)).id
    cube = store.cube(study_id)
    in_memory = cube.nbytes
    assert in_memory > 2e6
    # what is loaded once is loaded before memory is watched
    write_file(cube.isel(clearance_ratio=slice(0, 1)), tmp_path / "small.nc", "netcdf")
    tracemalloc.start()
    write_file(cube, tmp_path / "cube.nc", "netcdf")
    # the header and a thousand rows
    assert sum(text.count("\n") for text in islice(csv_lines(cube), 5)) == 1001
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < in_memory / 2


def test_parquet_brings_every_bit_back_in_many_pieces(cube, monkeypatch):
    monkeypatch.setattr(damperlab.studies.store.export.export, "BUDGET", 7)
    pieces = list(parquet_pieces(cube))
    assert len(pieces) > 5
    file = pyarrow.parquet.ParquetFile(io.BytesIO(b"".join(pieces)))
    assert file.num_row_groups == len(pieces) - 1
    table = file.read()
    assert table.column_names == [*DIMENSIONS, *cube.data_vars]
    axes = np.meshgrid(*(cube[name].values for name in DIMENSIONS), indexing="ij")
    for name, axis in zip(DIMENSIONS, axes, strict=True):
        np.testing.assert_array_equal(table[name].to_numpy(), axis.ravel())
    for name in cube.data_vars:
        column = table[str(name)].to_numpy()
        assert column.dtype == cube[name].dtype
        assert column.tobytes() == cube[name].values.tobytes()
        assert table.schema.field(str(name)).metadata[b"units"].decode() == cube[name].attrs["units"]
    assert table.schema.metadata[b"digest"].decode() == cube.attrs["digest"]


@pytest.mark.parametrize(
    ("shape", "chunk"),
    [
        ((1, 4, 4, 50, 50, 250), (1, 1, 1, 1, 4, 250)),
        ((1, 1, 1, 5, 3, 4), (1, 1, 1, 2, 2, 3)),
        ((1, 1, 1, 1, 1, 10**6), (1, 1, 1, 1, 1, 999)),
        ((2, 2, 2, 300, 300, 300), (2, 2, 2, 30, 30, 30)),
    ],
)
def test_groups_are_whole_blocks_within_a_bound(shape, chunk):
    grouped = grouped_chunks(shape, chunk)
    assert all(step % own == 0 for step, own in zip(grouped, chunk, strict=True))
    assert prod(grouped) <= max(POINTS, prod(chunk))
    # along the first dimension that is not covered another block would be too much, or there is none
    counts = [-(-extent // own) for extent, own in zip(shape, chunk, strict=True)]
    axis = max((a for a in range(6) if grouped[a] < counts[a] * chunk[a]), default=None)
    assert axis is None or prod(grouped) // grouped[axis] * (grouped[axis] + chunk[axis]) > POINTS


def test_zarr_reads_the_groups_as_the_cube_is(store, monkeypatch):
    monkeypatch.setattr(
        "damperlab.studies.store.export.grouped.POINTS", 24
    )  # some groups in this small cube, cut off at its ends
    study = make_study(metrics=["amplitude_ratio", "period"])
    plan = make_plan_of(study)
    record, _ = store.submit(study, plan, {"host": "one", "user": "somebody", "numba": "0"})
    for index in range(plan.count):
        block = plan.block(index)
        outcome = write_region(store.cube_path(record.id), block, values_of(study, block), "g")
        store.mark(record.id, outcome)
    shelf, marks = store.snapshot(record.id)
    described = describe_cube(shelf.get("zarr.json"))
    metadata = grouped_metadata(plain_metadata(shelf.get("zarr.json"), complete=True))
    assert json.loads(json.loads(metadata)["attributes"]["provenance"]) == {"numba": "0"}
    step = json.loads(metadata)["consolidated_metadata"]["metadata"]["period"]["chunk_grid"]["configuration"]
    counts = [-(-extent // at) for extent, at in zip(record.shape, step["chunk_shape"], strict=True)]
    assert 1 < prod(counts) < plan.count
    buffer = default_buffer_prototype().buffer.from_bytes
    held = {"zarr.json": buffer(metadata)}
    seen: list[int] = []
    for place in np.ndindex(*counts):
        for name in described.arrays:
            key = f"{name}/{'.'.join(map(str, place))}"
            group = group_of(key, described)
            assert group is not None
            held[key] = buffer(group.content(shelf, marks))
        seen += group.blocks()
    assert sorted(seen) == list(range(plan.count))
    shown = zarr.open_group(MemoryStore(held), mode="r", use_consolidated=True)
    for name, expected in store.cube(record.id).data_vars.items():
        np.testing.assert_array_equal(np.asarray(shown[str(name)][:]), expected.values)  # type: ignore[index]
    before = group.tag(marks)
    assert group.tag({**marks, group.blocks()[0]: "other"}) != before
    shelf.remove("blocks/0~g")
    with pytest.raises(BlockDamaged):
        group_of(f"{group.array.name}/0.0.0.0.0.0", described).content(shelf, marks)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "key", ["period/0.0.0.0.0", "period/0.0.0.0.0.99", "period/c.0.0.0.0.0.0", "x/0", "zarr.json"]
)
def test_other_keys_are_no_groups(store, key):
    record = enter(store, make_study())
    assert group_of(key, describe_cube(store.snapshot(record.id)[0].get("zarr.json"))) is None


def test_exports_and_zarr_follow_the_conventions_that_other_programs_read(store, tmp_path):
    # loaded here: both take seconds
    import pint_xarray  # noqa: F401 - the accessor .pint
    from cf_xarray.units import units as cf_units  # and the accessor .cf

    study = make_study(physical={"mass_kg": 20, "natural_frequency_hz": 4, "base_amplitude_m": 0.001})
    plan = make_plan_of(study)
    record = enter(store, study).id
    block = plan.block(0)
    write_region(store.cube_path(record), block, values_of(study, block))
    store.mark(record, outcome_of(block))
    write_file(store.cube(record), tmp_path / "cube.nc", "netcdf")
    with xr.open_dataset(tmp_path / "cube.nc") as found:
        assert found.attrs["Conventions"] == "CF-1.11"
        assert {"title", "source", "history", "references"} <= found.attrs.keys()
        # cf-xarray finds what stands beside a result, pint-xarray its unit
        assert set(found.cf[["amplitude_ratio"]].variables) >= {
            "amplitude_ratio",
            "amplitude_error",
            "status",
        }
        quantified = found.drop_vars(["provenance"], errors="ignore").pint.quantify(unit_registry=cf_units)
        assert quantified["amplitude_ratio"].pint.units == cf_units.dimensionless
        assert quantified["amplitude_m"].pint.units == cf_units.metre
        assert "amplitude_error_m" in found["amplitude_m"].attrs["ancillary_variables"].split()
        for variable in found.data_vars.values():
            for name in variable.attrs.get("ancillary_variables", "").split():
                assert name in found, (variable.name, name)
            # https://cfconventions.org, 7.3: names, methods, and what else is to be said of them
            assert CELL_METHODS.fullmatch(variable.attrs.get("cell_methods", "time: mean")), variable.name
            kind = variable.dtype.kind
            assert (
                np.isnan(variable.encoding["_FillValue"])
                if kind == "f"
                else "_FillValue" not in variable.encoding
            )
        zarr_attributes = store.cube(record)["amplitude_ratio"].attrs
        assert found["amplitude_ratio"].attrs["cell_methods"] == zarr_attributes["cell_methods"]


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("peak_relative_displacement_m", "time: maximum"),
        ("peak_relative_displacement_lowest_m", "time: maximum realization: minimum"),
        ("peak_relative_displacement_mean_m", "time: maximum realization: mean"),
        ("peak_absolute_acceleration_std_m_s2", "time: maximum realization: standard_deviation"),
        ("peak_absolute_acceleration_highest_m_s2", "time: maximum realization: maximum"),
        ("rms_absolute_acceleration_m_s2", "time: root_mean_square"),
    ],
)
def test_a_result_over_perturbed_starts_says_how_it_is_taken_over_them(name, method):
    assert of_variable(name, ["status"]) == {"ancillary_variables": "status", "cell_methods": method}
    assert CELL_METHODS.fullmatch(method)
