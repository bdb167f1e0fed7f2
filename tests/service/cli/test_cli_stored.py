"""Studies that a command has stored: shown, printed in units, deleted, verified, saved and restored."""

import hashlib
import itertools
import json
import shutil
from collections.abc import Iterator
from contextlib import closing
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.faults.damage import make_store
from tests.filling import fill, make_study
from tests.oracles.transmissibility import absolute_amplitude
from tests.service.cli.commands import run

from damperlab.service.cli.output import note, print_table, say
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import plan_with_chunk
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store

Stored = tuple[Path, dict[str, Any]]


def test_run_prints_the_record_that_the_store_holds_and_computes_it_once(
    stored: Stored, linear_study: Path
) -> None:
    data_dir, record = stored
    with closing(Store.open(data_dir)) as store:
        assert record == store.find(record["id"]).document()
    assert record["state"] == "done"
    assert record["points_done"] == record["points_total"] == 22
    again = run("run", linear_study, "--data-dir", data_dir, "--json", "--scheduler", "tcp://127.0.0.1:1")
    # No scheduler answers at that address: had a cluster been wanted, the run would have failed.
    assert json.loads(again.stdout) == record


def test_names_are_printed_as_they_were_typed(capsys: pytest.CaptureFixture[str]) -> None:
    """The library that prints them interprets markup and names of emojis. A name may look like either."""
    name = "[bold]pump[/bold] :fire: [red]"
    print_table(["name"], [[name]])
    say(name)
    note(name)
    told = capsys.readouterr()
    assert [line.strip() for line in (told.out + told.err).splitlines()] == ["name", name, name, name]


def test_a_study_is_found_by_the_start_of_its_id_and_by_its_name(stored: Stored) -> None:
    data_dir, record = stored
    for name in (record["id"][:5], "bare structure"):
        assert json.loads(run("show", name, "--data-dir", data_dir, "--json").stdout) == record
    listed = json.loads(run("studies", "--data-dir", data_dir, "--json").stdout)
    assert ([entry["id"] for entry in listed["studies"]], listed["cursor"]) == ([record["id"]], None)
    assert record["id"] in run("studies", "--data-dir", data_dir).stdout
    assert "0.5 to 1.5, 11 values" in run("show", record["id"], "--data-dir", data_dir).stdout


def test_a_name_of_several_studies_is_the_newest_and_a_note_says_so(tmp_path: Path) -> None:
    ids = []
    with closing(Store.open(tmp_path)) as store:
        for damping in (0.01, 0.02):
            axes = {"friction_ratio": 0, "frequency_ratio": [0.5, 2]}
            study = parse_study({"name": "pump", "particle": False, "damping_ratio": damping, "axes": axes})
            plan = plan_with_chunk(study, (1, 1, 1, 1, 1, 2), lambda _, at: np.ones(len(at["mass_ratio"])))
            ids.append(store.submit(study, plan, {})[0].id)
    shown = run("show", "pump", "--data-dir", tmp_path, "--json")
    assert json.loads(shown.stdout)["id"] == ids[1]
    assert f"Using {ids[1]}, the newest study named pump; 1 other study has this name." in shown.stderr
    assert "Using" not in run("show", ids[0], "--data-dir", tmp_path).stderr
    renamed = run("show", ids[0], "--name", "pump", "--data-dir", tmp_path)
    assert "1 other study has the name pump." in renamed.stderr
    refused = run("delete", "pump", "--yes", "--data-dir", tmp_path, status=2)
    assert "an id" in refused.stderr
    run("delete", ids[0], "--yes", "--data-dir", tmp_path)
    run("delete", "pump", "--yes", "--data-dir", tmp_path)  # the name of one study only


