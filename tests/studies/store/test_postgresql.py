"""The catalogue in a real PostgreSQL, and catalogues of older versions brought up to date."""

import multiprocessing
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text
from tests.faults.processes import Database
from tests.filling import make_plan_of, make_study, values_of
from tests.studies.store.racing import race

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.rebuild import rebuild
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.store import Store

SECONDS = 900


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a database of a server of our own; each test takes a schema of its own in it."""
    with closing(Database(tmp_path_factory.mktemp("postgresql") / "data")) as running:
        yield running.address


@pytest.fixture
def address(server: str, request: pytest.FixtureRequest) -> str:
    schema = f"s{abs(hash(request.node.nodeid)):x}"
    engine = create_engine(server.replace("postgresql://", "postgresql+psycopg://"))
    with engine.begin() as connection:
        connection.execute(text(f"CREATE SCHEMA {schema}"))
    engine.dispose()
    return f"{server}&options=-csearch_path%3D{schema}"


@pytest.fixture
def store(tmp_path: Path, address: str) -> Iterator[Store]:
    opened = Store.open(tmp_path / "data", address)
    yield opened
    opened.close()


def test_a_server_that_takes_connections_and_never_answers_is_a_fault_with_words(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"postgresql://somebody:secret@127.0.0.1:{silent.getsockname()[1]}/damperlab"
        with pytest.raises(StoreFault) as refused:
            Store.open(tmp_path / "data", address)
    assert "timeout" in str(refused.value)
    assert "secret" not in str(refused.value)


@pytest.mark.parametrize(
    "statement",
    [
        "SELECT pg_terminate_backend(pg_backend_pid())",  # as where the server shuts down
        "SELECT pg_cancel_backend(pg_backend_pid()), pg_sleep(60)",
        # as where a server takes no writes any more, or ended a transaction that stood still
        "DO $$ BEGIN RAISE EXCEPTION 'idle' USING ERRCODE = '25P03'; END $$",
        pytest.param("CREATE TABLE refused (number int)", marks=pytest.mark.night),
        "DO $$ BEGIN RAISE EXCEPTION 'not allowed' USING ERRCODE = '42501'; END $$",
    ],
)
def test_whatever_a_server_breaks_off_is_a_fault_and_the_next_question_is_answered(
    store: Store, statement: str
) -> None:
    with pytest.raises(StoreFault), store.catalogue.reading() as connection:
        connection.execute(text(statement))
    assert store.page().records == ()


def test_writers_that_wait_for_their_turn_leave_connections_to_readers(store: Store, server: str) -> None:
    engine = create_engine(server.replace("postgresql://", "postgresql+psycopg://"))
    writers = 40  # more than a pool has connections

    def write() -> str:
        try:
            with store.catalogue.writing():
                return "wrote"
        except StoreFault as error:
            return error.fault.found

    with engine.begin() as other, ThreadPoolExecutor(writers) as threads:
        other.execute(text(f"SELECT pg_advisory_xact_lock({0x64616D70})"))
        waiting = [threads.submit(write) for _ in range(writers)]
        deadline = time.monotonic() + SECONDS
        while store.catalogue._engine.pool.checkedout() < 1:  # type: ignore[attr-defined]
            assert time.monotonic() < deadline
        assert store.page().records == ()
        assert not any(each.done() for each in waiting)
        other.rollback()
        assert {each.result() for each in waiting} == {"wrote"}
    engine.dispose()


def test_a_pool_without_a_free_connection_is_a_fault(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store.catalogue._engine.pool, "_timeout", 0.01)

    def take_all(held: ExitStack) -> None:
        while True:
            held.enter_context(store.catalogue.reading())

    with ExitStack() as held, pytest.raises(StoreFault, match="QueuePool limit"):
        take_all(held)
    assert store.page().records == ()


def test_a_rebuilt_catalogue_takes_studies_with_new_numbers(tmp_path, address):
    """PostgreSQL's counter does not learn from numbers that were given."""
    data = tmp_path / "data"
    first = Store.open(data)
    for ratio in (0.1, 0.2, 0.3):
        first.submit(make_study(damping_ratio=ratio), make_plan_of(make_study()), {})
    first.delete(first.page().records[0].id)
    first.close()
    (data / "catalogue.sqlite").unlink()
    assert (rebuild(data, address).studies, rebuild(data, address).known) == (2, 2)
    store = Store.open(data, address)
    for ratio in (0.3, 0.4):
        record, created = store.submit(make_study(damping_ratio=ratio), make_plan_of(make_study()), {})
        assert created
        assert store.cube(record.id).sizes
    assert len(store.page().records) == 4
    store.close()


