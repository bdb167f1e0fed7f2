"""One study of a service: its progress, and methods to control the study."""

import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.client.faults import ClientFault, Conflict, StillRunning, Stopped, refused
from damperlab.service.client.questions import Questions
from damperlab.service.client.results import read_record
from damperlab.service.client.searches import Searches
from damperlab.service.client.transport import Transport
from damperlab.studies.faults import Fault, describe, listing
from damperlab.studies.html import card
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import EXPORT_SUFFIXES, ExportFormat

if TYPE_CHECKING:
    import xarray as xr

PIECE_BYTES = 1 << 20
DRAIN_SECONDS = 60.0
"""Longest wait for the blocks of a cancelled study that are still being computed [s]."""


class Study(Questions, Searches):
    """A study stored by the service, as returned by `Client.submit`, `Client.study` and `Client.studies`.

    While the study runs, the methods use the results computed so far; the attribute ``complete`` of a returned Dataset
    is the computed share of the points.

    Parameters
    ----------
    transport : Transport
        The connection to the service.
    document : mapping
        The service's record of the study; some keys may be missing.

    Attributes
    ----------
    id, name : str
        First twelve digits of the study's digest, and name of the study.
    """

    def __init__(self, transport: Transport, document: Mapping[str, Any]) -> None:
        sizes = dict(zip(document["dimensions"], document["shape"], strict=True))
        super().__init__(transport, str(document["id"]), sizes)
        self.name = str(document["name"])

    def _handle(self, document: Mapping[str, Any]) -> "Study":
        return Study(self._transport, document)

    def __repr__(self) -> str:
        """Name the study."""
        return f"<Study {self.id} {self.name!r}>"

    def _repr_html_(self) -> str:
        """Show the record of the study in a notebook, or only its name and id if the service does not answer."""
        try:
            return self.record._repr_html_()
        except ClientFault:
            return card(f"Study {self.name}", [("id", self.id)])

    def __eq__(self, other: object) -> bool:
        """Studies are equal if they have the same id at the same service."""
        return isinstance(other, Study) and (self.id, self._transport.url) == (
            other.id,
            other._transport.url,
        )

    def __hash__(self) -> int:
        """Return a hash that is consistent with equality."""
        return hash((self.id, self._transport.url))

    @property
    def record(self) -> Record:
        """The service's present record of the study: state, counts, times, definition and versions."""
        return read_record(self._ask("GET"))

    @property
    def state(self) -> str:
        """The present state: ``queued``, ``running``, ``done``, ``cancelled`` or ``failed``."""
        return self.record.state

    def wait(self, progress: bool = True, timeout: float | None = None) -> "Study":
        """Wait until the study is done.

        Lost connections and restarts of the service do not end the wait.

        Parameters
        ----------
        progress : bool
            Show the progress: as a bar in a terminal or a notebook, elsewhere as lines from time to time.
        timeout : float, optional
            Stop waiting after this many seconds; the study itself continues.

        Returns
        -------
        Study
            The study itself.

        Raises
        ------
        Stopped
            If the study has failed or was cancelled; the computed results can still be read.
        StillRunning
            If the study has not ended in time.
        """
        from contextlib import ExitStack

        from damperlab.service.client.waiting import follow, preparation, shown

        began = time.monotonic()
        first: int | None = None
        with ExitStack() as stack:
            bar = None
            for now in follow(self._transport, self.id, None if timeout is None else began + timeout):
                if progress and bar is None:
                    bar = stack.enter_context(shown(self.name or self.id, now["points_total"]))
                done = int(now["points_done"])
                first = done if first is None else first
                seconds = time.monotonic() - began
                rate = (done - first) / seconds if done > first else None
                if bar is not None:
                    before = preparation(now)
                    bar.update(done, int(now["points_failed"]), rate, now["seconds_left"], before)
                state = now["state"]
        if state not in ("done", "cancelled", "failed"):
            message = f"{self} is {state} after {timeout:g} s, {done} of {now['points_total']} points done."
            raise StillRunning(message)
        if state != "done":
            why = f" {now['message']}" if now.get("message") else ""
            raise Stopped(f"{self} is {state}.{why} study.resume() computes what is missing.")
        return self

    def remark(
        self, tags: "Iterable[str] | None" = None, note: str | None = None, name: str | None = None
    ) -> "Study":
        """Change the tags, the note or the name of the study. The value None leaves an entry unchanged.

        Parameters
        ----------
        tags : iterable of str, optional
            New tags of the study, each of up to 40 lower-case letters, digits and hyphens.
        note : str, optional
            New note of the study.
        name : str, optional
            New name of the study; the definition is unchanged.

        Raises
        ------
        Refused
            If a value is not allowed, or if all arguments are None.
        """
        said = {"tags": None if tags is None else list(tags), "note": note, "name": name}
        self._ask("PATCH", json={name: value for name, value in said.items() if value is not None})
        return self

    def undelete(self) -> "Study":
        """Restore the study from the trash."""
        self._ask("POST", "/undelete")
        return self

    def cancel(self) -> "Study":
        """Stop the study. Computed points are kept, and `resume` continues the study."""
        self._ask("POST", "/cancel")
        return self

    def resume(self) -> "Study":
        """Continue a study that was cancelled or has failed."""
        self._ask("POST", "/resume")
        return self

    def retry(self) -> "Study":
        """Recompute failed blocks. Points that failed numerically are not recomputed."""
        self._ask("POST", "/retry")
        return self

    def recompute(self) -> "Study":
        """Compute an outdated study again with the present solver, and return the new version; both are kept."""
        return Study(self._transport, self._ask("POST", "/recompute"))

    def differences(self, older: "Study | str | None" = None) -> dict[str, Any]:
        """Compare this version of the study with an older version, point by point.

        Parameters
        ----------
        older : Study or str, optional
            The older version; by default the previous version.

        Returns
        -------
        dict
            Numbers of points ``compared`` and ``differing``, and the list ``variables``. Each entry of the list has
            ``points``, ``largest_relative``, ``at``, ``older`` and ``newer``.
        """
        query = {} if older is None else {"older": older.id if isinstance(older, Study) else older}
        answer: dict[str, Any] = self._ask("GET", "/differences", params=query)
        return answer

    @property
    def outdated(self) -> bool:
        """Whether another version of the solver has computed the results; see `recompute`."""
        return self.record.outdated

    def delete(self, trash: bool = False) -> None:
        """Delete the study and its cube. A running study must be cancelled first.

        Parameters
        ----------
        trash : bool
            Whether `undelete` can restore the study for a week.
        """
        give_up = time.monotonic() + DRAIN_SECONDS
        while True:
            try:
                self._ask("DELETE", params={"trash": True} if trash else None)
                return
            except Conflict:
                # blocks that were running when the study was cancelled are still being completed
                if time.monotonic() > give_up or self.state in ("queued", "running"):
                    raise
            time.sleep(0.2)

    def cube(self, chunks: Any = "blocks") -> "xr.Dataset":
        """Open the complete cube lazily: values are fetched when they are used.

        If the study has not ended, the Dataset is a snapshot of the results computed so far. Open the cube
        again to read newer results.

        Parameters
        ----------
        chunks : mapping, int or None
            Chunks as for `xarray.open_zarr`. By default each block of the study is a Dask chunk; None opens the cube
            without Dask.

        Returns
        -------
        Dataset
            All dimensions and every stored variable; points that are not computed have status −1. A study in SI units
            also has coordinates in SI units (``clearance_m``, ``friction_force_n``, …). With Dask, results are also
            given in SI units (``amplitude_m``, ``impact_speed_max_m_per_s``, …).
        """
        import xarray as xr

        from damperlab.studies.units import with_units

        record = self.record
        address = f"{self._transport.url}/api/v1/studies/{self.id}/zarr"
        if not record.ended:
            address += f"/@{record.revision}"
        options = {"headers": self._transport.headers} if self._transport.headers else None
        cube: xr.Dataset = xr.open_zarr(
            address, chunks={} if chunks == "blocks" else chunks, storage_options=options
        )
        return with_units(cube, results=chunks is not None)

    def export(self, path: str | Path, format: ExportFormat | None = None) -> Path:
        """Download the complete cube into a file.

        Parameters
        ----------
        path : path
            File to write; the file appears only when the download is complete.
        format : {"netcdf", "csv", "parquet"}, optional
            File format; by default it follows from the suffix of `path`: ``.nc``, ``.csv`` or ``.parquet``.

        Returns
        -------
        Path
            The file.
        """
        path = Path(path)
        chosen = format or EXPORT_SUFFIXES.get(path.suffix.lower())
        if chosen is None:
            fault = Fault(
                "path",
                describe(path.name),
                f"a name that ends in one of {listing(EXPORT_SUFFIXES)}",
                "name the `format`, or give the file one of these suffixes",
            )
            raise refused((fault,))
        part = path.with_name(f"{path.name}.part")
        try:
            for attempt in self._transport.attempts():
                with (
                    attempt,
                    self._transport.stream(
                        f"/studies/{self.id}/export", params={"format": chosen}
                    ) as response,
                    part.open("wb") as file,
                ):
                    for piece in response.iter_bytes(PIECE_BYTES):
                        file.write(piece)
            return part.replace(path)
        finally:
            part.unlink(missing_ok=True)