def test_tables_of_a_study_in_units_are_in_millimetres_and_hertz(tmp_path: Path) -> None:
    base, hertz = 0.002, 8.0
    study = {
        "name": "in units",
        "damping_ratio": 0.05,
        "axes": {
            "clearance_ratio": [3.0],
            "friction_ratio": [0.0],
            "restitution": [0.5],
            "mass_ratio": [0.0],
        },
        "physical": {
            "natural_frequency_hz": hertz,
            "base_amplitude_m": base,
            "excitation_frequency_hz": [6.0, 9.0],
        },
    }
    file = tmp_path / "study.json"
    file.write_text(json.dumps(study))
    run("run", file, "--data-dir", tmp_path / "data")
    closed = [(f, 1e3 * base * absolute_amplitude(0.05, f / hertz)) for f in (6.0, 9.0)]
    rows = [[f"{f:g}", f"{amplitude:.6g}"] for f, amplitude in closed]

    def printed(question: str, *more: str) -> list[str]:
        said = run(question, "in units", *more, "--details", "--data-dir", tmp_path / "data").stdout
        return said.partition("\n\n")[2].splitlines()[1:]

    frequency = "excitation frequency f [Hz]"
    for head, *found in (printed("response"), printed("tmd", "--mass-ratio", "0.1")):
        assert head.split("  ")[:2] in ([frequency, "amplitude [mm]"], [frequency, "hybrid [mm]"])
        assert [row.split()[:2] for row in found] == rows
    # as in a figure: the largest y is the first row below the head
    head, *found = printed("map", "--x", "clearance_ratio", "--y", "frequency_ratio")
    assert head.split() == ["f", "[Hz]", "\\", "d", "[mm]", "6"]
    assert [row.split() for row in found] == rows[::-1]


def test_a_deletion_that_is_repeated_deletes_no_other_version(tmp_path: Path) -> None:
    with closing(Store.open(tmp_path)) as store:
        old = fill(store, make_study(), solver="older")
        newer, _ = store.recompute(old.id, {"solver": "newer"})
        delete = ("delete", old.id, "--yes", "--data-dir", tmp_path)
        run(*delete)
        assert f"earlier version of {newer.id}" in " ".join(run(*delete, status=2).stderr.split())
        assert store.find(old.id).id == newer.id


def test_a_map_says_where_it_lies_along_what_it_does_not_show(tmp_path: Path) -> None:
    study = tmp_path / "three.yaml"
    axes = "{friction_ratio: 0, frequency_ratio: [0.5, 2], mass_ratio: 0.1}"
    study.write_text(f"{{name: three, particle: false, damping_ratio: [0.01, 0.02], axes: {axes}}}")
    run("run", study, "--data-dir", tmp_path)
    axes_of_map = ("--x", "frequency_ratio", "--y", "friction_ratio", "--at", "damping_ratio=0.02")
    told = run("map", "three", *axes_of_map, "--data-dir", tmp_path).stdout
    first, second = (absolute_amplitude(0.02, r) for r in (2.0, 0.5))
    begins = told.partition(";")[0]
    assert begins.endswith(f"least {first:.3g} at r = 2, γ_F = 0")
    assert f"largest {second:.3g} at r = 0.5" in told
    assert "ζ = 0.02: least" in begins


def test_a_study_that_is_done_cannot_be_cancelled(stored: Stored) -> None:
    data_dir, record = stored
    assert "done" in run("cancel", record["id"], "--data-dir", data_dir, status=1).stderr


def test_delete_asks_first_and_the_trash_gives_back(tmp_path: Path) -> None:
    data = ("--data-dir", tmp_path)

    def listed(*asked: str) -> list[str]:
        found = json.loads(run(*asked, "--json", *data).stdout)["studies"]
        return [each["id"] for each in found]

    study = tmp_path / "other.yaml"
    study.write_text("{name: other, particle: false, axes: {friction_ratio: 0, frequency_ratio: [0.5, 2]}}")
    run("run", study, *data)
    run("delete", "other", *data, status=1)  # nobody is there to answer
    run("show", "other", *data)
    run("delete", "other", "--trash", *data)
    assert listed("studies") == []
    (study_id,) = listed("studies", "--trash")
    run("undelete", "other", *data)
    assert (listed("studies"), listed("studies", "--trash")) == ([study_id], [])
    run("delete", "other", "--yes", *data)
    run("show", "other", *data, status=2)
    assert [left.name for left in (tmp_path / "cubes").iterdir()] == ["damperlab.json"]  # the owner marker


@pytest.mark.parametrize("names", [False, True])
def test_a_file_names_user_and_host_where_that_is_asked_for(
    stored: Stored, tmp_path: Path, names: bool
) -> None:
    data_dir, record = stored
    file = tmp_path / "cube.nc"
    run("export", record["id"], "-o", file, "--data-dir", data_dir, *(["--names"] if names else []))
    told = json.loads(xr.open_dataset(file, engine="h5netcdf").attrs["provenance"])
    assert {"host", "user"} & told.keys() == ({"host", "user"} if names else set())
    assert told["solver_version"] == record["provenance"]["solver_version"]


