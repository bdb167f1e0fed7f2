"""Submission and recomputation of studies. A study is entered once, however often it is submitted."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, select

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.store.catalogue.batches import Batches
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import ALIVE, newest_row, pieces, record_of, study_row
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.cube.definition import parse_stored, with_attachments
from damperlab.studies.store.faults import CatalogueDamaged, NothingToDo, QuotaReached, reporting_damage
from damperlab.studies.store.life_cycle.entering import Entering, Submission
from damperlab.studies.store.provenance import SUBMITTED_BY, signed, submitter
from damperlab.studies.store.record import Record

_MOST = 256  # largest number of studies in one transaction, so that other writers do not wait long


Entered = list[tuple[Record, bool]]


class Submissions(Entering):
    """The part of a store that submits and recomputes studies."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._batches = Batches[Sequence[Submission], Entered](self._submit_lists, _MOST, len)

    def submit(
        self,
        study: AnyStudy,
        plan: Plan,
        provenance: dict[str, str],
        *,
        reuse: bool = True,
        priority: int = 0,
    ) -> tuple[Record, bool]:
        """Enter a new study, or return the record of an existing study.

        The plan divides the grid of the study into blocks. The other parameters are those of `Submission`.

        Returns
        -------
        record : Record
            Record of the new or existing study.
        created : bool
            Whether this call has created the study.

        Raises
        ------
        StoreFault
            If the cube cannot be written.
        QuotaReached
            If the study would exceed the remaining quota.
        """
        # look for the study without the write lock first, because a study is often submitted again
        with self.catalogue.reading() as connection:
            row = newest_row(connection, study.digest)
        if row is not None:
            return record_of(row), False
        return self.submit_all([Submission(study, plan.chunk, provenance, reuse, priority)])[0]

    def submit_all(self, submissions: Sequence[Submission]) -> Entered:
        """Submit several studies as `submit` does. Either all of the studies are entered, or none."""
        # add the owner here: only this thread knows it, and another thread may enter the studies
        return self._batches.ask([replace(one, provenance=signed(one.provenance)) for one in submissions])

    def _submit_lists(self, lists: Sequence[Sequence[Submission]]) -> list[Entered | Exception]:
        """Enter the submissions of several threads. If one list is refused, the other lists are still entered."""

        def decide(connection: Connection) -> tuple[list[Submission], Callable[[list[Record]], list[Any]]]:
            known, damaged = _known(connection, (one for some in lists for one in some))
            ledger = Ledger(connection, self.quota)
            entries: dict[str, Submission] = {}
            refused: dict[int, Exception] = {}
            for place, some in enumerate(lists):
                fresh = {
                    one.study.digest: one
                    for one in reversed(some)
                    if one.study.digest not in known and one.study.digest not in entries
                }
                try:
                    for one in some:
                        if one.study.digest in damaged:
                            raise damaged[one.study.digest]
                    ledger.enter(
                        some[0].provenance.get(SUBMITTED_BY) if some else None,
                        sum(entry.study.points for entry in fresh.values()),
                        sum(entry.bytes for entry in fresh.values()),
                        len(fresh),
                    )
                except (QuotaReached, CatalogueDamaged) as error:
                    refused[place] = error
                else:
                    entries |= {digest: fresh[digest] for digest in reversed(fresh)}

            def answer(entered: list[Record]) -> list[Entered | Exception]:
                records = known | dict(zip(entries, entered, strict=True))
                untold = set(entries)

                def told(one: Submission) -> tuple[Record, bool]:
                    digest = one.study.digest
                    created = digest in untold
                    untold.discard(
                        digest
                    )  # only the first of several submissions of a study reports it as created
                    return records[digest], created

                return [refused.get(place) or list(map(told, some)) for place, some in enumerate(lists)]

            return list(entries.values()), answer

        return self.enter(decide, "submitted")

    def recompute(self, study_id: str, provenance: dict[str, str]) -> tuple[Record, bool]:
        """Enter a new version of a study, which today's solver will compute. The older versions are kept.

        Returns
        -------
        record : Record
            Record of the new version. If the newest existing version is not outdated, its record is returned instead.
        created : bool
            Whether a new version was entered.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        NothingToDo
            If today's solver has computed the complete study, or if the study has no results yet.
        StoreFault, QuotaReached
            If the new version cannot be stored, or exceeds a quota (see `submit`).
        """
        with self.catalogue.reading() as connection:
            known = study_row(connection, study_id)
        shelf = self.cube_shelf(study_id, known.number)
        stored = parse_stored(record_of(known).definition, known.digest)
        with reporting_damage(shelf, None, "a ground-motion record"):
            study = with_attachments(stored, shelf)

        def decide(
            connection: Connection,
        ) -> tuple[list[Submission], Callable[[list[Record]], tuple[Record, bool]]]:
            older = record_of(study_row(connection, study_id))
            if not older.blocks_done or (older.state == "done" and not older.outdated):
                raise _nothing_to_recompute(older)
            row = newest_row(connection, older.digest)
            newest = record_of(row) if row is not None else older
            if newest.id != older.id and not newest.outdated:
                return [], lambda entered: (newest, False)
            entry = Submission(
                study,
                older.chunk,
                signed(provenance),
                older.reuse,
                priority=older.priority,
                version=newest.version + 1,
            )
            Ledger(connection, self.quota).enter(submitter.get(), study.points, entry.bytes, 1)
            return [entry], lambda entered: (entered[0], True)

        return self.enter(decide, "entered to be computed again")


def _known(
    connection: Connection, submissions: Iterable[Submission]
) -> tuple[dict[str, Record], dict[str, CatalogueDamaged]]:
    """Return the newest existing version of every submitted study, by digest, and the errors for damaged rows."""
    known: dict[str, Record] = {}
    damaged: dict[str, CatalogueDamaged] = {}
    for digests in pieces(dict.fromkeys(one.study.digest for one in submissions)):
        query = select(studies).where(studies.c.digest.in_(digests), ALIVE).order_by(studies.c.version)
        for row in connection.execute(query):
            try:
                known[row.digest] = record_of(row)
            except CatalogueDamaged as error:
                damaged[row.digest] = error
    return known, damaged


def _nothing_to_recompute(record: Record) -> NothingToDo:
    if not record.blocks_done:
        found, advice = f"{record.id}, which has no results yet", f"run `damperlab run {record.id}`"
        told = f"Study {record.id} has no results yet, so there is nothing to compute again."
    else:
        found = f"{record.id}, whose results today's solver computed: it would give the same bits"
        told = (
            f"The results of study {record.id} were computed by today's solver, which would give the same "
            "bits again."
        )
        advice = "there is nothing to do; `damperlab store verify` checks that the results are intact"
    allowed = "a study whose results another solver computed"
    return NothingToDo("study", found, allowed, advice, told)
