"""Python client of the service. Its methods return studies, designs, simulations and reports."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from damperlab.service.client.asked import explained
from damperlab.service.client.design import Design, ask_for
from damperlab.service.client.faults import refused
from damperlab.service.client.fit import question
from damperlab.service.client.results import Accuracy, Estimate, Simulation
from damperlab.service.client.study import Study
from damperlab.service.client.transport import Transport, body
from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.field import given
from damperlab.studies.html import card
from damperlab.studies.questions import Compared, Simulated
from damperlab.studies.text import MOST_STUDIES, load_text
from damperlab.studies.vocabulary import DESIGN_POINT, AccelerationUnits, Criterion, Excitation, Method, State

if TYPE_CHECKING:
    from damperlab.service.client.answers import DamperComparison
    from damperlab.service.client.design import Specification
    from damperlab.service.client.earthquake import GroundRecord
    from damperlab.service.client.fit import Ranges
    from damperlab.studies.kind import AnyStudy

    Definition = Mapping[str, Any] | AnyStudy | str | Path

PAGE = 200


class Client:
    """A connection to a damperlab service.

    Parameters
    ----------
    url : str
        Address of `damperlab serve`.
    api_key : str, optional
        Key of the service, from `damperlab admin keys create`; sent as ``Authorization: Bearer …``. By default the key
        is read from ``DAMPERLAB_KEY``, or from the file that ``DAMPERLAB_KEY_FILE`` names.
    timeout : float
        Longest wait for an answer [s]. The first simulation of a new installation takes longer, because kernels are
        compiled.

    Raises
    ------
    Refused
        If `url` is not an address.

    Examples
    --------
    >>> with Client() as client:  # doctest: +SKIP
    ...     study = client.submit("figure-11").wait()
    ...     best = study.optimal_designs(exclude_locked=True)
    """

    def __init__(
        self, url: str = "http://127.0.0.1:8000", api_key: str | None = None, timeout: float = 120.0
    ) -> None:
        self._transport = Transport(url, api_key, timeout)

    def __enter__(self) -> "Client":
        """Return the client."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the connections."""
        self.close()

    def close(self) -> None:
        """Close the connections; running studies continue."""
        self._transport.close()

    def __repr__(self) -> str:
        """Show the address of the service."""
        return f"Client({self._transport.url!r})"

    def _repr_html_(self) -> str:
        """Show the address of the service in a notebook, without a request."""
        return card("damperlab service", [("address", self._transport.url)])

    def submit(self, study: "Definition", reuse: bool = True, priority: int = 0) -> Study:
        """Submit a study. If the same study exists already, it is returned and not computed again.

        Parameters
        ----------
        study : mapping, Study, path or str
            The study as a mapping or a checked `damperlab.Study`; a path of a .json, .yaml or .yml file; a text of
            YAML; or the name of a built-in study, for example ``"figure-11"``.
        reuse : bool
            Reuse points already computed by earlier studies.
        priority : int
            Priority from −10 to 10; the waiting study with the highest priority starts first. A priority above 0 needs
            a key of scope admin.

        Returns
        -------
        Study
            The stored study in its present state.

        Raises
        ------
        Refused
            If the study has faults. The exception lists every fault with field, found value, allowed values and advice.
        """
        asked = {"reuse": reuse, "priority": priority}
        return Study(self._transport, self._transport.ask("POST", "/studies", params=asked, **_study(study)))

    def submit_all(
        self, studies: "Iterable[Definition]", reuse: bool = True, priority: int = 0
    ) -> list[Study]:
        """Submit many studies, in requests of up to 200 studies. A request stores all of its studies or none.

        Parameters
        ----------
        studies : iterable
            The studies, each in a form that `submit` accepts.
        reuse : bool
            Reuse points already computed by earlier studies.
        priority : int
            Priority of every study, as for `submit`.

        Returns
        -------
        list of Study
            The studies in the given order.

        Raises
        ------
        Refused
            If studies have faults. The exception lists all faults of a request; the field of a fault begins with the
            position of the study in the request.
        """
        every = [_document(study) for study in studies]
        found: list[Study] = []
        for start in range(0, len(every), MOST_STUDIES):
            sent = body(every[start : start + MOST_STUDIES])
            asked = {"reuse": reuse, "priority": priority}
            answer = self._transport.ask("POST", "/studies", params=asked, **sent)
            found += [Study(self._transport, document) for document in answer["studies"]]
        return found

    def estimate(self, study: "Definition") -> Estimate:
        """Estimate the cost of a study; nothing is stored.

        Parameters
        ----------
        study : mapping, path or str
            The study, as for `submit`.

        Raises
        ------
        Refused
            If the study has faults.
        """
        answer = self._transport.ask("POST", "/studies", params={"dry_run": True}, **_study(study))
        names = ("digest", "points", "blocks", "bytes", "seconds", "definition")
        # an older service does not send these fields
        more = {
            name: answer[name]
            for name in ("compiling_seconds", "seconds_low", "seconds_high")
            if name in answer
        }
        told = tuple(answer.get("understood", ()))
        return Estimate(**{name: answer[name] for name in names}, **more, understood=told)

    def study(self, reference: str) -> Study:
        """Find a study.

        Parameters
        ----------
        reference : str
            Id of the study, the beginning of its id, or its name.

        Raises
        ------
        NotFound
            If there is no such study.
        """
        from urllib.parse import quote

        return Study(self._transport, self._transport.ask("GET", f"/studies/{quote(reference, safe='')}"))

    def studies(
        self,
        state: State | None = None,
        name: str | None = None,
        tag: str | None = None,
        within: "tuple[str, float | None, float | None] | None" = None,
        designs: bool = False,
    ) -> list[Study]:
        """List the studies of the service, newest first.

        Parameters
        ----------
        state : str, optional
            List only studies in this state.
        name : str, optional
            List only studies whose name contains this text.
        tag : str, optional
            List only studies with this tag; see `Study.remark`.
        within : (str, float or None, float or None), optional
            List only studies whose values along a dimension overlap a range, for example
            ``("clearance_ratio", 2, 5)``. None leaves an end of the range open.
        designs : bool
            Also list the studies that belong to designs and refinements. If `name`, `tag`, or a state other
            than ``done`` is given, the list contains such studies in any case.

        Raises
        ------
        Refused
            If there is no such dimension, or the tag is invalid.
        """
        axis, low, high = within or (None, None, None)
        asked = {"state": state, "name": name, "tag": tag, "axis": axis, "from": low, "to": high}
        if designs:
            asked["designs"] = True
        return list(self._pages(asked))

    def _pages(self, asked: Mapping[str, Any]) -> Iterator[Study]:
        cursor = None
        while True:
            page = self._transport.ask("GET", "/studies", params={"limit": PAGE, **asked, "cursor": cursor})
            yield from (Study(self._transport, document) for document in page["studies"])
            cursor = page["cursor"]
            if cursor is None:
                return

    @explained(Simulated)
    def simulate(
        self,
        frequency_ratio: float = DESIGN_POINT["frequency_ratio"],
        *,
        clearance_ratio: float = DESIGN_POINT["clearance_ratio"],
        friction_ratio: float = DESIGN_POINT["friction_ratio"],
        restitution: float = DESIGN_POINT["restitution"],
        mass_ratio: float = DESIGN_POINT["mass_ratio"],
        damping_ratio: float = DESIGN_POINT["damping_ratio"],
        particle: bool = True,
        contact: Mapping[str, Any] | None = None,
        cycles: int | None = None,
        history: int | None = None,
        samples: int | None = None,
        excitation: Excitation = Simulated.excitation,
        particle_friction_ratio: float = 0.0,
        gravity_ratio: float = 0.0,
        method: Method = Simulated.method,
        starts: int = Simulated.starts,
        seed: int = Simulated.seed,
    ) -> Simulation:
        """Compute one design point, and wait for the result.

        The design point is given by ``frequency_ratio``, ``clearance_ratio``, ``friction_ratio``, ``restitution``,
        ``mass_ratio`` and ``damping_ratio``. If ``particle`` is False, clearance, restitution and mass ratio have no
        effect. ``particle_friction_ratio`` and ``gravity_ratio`` are the friction and the gravity on the particle in
        its cavity. The ``contact`` is written as in a study, ``{"model": "dwell", "contact_time": 0.1}``.

        Returns
        -------
        Simulation
            Results, final state and time history of the design point.

        Raises
        ------
        Refused
            If the request has faults.
        """
        ratios = {
            "damping_ratio": damping_ratio,
            "friction_ratio": friction_ratio,
            "frequency_ratio": frequency_ratio,
            "particle_friction_ratio": particle_friction_ratio,
            "gravity_ratio": gravity_ratio,
        }
        if particle:
            ratios |= {
                "restitution": restitution,
                "mass_ratio": mass_ratio,
                "clearance_ratio": clearance_ratio,
            }
        asked = given(
            Simulated(
                cycles=cycles,
                method=method,
                history=history,
                samples=samples,
                excitation=excitation,
                starts=starts,
                seed=seed,
            )
        )
        document: dict[str, Any] = {**ratios, **asked, "particle": particle}
        if contact is not None:
            document["contact"] = contact
        answer = self._transport.ask("POST", "/simulate", **body(document))
        from damperlab.service.client.answers import read_history

        names = ("metrics", "status", "response_class", "state", "events", "cycles")
        found = {name: answer[name] for name in names}
        return Simulation(
            **found,
            history=read_history(answer["history"]),
            ratios=ratios,
            attractors=answer.get("attractors"),
        )

    def design(self, specification: "Specification") -> Design:
        """Request the design of a damper from a specification. If the design exists already, it is returned unchanged.

        Parameters
        ----------
        specification : mapping, path or str
            The specification as a mapping; a path of a .json, .yaml or .yml file; a text of YAML; or the name of a
            built-in specification, for example ``"prototype"``.

        Returns
        -------
        Design
            The design, queued or in a later state.

        Raises
        ------
        Refused
            If the specification has faults. The exception lists every fault with field, found value, allowed values and
            advice.
        """
        return ask_for(self._transport, specification)

    def fit(
        self,
        measured: str | Path,
        fit: "Ranges",
        structure: Mapping[str, Any] | None = None,
        *,
        deviation: float | None = None,
        confidence: float | None = None,
        seed: int | None = None,
    ) -> dict[str, Any]:
        """Estimate parameters of a prototype from its measured response or time history, as `damperlab fit` does.

        Parameters
        ----------
        measured : path or str
            Path of a table whose first line names the columns with their units, or the text of the table.
        fit : mapping or iterable of str
            Parameters to estimate. A mapping gives the lowest and highest value of each parameter, or None for the
            default range. An iterable gives only the names, with default ranges.
        structure : mapping, optional
            Known values of the prototype, written as in a study. A parameter given as an axis is estimated within the
            range of the axis.
        deviation : float, optional
            Standard deviation of each amplitude relative to the amplitude, if the table states none.
        confidence : float, optional
            Confidence of the intervals; by default 0.95.
        seed : int, optional
            Seed of the random draws.

        Returns
        -------
        dict
            The output of `damperlab fit --json`: ``parameters``, ``words``, ``rows``, the prototype as a ``study`` …

        Raises
        ------
        Refused
            If the request has faults, or if the fit exceeds the time limit of a request. The command line has no such
            limit.
        """
        document = question(measured, fit, structure, deviation=deviation, confidence=confidence, seed=seed)
        answer: dict[str, Any] = self._transport.ask("POST", "/fits", **body(document))
        return answer

    def designs(self, state: State | None = None, name: str | None = None) -> list[Design]:
        """List the designs of the service, newest first.

        Parameters
        ----------
        state : str, optional
            List only designs in this state.
        name : str, optional
            List only designs whose name contains this text.
        """
        found: list[Design] = []
        cursor = None
        while True:
            asked = {"limit": PAGE, "state": state, "name": name, "cursor": cursor}
            page = self._transport.ask("GET", "/designs", params=asked)
            found += [Design(self._transport, document) for document in page["designs"]]
            cursor = page["cursor"]
            if cursor is None:
                return found

    def accuracy(self) -> Accuracy:
        """Return the service's last report of `damperlab check accuracy`.

        Raises
        ------
        NotFound
            If the service's data directory has no report.
        """
        report = self._transport.ask("GET", "/accuracy")
        names = ("created", "version", "passed", "stability")
        return Accuracy(**{name: report[name] for name in names}, document=report)

    def records(self) -> "list[GroundRecord]":
        """List the ground-motion records of the service, the built-in ones first."""
        from damperlab.service.client.earthquake import read_ground_record

        return [read_ground_record(each) for each in self._transport.ask("GET", "/records")["records"]]

    def upload_record(
        self, path: str | Path, name: str = "", units: AccelerationUnits | str | None = None
    ) -> "GroundRecord":
        """Upload a ground motion. If a stored record has the same samples, the stored record is returned.

        Parameters
        ----------
        path : path
            A PEER file (.at2), or a file of two columns, time [s] and acceleration.
        name : str
            Name of the record; by default the name of the file without its suffix.
        units : str, optional
            Unit of the acceleration, such as "g", "m/s2" or "gal", if the file does not state the unit.

        Raises
        ------
        Refused
            If the file cannot be read as a record.
        """
        from damperlab.service.client.earthquake import read_ground_record, upload

        return read_ground_record(self._transport.ask("POST", "/records", **upload(Path(path), name, units)))

    @explained(Compared)
    def earthquake_comparison(
        self,
        record: "str | GroundRecord | Mapping[str, Any]" = Compared.record,
        cases: Sequence[str] | None = None,
        starts: int = Compared.starts,
        seed: int = Compared.seed,
        tmd_criterion: Criterion = Compared.tmd_criterion,
        contact: Mapping[str, Any] | None = None,
        **values: float,
    ) -> "DamperComparison":
        """Compare dampers under a ground motion, as in the paper's Table A1.

        The record may be a `GroundRecord`, or the definition of a generated one: ``{"kanai_tajimi": {"seed": 1}}``,
        ``{"sweep": {…}}``, ``{"random_vibration": {…}}`` or ``{"shock": {…}}``. The ``contact`` is written as in a
        study, ``{"model": "dwell", "contact_time": 0.1}``. Other keyword arguments change values of the paper's
        prototype: ``scale``, ``mass_kg``, ``natural_frequency_hz``, ``damping_ratio``, ``particle_mass_kg``,
        ``clearance_m``, ``restitution``, ``friction_force_n``, ``tmd_mass_kg``, ``tail_s``, ``perturbation_m``.

        Returns
        -------
        DamperComparison
            Peak and rms of displacement [m] and acceleration [m/s²], number of impacts, and energy losses [J], along
            the dimension ``case``.
        """
        from damperlab.service.client.earthquake import GroundRecord, read_comparison

        compared = Compared(
            tmd_criterion=tmd_criterion,
            cases=None if cases is None else tuple(cases),
            starts=starts,
            seed=seed,
        )
        document: dict[str, Any] = {**values, **given(compared)}
        document["record"] = record.id if isinstance(record, GroundRecord) else record
        if contact is not None:
            document["contact"] = dict(contact)
        return read_comparison(self._transport.ask("POST", "/earthquake-comparisons", **body(document)))