def test_an_export_is_described_as_a_crate_on_request(
    stored: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    data_dir, record = stored
    options = ("-o", tmp_path / "cube.nc", "--data-dir", data_dir, "--licence", "CC-BY-4.0", "--crate")
    run("export", record["id"], *options)
    assert xr.open_dataset(tmp_path / "cube.nc", engine="h5netcdf").attrs["license"] == "CC-BY-4.0"
    graph = json.loads((tmp_path / "ro-crate-metadata.json").read_text())["@graph"]
    entities = {each["@id"]: each for each in graph}
    whole, file = entities["./"], entities["cube.nc"]
    assert entities[whole["license"]["@id"]]["name"] == "CC-BY-4.0"
    assert entities[file["conformsTo"]["@id"]]["name"] == "CF-1.11"
    date.fromisoformat(whole["datePublished"])
    assert file["sha256"] == hashlib.sha256((tmp_path / "cube.nc").read_bytes()).hexdigest()
    assert json.loads(entities["#study"]["value"]) == record["definition"]
    # whatever an entity refers to is described and the reverse, and nobody is named
    values = itertools.chain.from_iterable(each.values() for each in graph)
    listed = itertools.chain.from_iterable(value if isinstance(value, list) else [value] for value in values)
    named = {one["@id"] for one in listed if isinstance(one, dict)}
    assert named - {"https://w3id.org/ro/crate/1.1"} == entities.keys() - {"ro-crate-metadata.json"}
    assert record["provenance"]["user"] not in json.dumps(graph).replace(record["definition"]["name"], "")
    # it is described anew where it is exported anew, and no other file beside it
    run("export", record["id"], *options[:4])
    renewed = json.loads((tmp_path / "ro-crate-metadata.json").read_text())["@graph"]
    (file,) = (each for each in renewed if each["@id"] == "cube.nc")
    assert file["sha256"] == hashlib.sha256((tmp_path / "cube.nc").read_bytes()).hexdigest()
    other = run("export", record["id"], "-o", tmp_path / "x.csv", *options[2:4], "--crate", status=2)
    assert "ro-crate-metadata.json describes cube.nc" in other.stderr
    # a table follows no conventions of netCDF
    run("export", record["id"], "-o", tmp_path / "table/x.csv", *options[2:4], "--crate")
    described = json.loads((tmp_path / "table/ro-crate-metadata.json").read_text())["@graph"]
    assert not any("CF-1.11" in map(str, each.values()) for each in described)


@pytest.fixture
def store(stored: tuple[Path, dict[str, Any]], tmp_path: Path) -> Iterator[Store]:
    shutil.copytree(stored[0], tmp_path / "data")
    opened = Store.open(tmp_path / "data")
    yield opened
    opened.close()


def test_damage_is_found_and_repaired(store: Store) -> None:
    (record,) = store.page().records
    before = store.cube(record.id).load()
    file = next(Path(store.cube_path(record.id), "blocks").iterdir())
    file.write_bytes(file.read_bytes()[:40])
    # never a curve of fill values
    assert "verify --repair" in run("response", record.id, "--data-dir", store.data_dir, status=1).stderr
    assert "lock 0" in run("store", "verify", "--data-dir", store.data_dir, status=1).stderr
    answer = run(
        "store", "verify", record.id, "--repair", "--workers", "1", "--data-dir", store.data_dir, "--json"
    )
    (mended,) = json.loads(answer.stdout)["studies"]
    assert (mended["repaired"], [damage["block"] for damage in mended["damaged"]]) == (True, [0])
    after = store.cube(record.id).load()
    assert after.drop_vars("run_time").equals(before.drop_vars("run_time"))
    assert list(verify(store, store.find(record.id))) == []


@pytest.mark.parametrize("state", ["done", "cancelled"])
def test_a_lost_block_is_computed_again(store: Store, linear_study: Path, state: str) -> None:
    (record,) = store.page().records
    before = store.cube(record.id).load()
    store.set_state(record.id, state)
    shutil.rmtree(Path(store.cube_path(record.id), "blocks"))
    said = run("run", linear_study, "--data-dir", store.data_dir).stderr
    assert "lost the file" in said
    assert "nothing was computed" not in said
    assert store.cube(record.id).load().drop_vars("run_time").equals(before.drop_vars("run_time"))
    assert list(verify(store, store.find(record.id))) == []
    again = run("run", linear_study, "--data-dir", store.data_dir).stderr
    assert "nothing was computed" in again


def test_results_of_another_solver_are_repaired_as_far_as_nothing_is_computed(tmp_path: Path) -> None:
    data = tmp_path / "data"
    make_store(data)
    store = Store.open(data)
    record = store.find("done")
    before = store.cube(record.id).load()
    description = Path(store.cube_path(record.id), "zarr.json")
    description.write_bytes(description.read_bytes().replace(b"0.47", b"0.57", 1))
    said = run(
        "map", record.id, "--x", "clearance_ratio", "--y", "friction_ratio", "--data-dir", data, status=1
    )
    assert "verify" in said.stderr
    run("store", "verify", record.id, "--repair", "--data-dir", data)
    assert list(verify(store, record)) == []
    assert store.cube(record.id).load().identical(before)
    next(Path(store.cube_path(record.id), "blocks").iterdir()).unlink()
    refused = run("store", "verify", record.id, "--repair", "--data-dir", data, status=1).stderr
    assert "damperlab recompute" in refused
    refused = run("run", record.id, "--data-dir", data, status=1).stderr
    assert "damperlab recompute" in refused
    assert store.find(record.id).blocks_done == 12  # nothing is given up that this solver may not compute
    store.close()


def test_run_goes_on_with_a_stored_study_by_its_name_or_id(store: Store) -> None:
    (record,) = store.page().records
    data = ("--data-dir", store.data_dir)
    for name in (record.id[:4], record.name):
        assert "is complete" in run("run", name, *data).stderr
    for question in ("run", "show"):
        assert f"Did you mean {record.name}?" in run(question, record.name[:-1], *data, status=2).stderr
    run("run", record.id, "--retry", *data, status=1)  # no block has failed


def test_a_study_is_shown_as_it_was_given_and_tagged(tmp_path: Path) -> None:
    study = {
        "name": "press",
        "damping_ratio": 0.02,
        "physical": {
            "mass_kg": 250,
            "natural_frequency_hz": 6,
            "base_amplitude_m": 0.0003,
            "clearance_m": [0.001, 0.002],
            "friction_force_n": 0,
            "particle_mass_kg": 20,
            "excitation_frequency_hz": {"start": 5, "stop": 7, "num": 2},
        },
        "start": {"kind": "ensemble", "n": 2, "seed": 1},
        "steady": {"max_cycles": 50},
    }
    (tmp_path / "press.json").write_text(json.dumps(study))
    run("run", tmp_path / "press.json", "--data-dir", tmp_path)
    shown = run("show", "press", "--tags", "shop", "--note", "by hand", "--data-dir", tmp_path)
    lines = dict(line.split("  ", 1) for line in shown.stdout.splitlines())
    found = {name: text.strip() for name, text in lines.items()}
    assert (found["tags"], found["note"]) == ("shop", "by hand")
    assert (found["damping_ratio"], found["mass_kg"], found["clearance_m"]) == ("0.02", "250", "0.001, 0.002")
    assert found["excitation_frequency_hz"] == "5 to 7, 2 values"
    assert found["start"] == "kind ensemble, n 2, seed 1"


def test_backup_and_restore(store: Store, tmp_path: Path) -> None:
    run("store", "backup", tmp_path / "safe", "--data-dir", store.data_dir)
    again = run("store", "backup", tmp_path / "safe", "--data-dir", store.data_dir, "--json")
    assert json.loads(again.stdout)["bytes"] == 0
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes").write_text("mine")
    refused = run("store", "backup", tmp_path / "other", "--data-dir", store.data_dir, status=2).stderr
    assert "holds other files" in refused
    restored = run("store", "restore", tmp_path / "safe", "--data-dir", tmp_path / "new", "--json")
    assert json.loads(restored.stdout)["studies"] == 1
    new = Store.open(tmp_path / "new")
    (record,) = new.page().records
    assert new.cube(record.id).load().identical(store.cube(record.id).load())
    new.close()


def test_gc_removes_what_is_old_enough(store: Store) -> None:
    orphan = store.data_dir / "cubes" / "000000000000-1.zarr"  # study 1 is another one
    orphan.mkdir()
    young = run("store", "gc", "--older-than", "0s", "--json", "--data-dir", store.data_dir)
    assert (json.loads(young.stdout)["paths"], orphan.exists()) == (0, True)
    swept = run("store", "gc", "--orphans-older-than", "0s", "--json", "--data-dir", store.data_dir)
    assert (json.loads(swept.stdout)["paths"], orphan.exists()) == (1, False)


def test_a_study_beyond_the_quota_is_refused_with_what_to_do(tmp_path: Path, linear_study: Path) -> None:
    refused = run("run", linear_study, "--quota", "1kB", "--data-dir", tmp_path, status=1).stderr
    assert "1,000 bytes" in refused
    assert "damperlab delete" in refused
    assert [path.name for path in (tmp_path / "cubes").iterdir()] == ["damperlab.json"]
