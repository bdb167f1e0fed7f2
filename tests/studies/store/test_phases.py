"""What a running study is at, as every process that looks into the catalogue sees it."""

from collections.abc import Callable
from typing import Any

from damperlab.studies.store.store import Store


def _phase(store: Store, study_id: str) -> tuple[str, int | None, int | None]:
    record = store.find(study_id)
    return record.phase, record.phase_done, record.phase_total


def test_a_phase_is_the_state_but_for_what_comes_before_the_blocks(
    store: Store, make_study: Callable[..., Any], make_plan_of: Callable[..., Any]
) -> None:
    study = make_study()
    study_id = store.submit(study, make_plan_of(study), {})[0].id
    assert _phase(store, study_id) == ("queued", None, None)
    assert store.claim(study_id, "one")
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("queued", None, None), "a phase is of a study that runs"
    store.set_state(study_id, "running", owner="one")
    assert _phase(store, study_id) == ("running", None, None)
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("starting", None, None)
    store.set_phase(study_id, "compiling", 1, 3, owner="one")
    assert _phase(store, study_id) == ("compiling", 1, 3)
    assert store.find(study_id).state == "running"
    store.set_phase(study_id, None, owner="one")
    assert _phase(store, study_id) == ("running", None, None)


def test_a_phase_ends_with_the_state_and_is_the_owners_to_say(
    store: Store, make_study: Callable[..., Any], make_plan_of: Callable[..., Any]
) -> None:
    study = make_study()
    study_id = store.submit(study, make_plan_of(study), {})[0].id
    assert store.claim(study_id, "one")
    store.set_state(study_id, "running", owner="one")
    store.set_phase(study_id, "compiling", 0, 2, owner="two")
    assert _phase(store, study_id) == ("running", None, None)
    store.set_phase(study_id, "compiling", 0, 2, owner="one")
    for state in ("cancelled", "queued", "running", "done"):
        store.set_state(study_id, state, owner="one")
        assert _phase(store, study_id) == (state, None, None)


def test_the_pace_of_a_study_leaves_its_preparation_out(
    store: Store,
    make_study: Callable[..., Any],
    make_plan_of: Callable[..., Any],
    outcome_of: Callable[..., Any],
) -> None:
    study = make_study()
    plan = make_plan_of(study)
    study_id = store.submit(study, plan, {})[0].id
    assert store.claim(study_id, "one")
    store.set_state(study_id, "running", owner="one")
    with store.catalogue.writing() as connection:
        # as if compiling had taken an hour
        connection.exec_driver_sql("UPDATE studies SET run_began = run_began - 3600")
    store.set_phase(study_id, None, owner="one")
    store.mark(study_id, outcome_of(plan.block(0)))
    left = store.find(study_id).seconds_left
    assert left is not None
    assert left < 3600
