"""Cubes in a bucket of a real S3 server: the promises of a folder, kept over HTTP."""

import itertools
import pickle
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import xarray as xr
from tests.faults.processes import ObjectServer
from tests.filling import enter, fill, make_study, put
from tests.object_store import BUCKET, SECRET, environment, proxy_before

from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.faults import StoreAway, StoreFault
from damperlab.studies.store.files.bucket import Bucket, open_bucket
from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

METRICS = ["amplitude_ratio", "response_class", "period"]
_prefixes = itertools.count()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ObjectServer]:
    running = ObjectServer(tmp_path_factory.mktemp("objects") / "server")
    running.wait()
    yield running
    running.kill()


@pytest.fixture
def address(server: ObjectServer, monkeypatch: pytest.MonkeyPatch) -> str:
    """A place of its own in the bucket; the environment leads to the server."""
    for name, value in server.environment.items():
        monkeypatch.setenv(name, value)
    return f"s3://{BUCKET}/test {next(_prefixes)}".replace(" ", "-")


@pytest.fixture
def opened(tmp_path: Path, address: str) -> Iterator[Callable[..., Store]]:
    """Open stores by the name of their data directory, in the bucket unless told otherwise."""
    stores: list[Store] = []

    def open_one(name: str = "data", cubes: str | None = address) -> Store:
        stores.append(Store.open(tmp_path / name, cubes=cubes))
        return stores[-1]

    yield open_one
    for store in stores:
        store.close()


def filled(store: Store) -> Record:
    return fill(store, make_study(metrics=METRICS))


def _objects(store: Store) -> dict[str, bytes]:
    return {entry.key: store.shelf.get(entry.key) for entry in store.shelf.entries()}


def test_folder_and_bucket_hold_the_same(opened):
    here, there = opened("here", None), opened()
    record = filled(there)
    assert filled(here).id == record.id
    cubes = [store.cube(record.id).drop_attrs().load() for store in (here, there)]
    xr.testing.assert_identical(*cubes)
    assert [list(verify(store, record)) for store in (here, there)] == [[], []]


def test_a_deleted_study_leaves_no_object_and_gc_takes_cubes_that_nobody_owns(opened):
    store = opened()
    record = filled(store)
    orphan = store.shelf.at("0123456789ab-1.zarr")
    orphan.put("zarr.json", b"of a submission that was killed")
    assert collect_garbage(store, 0.0).paths == 0  # too young: the catalogue may have lost its study
    assert collect_garbage(store, orphan_seconds=0.0, dry_run=True).paths == 1
    assert collect_garbage(store, orphan_seconds=0.0).paths == 1
    assert list(orphan.entries()) == []
    assert list(verify(store, record)) == []
    store.delete(record.id)
    store.bury()
    assert _objects(store) == {}


def test_backup_to_a_folder_and_restore_to_another_bucket(opened, address):
    store = opened()
    record = filled(store)
    backup, restored = opened("backup", None), opened("restored", f"{address}-again")
    copy_store(store, backup)
    copied = copy_store(backup, restored)
    assert (copied.studies, copied.blocks) == (1, record.blocks_total)
    assert list(verify(restored, restored.find(record.id))) == []
    xr.testing.assert_identical(restored.cube(record.id).load(), store.cube(record.id).load())
    assert _objects(restored) == _objects(store)


def test_the_catalogue_remembers_its_bucket_and_shares_it_with_no_other(opened, address):
    record = filled(opened())
    again = opened("data", None)
    assert again.shelf.address == f"{address}/cubes"
    assert list(verify(again, record)) == []
    with pytest.raises(StoreFault, match="a catalogue other than"):
        opened("other")
    with pytest.raises(StoreFault, match="none of this catalogue's cubes"):
        opened("data", f"{address}-elsewhere")
    filled(opened("local", None))
    with pytest.raises(StoreFault, match="backup"):
        opened("local", f"{address}-elsewhere")


def test_one_of_two_gets_a_name_that_is_put_once(address):
    bucket = open_bucket(address)
    assert bucket.put_new("name", b"first")
    assert bucket.put_new("name", b"first")  # the same again, as after an answer that was lost
    assert not bucket.put_new("name", b"second")
    assert bucket.get("name") == b"first"


@pytest.mark.parametrize(
    "wrong",
    ["s3://", "s3://B", "s3://cubes/../up", "s3://cubes/a//b", "s3://key:secret@cubes/x", "http://cubes"],
)
def test_addresses_of_no_bucket_are_refused_without_repeating_secrets(opened, wrong):
    with pytest.raises(StoreFault, match="s3://bucket") as refused:
        opened("data", wrong)
    assert "secret" not in str(refused.value)


