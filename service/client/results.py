"""Results of the client that are not Datasets: an estimate, a refinement, a simulation, an accuracy report."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.client.figure import finished
from damperlab.studies.html import card
from damperlab.studies.kinds import dimensions_of_definition
from damperlab.studies.store.provenance import SUBMITTED_BY
from damperlab.studies.store.record import Record

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.service.client.study import Study


@dataclass(frozen=True)
class Estimate:
    """Cost of a study.

    Parameters
    ----------
    digest : str
        Digest of the study; its first twelve digits become the id of the study.
    points, blocks, bytes : int
        Number of points, number of blocks, and size of the cube before compression.
    seconds : float
        Expected time on one core [s], including the time to compile missing kernels.
    definition : dict
        The study with all defaults filled in.
    compiling_seconds : float
        Part of `seconds` for the compilation [s].
    seconds_low, seconds_high : float, optional
        Likely range of `seconds` [s].
    understood : tuple of str
        Assumptions, derived ratios, and unusual values, in sentences.
    """

    digest: str
    points: int
    blocks: int
    bytes: int
    seconds: float
    definition: dict[str, Any]
    compiling_seconds: float = 0.0
    seconds_low: float | None = None
    seconds_high: float | None = None
    understood: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refinement:
    """State of a search for an optimum or a class boundary, and the follow-up studies that continue the search.

    Parameters
    ----------
    known : bool
        Whether the optimum or the boundary is known within the tolerance.
    found : dict
        The present optimum (coordinates, `value`, `error`) or boundary (`low`, `high`, the classes at both).
    steps : dict of float
        For each parameter, the distance from the optimum to the farther of its two neighbouring values.
    points, fine_points : int
        Number of points of the follow-up studies, and number of points of a single grid with the same answer.
        `fine_points` is 0 if no such grid is known.
    note : str
        The result in sentences.
    follow_up : Study, optional
        The first submitted study; None if nothing is left to compute, or for a dry run.
    follow_ups : tuple of Study
        All submitted studies.
    spent : dict
        Cost so far: `points`, `cycles`, `seconds` of run time.
    """

    known: bool
    found: dict[str, Any]
    steps: dict[str, float]
    points: int
    fine_points: int
    note: str
    follow_up: "Study | None"
    follow_ups: "tuple[Study, ...]" = ()
    spent: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Simulation:
    """Results of the simulation of one design point.

    Parameters
    ----------
    metrics : dict of float
        Results by the name of the variable; None for a variable without a value in this response.
    status, response_class : str
        Outcome of the computation and class of the response, in words.
    state : dict of float
        Final state: absolute displacements of mass and particle, ``u`` and ``p`` [Z], and their velocities, ``u_rate``
        and ``p_rate`` [Z·ω_n].
    events : dict of int
        Number of impacts, velocity reversals and attachments.
    cycles : int
        Computed excitation cycles.
    history : Dataset
        Displacements and velocities along ``time`` [1/ω_n], with units; empty if no time history was requested.
    ratios : dict of float
        Ratios that define the design point.
    attractors : dict, optional
        The responses reached from many starts (``met``, each with its ``share`` and ``metrics``).
        ``decided_by_a_rounding`` says whether a change in the last digits of the start leads to another response.
        ``note`` describes the responses in words. None if no starts were requested.
    """

    metrics: dict[str, Any]
    status: str
    response_class: str
    state: dict[str, float | None]
    events: dict[str, int]
    cycles: int
    history: "xr.Dataset"
    ratios: dict[str, float]
    attractors: dict[str, Any] | None = None

    def _repr_html_(self) -> str:
        """Show the response, its results and its events in a notebook."""
        ratios = ", ".join(f"{name} = {value:g}" for name, value in self.ratios.items())
        measures = {name: value for name, value in self.metrics.items() if isinstance(value, float)}
        rows = [("response", self.response_class), ("status", self.status)]
        rows += [(name, f"{value:.6g}") for name, value in measures.items()]
        return card(f"Simulation at {ratios}", [*rows, *self.events.items()])

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw the time history. If `path` is given (.png, .svg or .pdf), write the figure to this file."""
        from damperlab.service.figures.curves import draw_history

        columns = {str(name): array.values for name, array in self.history.variables.items()}
        return finished(draw_history(columns, self.ratios), path)


@dataclass(frozen=True)
class Accuracy:
    """The service's last report of `damperlab check accuracy`.

    Parameters
    ----------
    created, version : str
        Time of the report, and version of the program.
    passed : bool
        Whether every extreme case passed.
    stability : list of dict
        Results of the extreme cases, one entry per case.
    document : dict
        The complete report.
    """

    created: str
    version: str
    passed: bool
    stability: list[dict[str, Any]]
    document: dict[str, Any]

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw error against run time. If `path` is given (.png, .svg or .pdf), write the figure to this file."""
        from damperlab.service.figures.accuracy import draw_work_precision

        return finished(draw_work_precision(self.document["diagrams"]), path)


def read_record(document: Mapping[str, Any]) -> Record:
    """Read a study's record; unknown fields of a newer service are ignored."""
    # defaults of fields that an older service does not send
    before = {
        "phase": document["state"],
        "phase_done": None,
        "phase_total": None,
        "version": 1,
        "outdated": False,
        "priority": 0,
        "tags": (),
        "note": "",
        "dimensions": dimensions_of_definition(document["definition"]),
        "submitted_by": document["provenance"].get(SUBMITTED_BY),
    }
    document = {**before, **document}
    values = {field.name: document[field.name] for field in fields(Record)}
    for name in ("created", "started", "finished"):
        values[name] = None if values[name] is None else datetime.fromisoformat(values[name])
    return Record(**values | {name: tuple(values[name]) for name in ("chunk", "shape", "tags", "dimensions")})
