"""One study of a service: followed, steered, and asked."""

import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.client.faults import ClientFault, Conflict, StillRunning, Stopped, refused
from damperlab.service.client.results import Refinement, read_record
from damperlab.service.client.transport import Transport
from damperlab.studies.answers.shown import shown_axes
from damperlab.studies.faults import Fault, describe
from damperlab.studies.html import card
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import (
    EXPORT_SUFFIXES,
    Criterion,
    Excitation,
    ExportFormat,
    Objective,
    Reduction,
)

if TYPE_CHECKING:
    import xarray as xr

    from damperlab.service.client.answers import (
        Designs,
        FrequencyResponse,
        ResonanceMap,
        TmdComparison,
        WorkPrecision,
    )

Range = tuple[float, float]
PIECE_BYTES = 1 << 20
DRAIN_SECONDS = 60.0
"""How long a cancelled study may take to let go of its blocks."""


class Study:
    """A study that the service keeps.

    Made by `Client.submit`, `Client.study` and `Client.studies`. Every question is answered on a running study,
    too, with what is there; the answer's attribute ``complete`` says how much of it that is.

    Parameters
    ----------
    transport : Transport
        The way to the service.
    document : mapping
        Its record, or the part of it that is at hand.

    Attributes
    ----------
    id, name : str
        The first twelve digits of the digest; free text.
    """

    def __init__(self, transport: Transport, document: Mapping[str, Any]) -> None:
        self._transport = transport
        self.id = str(document["id"])
        self.name = str(document["name"])
        self._sizes = dict(zip(document["dimensions"], document["shape"], strict=True))

    def __repr__(self) -> str:
        """Say which study it is."""
        return f"<Study {self.id} {self.name!r}>"

    def _repr_html_(self) -> str:
        """Show a notebook the study as it is now; without an answer of the service, its name."""
        try:
            return self.record._repr_html_()
        except ClientFault:
            return card(f"Study {self.name}", [("id", self.id)])

    def __eq__(self, other: object) -> bool:
        """Equal ids of one service are one study."""
        return isinstance(other, Study) and (self.id, self._transport.url) == (
            other.id,
            other._transport.url,
        )

    def __hash__(self) -> int:
        """Hash as equality asks."""
        return hash((self.id, self._transport.url))

    @property
    def record(self) -> Record:
        """What the service knows about the study now: states, counts, times, the definition, versions."""
        return read_record(self._ask("GET"))

    @property
    def state(self) -> str:
        """``queued``, ``running``, ``done``, ``cancelled`` or ``failed``, as it is now."""
        return self.record.state

    def wait(self, progress: bool = True, timeout: float | None = None) -> "Study":
        """Wait until the study is done.

        Lost connections and restarts of the service are waited out.

        Parameters
        ----------
        progress : bool
            Show a bar in a terminal or a notebook, a line now and then elsewhere.
        timeout : float, optional
            Give up after this many seconds; the study itself goes on.

        Returns
        -------
        Study
            This one.

        Raises
        ------
        Stopped
            If it has failed or was cancelled; what is computed can be asked for all the same.
        StillRunning
            If it has not ended in time.
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

    def cancel(self) -> "Study":
        """Stop the study; what is done is kept, and `resume` goes on there."""
        self._ask("POST", "/cancel")
        return self

    def resume(self) -> "Study":
        """Go on with a study that was cancelled or has failed."""
        self._ask("POST", "/resume")
        return self

    def retry(self) -> "Study":
        """Compute blocks again that failed as a whole; points that failed by their numbers stay as they are."""
        self._ask("POST", "/retry")
        return self

    def recompute(self) -> "Study":
        """Compute an outdated study with the service's solver, beside these results, and give the new version.

        Both are kept until one is deleted; `differences` compares them.
        """
        return Study(self._transport, self._ask("POST", "/recompute"))

    def differences(self, older: "Study | str | None" = None) -> dict[str, Any]:
        """How this version differs from an older one: points, and of each variable the largest difference and where.

        Parameters
        ----------
        older : Study or str, optional
            The other version; by default the one before.

        Returns
        -------
        dict
            ``compared``, ``differing`` and ``variables``, each with ``points``, ``largest_relative``, ``at``, ``older``
            and ``newer``.
        """
        query = {} if older is None else {"older": older.id if isinstance(older, Study) else older}
        answer: dict[str, Any] = self._ask("GET", "/differences", params=query)
        return answer

    @property
    def outdated(self) -> bool:
        """Whether another solver than the service's computed the results; `recompute` makes a new version beside."""
        return self.record.outdated

    def delete(self) -> None:
        """Delete the study and its cube; one that runs has to be cancelled first."""
        give_up = time.monotonic() + DRAIN_SECONDS
        while True:
            try:
                self._ask("DELETE")
                return
            except Conflict:
                # the blocks that were under way when it was cancelled come to their end
                if time.monotonic() > give_up or self.state in ("queued", "running"):
                    raise
            time.sleep(0.2)

    def cube(self, chunks: Any = "blocks") -> "xr.Dataset":
        """Open the whole cube lazily: values are fetched when they are computed with.

        Of a study that has not ended it shows what is done now, and stays so; open it again for more.

        Parameters
        ----------
        chunks : mapping, int or None
            As for `xarray.open_zarr`; by default the blocks of the study as chunks of Dask, with None no Dask.

        Returns
        -------
        Dataset
            All dimensions and every stored variable; points that are not computed have status −1. A study in SI units
            has coordinates in them beside the ratios (``clearance_m``, ``friction_force_n``, …), and where the cube is
            lazy the results too (``amplitude_m``, ``impact_speed_max_m_per_s``).
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

    def resonance_map(
        self,
        x: str | None = None,
        y: str | None = None,
        metric: str | None = None,
        over: str | None = None,
        reduce: Reduction | None = None,
        interpolate: bool = False,
        **at: float | str,
    ) -> "ResonanceMap":
        """Show one metric over two dimensions.

        Parameters
        ----------
        x, y : str, optional
            The dimensions; those along which the study varies, clearance and friction first, if not given.
        metric : str, optional
            A variable that the study keeps; the amplitude ratio if not given, of a survey the peak displacement.
        over, reduce : str, optional
            A third dimension, and how it is reduced. Without a word on the frequency, in a survey on the record, the
            largest value over all of them is shown.
        interpolate : bool
            Take values between grid points.
        **at : float or str
            Other dimensions by name, as in ``mass_ratio=0.1`` or ``record="el-centro"``; the nearest grid point is taken.

        Returns
        -------
        ResonanceMap
            See `damperlab.studies.answers.resonance_map`.
        """
        from damperlab.service.client.answers import read_map

        x, y = shown_axes(self._sizes, x, y, {*at, over})
        asked = {"x": x, "y": y, "metric": metric, "over": over, "reduce": reduce, "interpolate": interpolate}
        return read_map(self._question("resonance-map", asked, at))

    def frequency_response(
        self,
        metric: str = "amplitude_ratio",
        interpolate: bool = False,
        with_: "Study | str | None" = None,
        **at: float,
    ) -> "FrequencyResponse":
        """Follow one design along the frequency ratio.

        Parameters
        ----------
        metric : str
            A variable that the study keeps.
        interpolate : bool
            Take values between grid points.
        with_ : Study, optional
            A second study on the same frequencies, as the way down of a hysteresis: ``other`` holds its values, ``differs``
            and the attribute ``apart`` where the two are different responses.
        **at : float
            The design by its dimensions, as in ``clearance_ratio=10``; the nearest grid point is taken.

        Returns
        -------
        FrequencyResponse
            See `damperlab.studies.answers.frequency_response` and `damperlab.studies.answers.compared_response`.
        """
        from damperlab.service.client.answers import read_response

        other = None if with_ is None else _ids([with_])
        asked = {"metric": metric, "interpolate": interpolate, "with": other}
        return read_response(self._question("frequency-response", asked, at))

    def optimal_designs(
        self,
        objective: Objective | None = None,
        band: Range | None = None,
        top: int | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        pareto: Sequence[str] | None = None,
        with_: "Iterable[Study | str]" = (),
        metric: str | None = None,
        records: Sequence[str] | None = None,
        **ranges: Range,
    ) -> "Designs":
        """Rank designs over the frequencies of the study, the best first; a survey's dampers by their worst case.

        Parameters
        ----------
        objective : {"peak", "resonance", "band_mean", "band_rms"}, optional
            What a design is judged by; peak, or resonance where one frequency was computed and no band is given.
        band : (float, float), optional
            Lowest and highest frequency ratio that count.
        top : int, optional
            How many; ten, of a front all.
        exclude_locked : bool
            Exclude designs in which friction locks the mass to its base.
        max_impact_speed : float, optional
            Leave out designs that impact faster, over Z·ω_n.
        pareto : sequence of str, optional
            Two or three of amplitude, mass, clearance, impact_speed and dissipation_viscous, …_friction, …_impact:
            the designs that no other one beats in all of them. A minus in front means larger is better.
        with_ : iterable of Study, optional
            Follow-ups to rank together with this study.
        metric : str, optional
            Of a survey: what its dampers are ranked by; the peak displacement against the base if not given.
        records : sequence of str, optional
            Of a survey: the records that count; all if not given.
        **ranges : (float, float)
            Lowest and highest value of design dimensions, as in ``friction_ratio=(0, 0.4)``.

        Returns
        -------
        Designs
            See `optimal_designs`, `pareto`, `merged` and `survey` of `damperlab.studies.answers`.
        """
        from damperlab.service.client.answers import read_designs

        most = {"top": top} if top is not None else {"top": 10_000} if pareto is not None else {}
        asked = {
            "objective": objective,
            "band": band,
            # what is left as it is goes unsaid: a survey has no such thing
            "exclude_locked": exclude_locked or None,
            "max_impact_speed": max_impact_speed,
            "pareto": None if pareto is None else list(pareto),
            "with": _ids(with_),
            "metric": metric,
            "record": None if records is None else list(records),
            **most,
        }
        return read_designs(self._question("optimal-designs", asked, ranges))

    def robust_designs(
        self,
        amplitudes: Range,
        objective: Objective | None = None,
        band: Range | None = None,
        top: int = 10,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        **ranges: Range,
    ) -> "Designs":
        """Rank dampers by their worst case while the base amplitude varies.

        Parameters
        ----------
        amplitudes : (float, float)
            Lowest and highest base amplitude, over the nominal one.
        objective, band, top, exclude_locked, max_impact_speed, **ranges
            As in `optimal_designs`.

        Returns
        -------
        Designs
            See `damperlab.studies.answers.robust`.
        """
        from damperlab.service.client.answers import read_designs

        asked = {
            "amplitudes": amplitudes,
            "objective": objective,
            "band": band,
            "top": top,
            "exclude_locked": exclude_locked,
            "max_impact_speed": max_impact_speed,
        }
        return read_designs(self._question("robust-designs", asked, ranges))

    def tmd_comparison(
        self,
        criterion: Criterion = "minimax",
        mass_ratio: float | None = None,
        detuning: float = 0.0,
        damping_detuning: float = 0.0,
        excitation: Excitation = "base",
        **at: float,
    ) -> "TmdComparison":
        """Compare one design with a tuned mass damper.

        Parameters
        ----------
        criterion : str
            How the tuned mass damper is tuned.
        mass_ratio : float, optional
            Its μ; that of the design if not given.
        detuning, damping_detuning : float
            Shares by which its frequency and its damping are off: 0.05 is five per cent too high.
        excitation : {"base", "force"}
            What the tuned mass damper answers to: the shaken base, or a force on the structure, X then over its static
            deflection. The hybrid is always shaken through its base.
        **at : float
            The design by its dimensions; the nearest grid point is taken.

        Returns
        -------
        TmdComparison
            See `damperlab.studies.answers.tmd_comparison`; the peaks and their ratio are attributes.
        """
        from damperlab.service.client.answers import read_tmd

        asked = {
            "criterion": criterion,
            "mass_ratio": mass_ratio,
            "detuning": detuning,
            "damping_detuning": damping_detuning,
            "excitation": excitation,
        }
        return read_tmd(self._question("tmd-comparison", asked, at))

    def work_precision(self) -> "WorkPrecision":
        """Sort the points by run time, and say how exact those of each time are.

        Returns
        -------
        WorkPrecision
            See `damperlab.studies.answers.work_precision`.
        """
        from damperlab.service.client.answers import read_precision

        return read_precision(self._question("work-precision", {}, {}))

    def refine(
        self,
        tolerance: float = 1e-3,
        objective: Objective | None = None,
        band: Range | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        with_: "Iterable[Study | str]" = (),
        dry_run: bool = False,
        value_tolerance: float = 0.01,
        budget: int = 20_000,
        **ranges: Range,
    ) -> Refinement:
        """Submit follow-up studies where a better design may lie, unless the best is known well enough.

        Parameters
        ----------
        tolerance : float
            Step to which every parameter shall be known.
        value_tolerance : float
            Share of the value by which a better design must be better to be looked for.
        budget : int
            Points that all follow-ups together may take.
        with_ : iterable of Study
            The follow-ups that are done.
        dry_run : bool
            Say what is known and what would be computed, and submit nothing.
        objective, band, exclude_locked, max_impact_speed, **ranges
            As in `optimal_designs`.

        Returns
        -------
        Refinement
            With the follow-up to wait for, then to give as ``with_``.
        """
        asked = {
            "tolerance": tolerance,
            "objective": objective,
            "band": band,
            "exclude_locked": exclude_locked,
            "max_impact_speed": max_impact_speed,
            "with": _ids(with_),
            "dry_run": dry_run,
            "value_tolerance": value_tolerance,
            "budget": budget,
        }
        return self._refinement("/refine", asked, ranges)

    def race(
        self,
        confidence: float = 0.95,
        indifference: float = 0.02,
        budget: float = 5e7,
        objective: Objective | None = None,
        band: Range | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        with_: "Iterable[Study | str]" = (),
        dry_run: bool = False,
        **ranges: Range,
    ) -> Refinement:
        """Submit follow-up studies that compute longer what may be the best, unless the best is known.

        Parameters
        ----------
        confidence : float
            Confidence with which the best design is to be known.
        indifference : float
            Relative difference below which two designs count as equally good.
        budget : float
            Largest total number of excitation cycles of all rounds.
        with_ : iterable of Study
            The follow-ups that are done.
        dry_run : bool
            Say what is known and what would be computed, and submit nothing.
        objective, band, exclude_locked, max_impact_speed, **ranges
            As in `optimal_designs`.

        Returns
        -------
        Refinement
            With the follow-ups of the next round to wait for, then to give as ``with_`` with those before.
        """
        asked = {
            "confidence": confidence,
            "indifference": indifference,
            "budget": budget,
            "objective": objective,
            "band": band,
            "exclude_locked": exclude_locked,
            "max_impact_speed": max_impact_speed,
            "with": _ids(with_),
            "dry_run": dry_run,
        }
        return self._refinement("/race", asked, ranges)

    def refine_boundary(
        self,
        along: str,
        tolerance: float = 1e-3,
        with_: "Iterable[Study | str]" = (),
        dry_run: bool = False,
        **at: float,
    ) -> Refinement:
        """Submit a follow-up study around a change of the response's class, unless that is known well enough.

        Parameters
        ----------
        along : str
            The dimension that is searched.
        tolerance, with_, dry_run
            As in `refine`.
        **at : float
            The other dimensions by name.
        """
        asked = {"along": along, "tolerance": tolerance, "with": _ids(with_), "dry_run": dry_run}
        return self._refinement("/refine-boundary", asked, at)

    def export(self, path: str | Path, format: ExportFormat | None = None) -> Path:
        """Download the whole cube into a file.

        Parameters
        ----------
        path : path
            The file to write; it appears when it is complete.
        format : {"netcdf", "csv", "parquet"}, optional
            What the suffix of `path` says, ``.nc``, ``.csv`` or ``.parquet``, if not given.

        Returns
        -------
        Path
            The file.
        """
        path = Path(path)
        chosen = format or EXPORT_SUFFIXES.get(path.suffix.lower())
        if chosen is None:
            fault = Fault(
                "path", describe(path.name), f"a name with {', '.join(EXPORT_SUFFIXES)}", "name the format"
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

    def _ask(self, method: str, path: str = "", **how: Any) -> Any:
        return self._transport.ask(method, f"/studies/{self.id}{path}", **how)

    def _question(self, what: str, asked: Mapping[str, Any], named: Mapping[str, Any]) -> Mapping[str, Any]:
        answer: Mapping[str, Any] = self._ask("GET", f"/{what}", params={**named, **asked})
        return answer

    def _refinement(self, path: str, asked: Mapping[str, Any], named: Mapping[str, Any]) -> Refinement:
        answer = self._ask("POST", path, params={**named, **asked})
        names = ("known", "found", "steps", "points", "fine_points", "note")
        studies = tuple(Study(self._transport, each) for each in answer.get("follow_ups", ()))
        more = {
            "spent": answer["spent"],
            "as_good": answer.get("as_good"),
            "chance_of_another": answer.get("chance_of_another"),
            "follow_ups": studies,
            "follow_up": studies[0] if studies else None,
        }
        return Refinement(**{name: answer[name] for name in names}, **more)


def _ids(studies: "Iterable[Study | str]") -> str | None:
    studies = [studies] if isinstance(studies, Study | str) else studies
    return ",".join(each.id if isinstance(each, Study) else each for each in studies) or None
