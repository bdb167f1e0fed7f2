"""What users do to stored studies while processes are killed: recompute an outdated one, retry failed blocks, delete."""

import json
from collections.abc import Callable
from pathlib import Path

from tests.faults.asking import ask
from tests.faults.report import Report
from tests.other_solver import OtherSolver

from damperlab.studies.definition import Study
from damperlab.studies.plan import Plan, plan_with_chunk
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.cube.block_file import write_region
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance
from damperlab.worker.worker_process.tasks import failed_values

ROWS = 24
"""Size of these studies, in rows of 160 points."""


class Deeds:
    """Three studies that are there from the start, and what is asked of each until the service has answered it."""

    def __init__(
        self, folder: Path, store: Store, study_of: Callable[[int, int], Study], **environment: str
    ) -> None:
        self._store = store
        self._outdated, self._failed, self._unwanted = (study_of(900 + place, ROWS) for place in range(3))
        copy = folder / "other-solver"
        copy.mkdir()
        file = copy / "study.json"
        file.write_text(json.dumps(self._outdated.document()))
        other = OtherSolver(copy, **environment)
        # with its kernels as they are: the same bits, and all the same another identity
        self._older = str(other.run("run", str(file), "--data-dir", str(store.data_dir))["id"])
        self._bits = self._cube_bits(self._older)
        self._retried = self._give_up(self._failed, 2)
        self._deleted = self._give_up(self._unwanted, None)
        self._pending = [self._recompute, self._retry, self._delete]
        self.studies: dict[str, Study] = {}
        """What shall be done and right in the end, by id."""

    @property
    def pending(self) -> bool:
        """Whether something has not been answered yet."""
        return bool(self._pending)

    def step(self, port: int) -> None:
        """Ask once for each thing that was not answered."""
        base = f"http://127.0.0.1:{port}/api/v1/studies"
        self._pending = [deed for deed in self._pending if not deed(base)]

    def check(self, report: Report) -> None:
        """Compare with what was told: the older version as it was, the deleted study gone."""
        report.deeds_undone += len(self._pending)
        record = self._store.find(self._older)
        kept = (record.state, record.outdated, self._cube_bits(self._older)) == ("done", True, self._bits)
        report.deeds_undone += not kept
        report.damaged_blocks += sum(1 for _ in verify(self._store, record))
        try:
            self._store.find(self._deleted)
        except StudyNotFound:
            return
        report.deeds_undone += 1

    def _recompute(self, base: str) -> bool:
        status, record = ask("POST", f"{base}/{self._older}/recompute")
        if status in (200, 201):
            self.studies[record["id"]] = self._outdated
        return status in (200, 201)

    def _retry(self, base: str) -> bool:
        status, record = ask("GET", f"{base}/{self._retried}")
        if status != 200 or record["state"] != "done":
            return False
        status, _ = ask("POST", f"{base}/{self._retried}/retry")
        # an answer that was lost: what is asked again finds nothing to do
        if status in (200, 409):
            self.studies[self._retried] = self._failed
        return status in (200, 409)

    def _delete(self, base: str) -> bool:
        status, _ = ask("DELETE", f"{base}/{self._deleted}")
        return status in (204, 404)

    def _give_up(self, study: Study, blocks: int | None) -> str:
        """Enter a study of which some blocks, or all, are recorded as failed."""
        plan = _plan(study)
        record, _ = self._store.submit(study, plan, provenance())
        path = self._store.cube_path(record.id)
        for index in range(plan.count if blocks is None else blocks):
            block = plan.block(index)
            told = {"message": "its worker died"}
            failed = write_region(path, block, failed_values(study, block), "given-up", told)
            self._store.mark(record.id, failed)
        return record.id

    def _cube_bits(self, study_id: str) -> dict[str, bytes]:
        return {str(name): values.values.tobytes() for name, values in self._store.cube(study_id).items()}


def _plan(study: Study) -> Plan:
    chunk = (*study.shape[:-2], 2, study.shape[-1])
    return plan_with_chunk(study, chunk, seconds_per_point)