def _study(study: "Definition") -> dict[str, Any]:
    """Return the arguments of `Transport.ask` that send a study."""
    if callable(document := getattr(study, "document", None)):
        return body(document())
    if isinstance(study, Mapping):
        return body(study)
    if isinstance(study, str) and ("\n" in study or ": " in study or study.startswith("{")):
        return _written(study.encode(), "yaml")
    if not isinstance(study, str | Path):
        advice = "give a mapping, a path, a text of YAML, or a name like figure-11"
        told = f"A study cannot be read from {describe(study)}."
        raise refused((Fault("study", describe(study), "a study", advice, told),))
    path = Path(study)
    kind = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}.get(path.suffix.lower())
    if kind is not None and path.is_file():
        return _written(path.read_bytes(), kind)
    from damperlab.studies.reading import read_study

    try:
        return body(read_study(str(study)).document())
    except StudyFaults as error:
        raise refused(error.faults) from None


def _document(study: "Definition") -> Any:
    sent = _study(study)
    if sent["headers"]["Content-Type"] == "application/json":
        return json.loads(sent["content"])
    try:
        return load_text(sent["content"], "yaml")
    except StudyFaults as error:
        raise refused(error.faults) from None


def _written(text: bytes, kind: str) -> dict[str, Any]:
    return {"content": text, "headers": {"Content-Type": f"application/{kind}"}}