def test_a_folder_and_its_database_belong_together_before_the_first_study(tmp_path, address):
    Store.open(tmp_path / "data", address).close()
    with pytest.raises(StoreFault, match="DAMPERLAB_CATALOGUE"):
        Store.open(tmp_path / "data")
    assert not (tmp_path / "data" / "catalogue.sqlite").exists()
    with pytest.raises(StoreFault, match="different data folder"):
        Store.open(tmp_path / "other", address)
    Store.open(tmp_path / "data", address).close()
    rebuild(tmp_path / "other", address)
    Store.open(tmp_path / "other", address).close()


def test_a_study_lives_and_dies(store):
    study = make_study("in PostgreSQL")
    plan = make_plan_of(study)
    record, created = store.submit(study, plan, {})
    assert created
    assert not (store.data_dir / "catalogue.sqlite").exists()
    assert store.submit(study, plan, {}) == (record, False)
    assert store.claim(record.id, "one")
    assert not store.claim(record.id, "two")
    store.set_state(record.id, "running")
    for index in (0, 7):
        block = plan.block(index)
        outcome = write_region(store.cube_path(record.id), block, values_of(study, block), "g")
        for _ in range(2):
            store.mark(record.id, outcome)
    assert store.find("in PostgreSQL").blocks_done == 2
    assert (store.cube(record.id)["status"] == 0).sum() == store.find(record.id[:6]).points_done
    assert [found.id for found in store.page(wanted=Wanted(name="POSTGRE")).records] == [record.id]
    assert store.page(wanted=Wanted(name="%")).records == store.page(wanted=Wanted(name="_")).records == ()
    assert store.remark(record.id, Remarks(("rig-2",), "n")).tags == ("rig-2",)
    assert [found.id for found in store.page(wanted=Wanted(tag="rig-2")).records] == [record.id]
    assert not store.page(wanted=Wanted(tag="rig")).records
    assert [found.id for found in store.page(wanted=Wanted(axis="mass_ratio", low=0.1)).records] == [
        record.id
    ]
    store.release(record.id, "one")
    assert store.forget(record.id, [0], "by hand").blocks_done == 1
    for strange in ("a\x00b", "\ud800", "x" * 10_000):
        with pytest.raises(StudyNotFound):
            store.find(strange)
    store.delete(record.id)
    assert store.page().records == ()
    assert store.events(record.id)[-1][1] == "deleted"


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_processes_race_and_each_block_is_marked_once(tmp_path, request, kind):
    address = request.getfixturevalue("address") if kind == "postgresql" else None
    start = multiprocessing.get_context("spawn")
    begin, told = start.Barrier(3), start.SimpleQueue()
    processes = [
        start.Process(target=race, args=(tmp_path, address, str(number), begin, told)) for number in range(3)
    ]
    for process in processes:
        process.start()
    for process in processes:
        process.join(SECONDS)
        assert process.exitcode == 0
    answers = [told.get() for _ in processes]
    assert sorted(created for _, created, _ in answers) == [False, False, True]
    assert sorted(won for _, _, won in answers) == [False, False, True]
    store = Store.open(tmp_path, address)
    (record,) = store.page().records
    assert {study_id for study_id, _, _ in answers} == {record.id}
    assert len(list((tmp_path / "cubes").glob("*.zarr"))) == 1
    assert store.pending(record.id).size == 0
    assert record.blocks_done == record.points_done == record.blocks_total == 15
    assert record.seconds == pytest.approx(1.5)
    store.close()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("postgresql://nobody:secret@127.0.0.1:1/none", "server"),
        ("mysql://somewhere/else", "SQLite"),
        ("no address", r"postgresql://"),
    ],
)
def test_a_catalogue_that_cannot_be_used_is_told_without_its_password(tmp_path, given, told):
    with pytest.raises(StoreFault, match=f"(?i){told}") as caught:
        Store.open(tmp_path, given)
    assert "secret" not in str(caught.value)
