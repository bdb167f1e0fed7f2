"""What a running study is at, as every process that looks into the catalogue sees it."""

from tests.studies.store.filling import entered, outcome_of

from damperlab.studies.store.store import Store


def _phase(store: Store, study_id: str) -> tuple[str, int | None, int | None]:
    record = store.find(study_id)
    return record.phase, record.phase_done, record.phase_total


def test_a_phase_is_the_state_but_for_what_its_owner_says_before_the_blocks(store: Store) -> None:
    *_, study_id = entered(store)
    assert _phase(store, study_id) == ("queued", None, None)
    assert store.claim(study_id, "one")
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("queued", None, None), "a phase is of a study that runs"
    store.set_state(study_id, "running", owner="one")
    assert _phase(store, study_id) == ("running", None, None)
    store.set_phase(study_id, "starting", owner="one")
    assert _phase(store, study_id) == ("starting", None, None)
    store.set_phase(study_id, "compiling", 0, 2, owner="two")
    assert _phase(store, study_id) == ("starting", None, None)
    store.set_phase(study_id, "compiling", 1, 3, owner="one")
    assert _phase(store, study_id) == ("compiling", 1, 3)
    for state in ("cancelled", "queued", "running", "done"):
        store.set_state(study_id, state, owner="one")
        assert _phase(store, study_id) == (state, None, None)


def test_the_pace_of_a_study_leaves_its_preparation_out(store: Store) -> None:
    _, plan, study_id = entered(store)
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