def test_a_shelf_travels_by_its_address_alone(address):
    bucket = open_bucket(address)
    packed = pickle.dumps(bucket)
    assert SECRET.encode() not in packed
    assert pickle.loads(packed) == bucket


def test_no_secret_is_stored_or_told(opened, tmp_path, monkeypatch, address):
    store = opened()
    record = filled(store)
    shelf, _ = store.snapshot(record.id)
    assert SECRET not in repr(vars(shelf)) + shelf.address + store.cube_path(record.id)
    store.close()
    stored = b"".join(file.read_bytes() for file in tmp_path.rglob("*") if file.is_file())
    assert SECRET.encode() not in stored
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "not-the-secret-0816")
    with pytest.raises(PermissionError, match="AWS_SECRET_ACCESS_KEY") as refused:
        open_bucket(address).get("anything")
    assert "not-the-secret" not in str(refused.value)
    assert "\n" not in str(refused.value)


def test_plain_http_is_for_this_machine_unless_allowed(monkeypatch, address):
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://storage.example:8333")
    with pytest.raises(StoreFault, match="AWS_ALLOW_HTTP"):
        open_bucket(address)
    monkeypatch.setenv("AWS_ALLOW_HTTP", "true")
    assert isinstance(open_bucket(address), Bucket)


@pytest.mark.parametrize("mode", [pytest.param("refuse", marks=pytest.mark.night), "cut"])
def test_a_server_that_does_not_serve_is_told_and_forgotten_when_it_does(server, opened, monkeypatch, mode):
    # as few tries as still tell a short trouble from a long one
    monkeypatch.setattr("damperlab.studies.store.files.bucket.RETRIES", 2)
    record = filled(opened())
    with proxy_before(server.door) as proxy:
        monkeypatch.setenv("AWS_ENDPOINT_URL", environment(proxy.address)["AWS_ENDPOINT_URL"])
        store = opened()
        cube = store.cube(record.id)
        proxy.mode = mode
        with pytest.raises(StoreAway, match="AWS_"):
            cube["period"].load()
        with pytest.raises(StoreAway):
            store.cube(record.id)
        with pytest.raises(StoreAway):
            list(verify(store, record))  # says nothing of what is stored
        with pytest.raises(ShelfAway):
            store.shelf.put("x", b"y")
        assert proxy.met > 2
        proxy.mode = "well"
        assert list(verify(store, record)) == []
        assert cube["period"].load().notnull().any()


def test_a_server_that_answers_too_late_is_told_and_what_it_took_is_no_result(server, opened, monkeypatch):
    """A request that timed out may still have stored its object. No reader may take that object for a result."""
    study = make_study(metrics=METRICS)
    record = enter(opened(), study)
    # of the one client that goes through the proxy
    monkeypatch.setattr("damperlab.studies.store.files.bucket.REQUEST_SECONDS", 1)
    monkeypatch.setattr("damperlab.studies.store.files.bucket.RETRY_SECONDS", 1)
    with proxy_before(server.door) as proxy:
        monkeypatch.setenv("AWS_ENDPOINT_URL", environment(proxy.address)["AWS_ENDPOINT_URL"])
        store = opened()
        proxy.mode, proxy.delay_seconds = "slow", 2.0
        for ask in (lambda: put(store, study, 0, generation="late"), lambda: store.cube(record.id)):
            met = proxy.met
            with pytest.raises((ShelfAway, StoreAway), match="s3://"):
                ask()
            assert proxy.met - met <= 2, "it was asked again and again"
        with pytest.raises(StoreAway):
            list(verify(store, record))
        proxy.mode = "well"
        assert store.pending(record.id).size == record.blocks_total
        put(store, study, *range(record.blocks_total), generation="in time")
        store.set_state(record.id, "done")
        assert list(verify(store, store.find(record.id))) == []
        assert (store.cube(record.id)["status"] == 0).all()


def test_a_catalogue_is_made_again_from_a_bucket(opened, address, tmp_path):
    store = opened("lost")
    record = filled(store)
    whole = store.cube(record.id).load()
    gone = enter(store, make_study("gone", damping_ratio=0.3))
    store.delete(gone.id)
    found = [rebuild(tmp_path / "new", cubes=address) for _ in range(2)]
    assert [(one.studies, one.known, one.deleted, one.trouble) for one in found] == [
        (1, 0, 1, []),
        (0, 1, 0, []),
    ]
    again = opened("new")
    assert [one.id for one in again.page().records] == [record.id]
    assert again.cube(record.id).load().identical(whole)
    assert list(verify(again, again.find(record.id))) == []
