"""What a scheduler learns of the calls that it hands on."""

import pytest

from damperlab.worker.cluster.cluster import connect
from damperlab.worker.dispatch.errands import Errands
from damperlab.worker.provenance import computing
from damperlab.worker.worker_process.examination import examine
from damperlab.worker.worker_process.sealed_call import sealed


def test_a_sealed_call_is_made_with_its_arguments() -> None:
    make, call = sealed(divmod, 7, 3)
    assert make(call) == (2, 1)
    make, call = sealed(divmod, 7, 0)
    with pytest.raises(ZeroDivisionError):
        make(call)


def test_a_sealed_call_can_be_made_by_who_knows_its_function_alone() -> None:
    """A worker of an earlier version then answers that it is one, and not that it lacks a module."""
    _, call = sealed(examine, "", "", "other", None)
    assert examine.__module__.encode() in call
    assert sealed.__module__.encode() not in call


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_a_scheduler_loads_neither_solver_nor_store_for_what_workers_do() -> None:
    with connect(workers=1) as client:
        (address,) = client.nthreads()
        errands = Errands(client, 0)
        facts = errands.send(errands.key("facts"), address, (computing,)).result()
        assert facts["identity"] == computing()["identity"]
        # what it raises comes back as well
        refused = errands.send(
            errands.key("examination"), address, (examine, "", "", "other", None)
        ).exception()
        assert type(refused).__name__ == "WrongCode"
        loaded = client.run_on_scheduler(eval, "list(__import__('sys').modules)")
    assert "distributed.scheduler" in loaded
    assert not {"numba", "pydantic", "sqlalchemy", computing.__module__, examine.__module__} & set(loaded)
