"""The client from a study to its deletion, over real sockets; of much it reads what is looked at."""

import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.filling import enter, put
from tests.service.conftest import CURVE, WORK_SECONDS, lasting_study, long_study, wait_until

from damperlab.service.client import Client, Conflict, NotFound, Refused, StillRunning, Stopped
from damperlab.studies.definition import parse_study
from damperlab.studies.store.store import Store


def test_asking_a_service_needs_neither_compiler_nor_cluster(service: Any) -> None:
    code = f"""
import sys
from damperlab import Client
with Client({service.url!r}) as client:
    study = client.submit({{"particle": False, "axes": {{"friction_ratio": [0.1, 0.2], "frequency_ratio": [0.9, 1]}}}})
    study.wait(progress=False)
    study.resonance_map().plot()
    study.cube(chunks=None)["amplitude_ratio"].load()
    client.simulate(0.5, particle=False, history=1).plot()
print([name for name in ("numba", "distributed", "worker", "fastapi") if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_journey(remote: Client, tmp_path: Path) -> None:
    asked = CURVE | {"name": "a client's journey", "damping_ratio": 0.0021}
    estimate = remote.estimate(asked)
    assert (estimate.points, estimate.definition["name"]) == (11, "a client's journey")
    with pytest.raises(NotFound):
        remote.study("a client's journey")

    study = remote.submit(asked)
    assert study.wait(progress=False) is study
    record = study.record
    assert (record.state, record.points_done, record.digest) == ("done", 11, estimate.digest)
    assert record.finished is not None
    assert record.started is not None
    assert record.finished >= record.started
    assert record.definition == estimate.definition

    # submitted again it is the same, in whatever form
    text = tmp_path / "study.yaml"
    text.write_text(
        "name: a client's journey\nparticle: false\ndamping_ratio: 0.0021\n"
        "axes: {friction_ratio: 0, frequency_ratio: {start: 0.5, stop: 1.5, num: 11}}\n"
    )
    arrays = asked | {"axes": {"friction_ratio": 0, "frequency_ratio": np.linspace(0.5, 1.5, 11)}}
    for other in (text, str(text), text.read_text(), arrays):
        assert remote.submit(other) == study
    assert remote.study(study.id[:6]) == study
    assert remote.study("a client's journey") == study
    assert study in remote.studies(name="journey")
    assert study in remote.studies("done")
    assert study not in remote.studies("failed")

    long = remote.submit(lasting_study("left by its client"))
    with pytest.raises(StillRunning, match="points done"):
        long.wait(progress=False, timeout=0.1)
    with pytest.raises(Conflict):
        long.delete()
    long.cancel()
    with pytest.raises(Stopped, match=r"is cancelled.*resume"):
        long.wait(progress=False)
    assert long.resume().state in ("queued", "running")
    long.cancel()
    long.delete()

    with pytest.raises(Conflict, match="there is nothing left to compute"):
        study.resume()
    study.delete()
    with pytest.raises(NotFound):
        print(study.state)
    # what was deleted may be asked for again
    again = remote.submit(asked).wait(progress=False)
    assert (again, again.record.points_done) == (study, 11)
    again.delete()


def test_named_study_of_the_paper(remote: Client) -> None:
    assert remote.estimate("figure-11").points == 49 * 33
    for wrong, said in (("figur-14", "figure-14"), (1.0, r"1\.0")):
        with pytest.raises(Refused, match=said):
            remote.submit(wrong)  # type: ignore[arg-type]


def test_record_is_handed_in_and_listed(remote: Client, tmp_path: Path) -> None:
    file = tmp_path / "five hertz.csv"  # one second, in g
    file.write_text("".join(f"{0.01 * i:.2f},{0.1 * np.sin(0.1 * np.pi * i):.17g}\n" for i in range(101)))
    record = remote.upload_record(file, units="g")
    assert (record.name, record.samples, record.duration_s) == ("five hertz", 101, pytest.approx(1.0))
    assert record.peak_acceleration_g == pytest.approx(0.1)
    assert remote.upload_record(str(file), units="g").id == record.id
    assert record in remote.records()


@pytest.mark.night
def test_waiting_outlives_a_service_that_is_killed(
    own_service: Callable[..., Any], free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("damperlab.service.client.transport.PATIENCE_SECONDS", 900.0)
    first = own_service(DAMPERLAB_PORT=str(free_port))
    url = f"http://127.0.0.1:{free_port}"
    with Client(url) as client:
        study = client.submit(long_study("killed and restarted") | {"steady": {"max_cycles": 500}})
        wait_until(lambda: study.record.blocks_done > 0)
        ended: list[Any] = []
        waiter = threading.Thread(target=lambda: ended.append(study.wait(progress=False)), daemon=True)
        waiter.start()
        first.stop(signal.SIGKILL)
        second = own_service(DAMPERLAB_PORT=str(free_port))
        waiter.join(WORK_SECONDS)
        assert ended == [study]
        record = study.record
        assert (record.state, record.points_done) == ("done", record.points_total)
    assert second.stop() == 0


SIDE, STEP = 400, 100


@pytest.fixture(scope="module")
def large(service: Any) -> Iterator[str]:
    """A cancelled study of 400 x 400 points of which the first four blocks are done, a block's index as its values."""
    store = Store.open(service.log.parent / "data")
    axes = {"friction_ratio": (0.1, 0.9), "frequency_ratio": (0.5, 1.5)}
    study = parse_study(
        {
            "name": "a large grid",
            "particle": False,
            "metrics": ["amplitude_ratio"],
            "axes": {name: {"start": a, "stop": b, "num": SIDE} for name, (a, b) in axes.items()},
        }
    )
    record = enter(store, study, (1, 1, 1, 1, STEP, STEP))
    assert store.claim(record.id, "the test")
    store.set_state(record.id, "cancelled")
    put(store, study, *range(SIDE // STEP), generation="first")
    yield record.id
    store.delete(record.id)
    store.close()


def test_slice_of_a_large_cube_fetches_its_own_blocks(service: Any, large: str) -> None:
    with Client(service.url) as client:
        cube = client.study(large).cube()
        assert cube["amplitude_ratio"].size == SIDE**2
        before = len(service.log.read_text())
        part = cube["amplitude_ratio"].isel(friction_ratio=5, frequency_ratio=slice(150, 350)).values.ravel()

    def fetched() -> int:
        return service.log.read_text()[before:].count("/zarr/amplitude_ratio/c")

    # the log has a request a moment after its answer has gone
    wait_until(lambda: fetched() >= 3)
    # 50 points of block 1, 100 of block 2, 50 of block 3
    np.testing.assert_array_equal(part, np.repeat([1.0, 2.0, 3.0], [50, 100, 50]))
    assert fetched() == 3


def test_map_of_a_large_cube(service: Any, large: str) -> None:
    with Client(service.url) as client:
        answer = client.study(large).resonance_map()
    assert answer.sizes == {"frequency_ratio": SIDE, "friction_ratio": SIDE}
    assert answer.attrs["complete"] == STEP / SIDE
    row = answer["amplitude_ratio"].sel(friction_ratio=0.1)
    np.testing.assert_array_equal(row, np.repeat(np.arange(SIDE / STEP), STEP))
    assert int(answer["amplitude_ratio"].isnull().sum()) == SIDE**2 - SIDE * STEP
